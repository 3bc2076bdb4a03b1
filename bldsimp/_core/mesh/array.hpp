// Hold an item for each face, corner or point of a mesh in arrays, and sort these into groups.
//
// All kernels include this header, and rely on it for the standard headers of arrays and algorithms.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace bldsimp {

using Index = std::int32_t;
using IndexPair = std::array<Index, 2>;
using Indices = std::span<const Index>;
using Flags = std::span<const std::uint8_t>;

// Gives large arrays huge pages where the system has them: touching fresh memory, and reaching into it at
// random, then costs a fraction. Items are set by whoever fills the array, not before.
template <class T>
struct PageAllocator {
  using value_type = T;
  static constexpr std::size_t huge_page = std::size_t{1} << 21;

  PageAllocator() = default;
  template <class U>
  PageAllocator(const PageAllocator<U>&) noexcept {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* memory = ::operator new(bytes, alignment(bytes));
#if defined(__linux__)
    if (bytes >= huge_page) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept { ::operator delete(memory, alignment(count * sizeof(T))); }

  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Args>
  void construct(U* place, Args&&... args) {
    ::new (static_cast<void*>(place)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const PageAllocator&, const PageAllocator&) { return true; }

 private:
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{bytes >= huge_page ? huge_page : alignof(std::max_align_t)};
  }
};

// A vector whose items are not set by `resize` or the constructor from a size alone.
template <class T>
using Array = std::vector<T, PageAllocator<T>>;

// 0 .. count - 1.
inline std::vector<Index> list_indices(std::size_t count) {
  std::vector<Index> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

template <class Items>
void sort_unique(Items& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

template <class Items, class More>
void append(Items& items, const More& more) {
  items.insert(items.end(), more.begin(), more.end());
}

// Calls visit(span) for each run of items of which same(first, other) holds.
template <class Items, class Same, class Visit>
void for_runs(Items& items, Same same, Visit visit) {
  for (auto from = items.begin(); from != items.end();) {
    const auto to = std::find_if(from + 1, items.end(), [&](const auto& item) { return !same(*from, item); });
    visit(std::span(from, to));
    from = to;
  }
}

// Items by the group that each is in: those of group g in rising order. O(items + groups).
struct Groups {
  Groups() = default;
  template <class GroupOf>
  Groups(std::size_t groups, std::size_t items, GroupOf group_of) : start(groups + 1, 0), members(items) {
    const auto count = static_cast<Index>(items);
    for (Index i = 0; i < count; ++i) ++start[group_of(i) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    Array<Index> cursor(start.begin(), start.end() - 1);
    for (Index i = 0; i < count; ++i) members[cursor[group_of(i)]++] = i;
  }
  Indices operator[](Index group) const { return {members.data() + start[group], members.data() + start[group + 1]}; }

  Array<Index> start, members;
};

}  // namespace bldsimp
