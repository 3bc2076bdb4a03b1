// Loop over independent items on all cores that the process may use.
#pragma once

#ifdef __linux__
#include <sched.h>
#endif

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <limits>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "mesh/array.hpp"

namespace bldsimp {

inline constexpr std::size_t least_parallel_work = 1 << 15;  // below this, a thread costs more than it saves

// How many threads can run at once: a share of a machine, as a scheduler gives it out, may be less than its cores.
inline std::size_t core_count() {
#ifdef __linux__
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof cores, &cores) == 0) return static_cast<std::size_t>(std::max(1, CPU_COUNT(&cores)));
#endif
  return std::max(1u, std::thread::hardware_concurrency());
}

// At most so many threads at once, for the whole process: one where processes share the cores already.
inline std::atomic<std::size_t> most_threads = std::numeric_limits<std::size_t>::max();

// Calls run(begin, end) on ranges that together are 0 .. count. Each item must write to places of its
// own, so that the result is the same with any number of threads.
template <class Run>
void parallel_for(std::size_t count, Run run, std::size_t least_work = least_parallel_work) {
  const std::size_t threads =
      std::clamp<std::size_t>(count / least_work, 1, std::min(core_count(), most_threads.load()));
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < threads; ++i)
    others.emplace_back([=, &run] { run(count * i / threads, count * (i + 1) / threads); });
  run(0, count / threads);
}

// Calls each(Index i) for all items, in such ranges.
template <class Each>
void parallel_each(std::size_t count, Each each, std::size_t least_work = least_parallel_work) {
  parallel_for(
      count,
      [&](std::size_t begin, std::size_t end) {
        for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i) each(i);
      },
      least_work);
}

// Calls make(begin, end) on such ranges, and take(what it made) in their order.
template <class Make, class Take>
void parallel_collect(std::size_t count, Make make, Take take, std::size_t least_work = least_parallel_work) {
  std::map<std::size_t, decltype(make(count, count))> made;
  std::mutex making;
  parallel_for(
      count,
      [&](std::size_t begin, std::size_t end) {
        auto own = make(begin, end);
        const std::scoped_lock lock(making);
        made.emplace(begin, std::move(own));
      },
      least_work);
  for (auto& [begin, own] : made) take(own);
}

}  // namespace bldsimp
