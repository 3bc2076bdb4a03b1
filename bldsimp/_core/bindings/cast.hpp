// Cast NumPy arrays to what kernels take, and what kernels give to NumPy arrays, without a copy.
//
// A kernel's spans are read-only views of the caller's arrays; nanobind converts an array of another type or layout
// before. A kernel's vectors move into capsules that own them.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <optional>
#include <tuple>

#include "mesh/vec3.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace bldsimp {

// What an item of an array is made of: rows of `width` scalars, or plain scalars.
template <class Item>
struct ItemTraits;
template <class Number>
  requires std::is_arithmetic_v<Number>
struct ItemTraits<Number> {
  using Scalar = Number;
};
template <>
struct ItemTraits<bool> {
  using Scalar = std::uint8_t;
};
template <class Choice>
  requires std::is_enum_v<Choice>
struct ItemTraits<Choice> {
  using Scalar = std::underlying_type_t<Choice>;
};
template <class Number, std::size_t count>
struct ItemTraits<std::array<Number, count>> {
  using Scalar = Number;
};
template <>
struct ItemTraits<Point2> {
  using Scalar = double;
};
template <>
struct ItemTraits<Vec3> {
  using Scalar = double;
};

template <class Item>
using ScalarOf = typename ItemTraits<Item>::Scalar;
template <class Item>
inline constexpr std::size_t width_of = sizeof(Item) / sizeof(ScalarOf<Item>);
template <class Item>
concept ArrayItem = requires { typename ItemTraits<Item>::Scalar; };

template <class Item>
using ShapeOf = std::conditional_t<width_of<Item> == 1, nb::shape<-1>, nb::shape<-1, nb::ssize_t{width_of<Item>}>>;
template <class Item>
using Input = nb::ndarray<const ScalarOf<Item>, ShapeOf<Item>, nb::c_contig, nb::device::cpu>;

template <class Item>
std::span<const Item> view(const Input<Item>& array) {
  return {reinterpret_cast<const Item*>(array.data()), array.shape(0)};
}

// A NumPy array over items that `owner` keeps alive.
template <class Scalar, class Item>
auto wrap(Scalar* data, std::span<const Item> items, nb::handle owner) {
  if constexpr (width_of<Item> == 1)
    return nb::ndarray<nb::numpy, Scalar>(data, {items.size()}, owner);
  else
    return nb::ndarray<nb::numpy, Scalar>(data, {items.size(), width_of<Item>}, owner);
}

template <class Vector>
auto give(Vector&& items) {
  using Item = typename Vector::value_type;
  auto* owned = new Vector(std::move(items));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<Vector*>(p); });
  return wrap(reinterpret_cast<ScalarOf<Item>*>(owned->data()), std::span<const Item>(*owned), owner);
}

// Read-only properties: views of the vectors inside a kernel's result, which they keep alive.
template <class Class>
void def_views(Class&) {}
template <class Class, class Result, class Vector, class... Rest>
void def_views(Class& c, const char* name, Vector Result::* member, Rest... rest) {
  using Item = typename Vector::value_type;
  c.def_prop_ro(name, [member](nb::handle self) {
    const std::span<const Item> items(nb::cast<const Result&>(self).*member);
    return wrap(reinterpret_cast<const ScalarOf<Item>*>(items.data()), items, self);
  });
  def_views(c, rest...);
}

// A property with one member of each of some structs, which `items(self)` gives.
template <class Class, class Items, class Item, class Member>
void def_column(Class& c, const char* name, Items items, Member Item::* member) {
  using Self = typename Class::Type;
  c.def_prop_ro(
      name,
      [items, member](const Self& self) {
        std::vector<ScalarOf<Member>> column;
        for (const Item& item : items(self)) column.push_back(item.*member);
        return give(std::move(column));
      },
      nb::rv_policy::automatic);
}

// A function as Python calls it: without the interpreter's lock.
template <class Result, class... Args>
auto unlocked(Result (*kernel)(Args...)) {
  return [kernel](Args... args) -> Result {
    nb::gil_scoped_release release;
    return kernel(static_cast<Args&&>(args)...);
  };
}
template <class Result, class Self, class... Args>
auto unlocked(Result (Self::*kernel)(Args...) const) {
  return [kernel](const Self& self, Args... args) -> Result {
    nb::gil_scoped_release release;
    return (self.*kernel)(static_cast<Args&&>(args)...);
  };
}
// The same for a kernel that gives two things, of which Python gets a tuple.
template <class Result, class... Args>
auto unlocked_pair(Result (*kernel)(Args...)) {
  return [kernel](Args... args) {
    nb::gil_scoped_release release;
    auto [first, second] = kernel(static_cast<Args&&>(args)...);
    return std::tuple(std::move(first), std::move(second));
  };
}
template <class Kernel>
auto unlocked(Kernel kernel) {
  return unlocked(+kernel);
}

// Throws where the kernel's preconditions do not hold; who calls then says which rows are to blame.
inline void check_range(Indices indices, std::size_t count) {
  bool within = true;
  for (const Index index : indices) within &= static_cast<std::size_t>(index) < count;
  if (!within) throw nb::index_error("index out of range");
}
inline void check_range(Faces faces, std::size_t count) {
  check_range(Indices(faces.empty() ? nullptr : faces[0].data(), 3 * faces.size()), count);
}

void bind_mesh(nb::module_& m);
void bind_cdt(nb::module_& m);
void bind_planar(nb::module_& m);
void bind_collapse(nb::module_& m);

}  // namespace bldsimp

namespace nanobind::detail {

// None, where an argument may be that, is an empty span.
template <bldsimp::ArrayItem Item>
struct type_caster<std::span<const Item>> {
  NB_TYPE_CASTER(std::span<const Item>, make_caster<bldsimp::Input<Item>>::Name)
  template <class CastFlags>
  bool from_python(handle source, CastFlags flags, cleanup_list* cleanup) noexcept {
    if (source.is_none()) return true;
    if (!array.from_python(source, flags, cleanup)) return false;
    value = bldsimp::view<Item>(array.value);
    return true;
  }
  make_caster<bldsimp::Input<Item>> array;
};

template <bldsimp::ArrayItem Item, class Allocator>
struct type_caster<std::vector<Item, Allocator>> {
  using Vector = std::vector<Item, Allocator>;
  using Output = decltype(bldsimp::give(std::declval<Vector>()));
  NB_TYPE_CASTER(Vector, make_caster<Output>::Name)
  static handle from_cpp(Vector&& items, rv_policy policy, cleanup_list* cleanup) noexcept {
    return make_caster<Output>::from_cpp(bldsimp::give(std::move(items)), policy, cleanup);
  }
};

}  // namespace nanobind::detail
