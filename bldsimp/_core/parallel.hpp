// Loops over independent items on all cores.
#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace bldsimp {

inline constexpr std::size_t least_parallel_work = 1 << 15;  // below this, a thread costs more than it saves

// Calls run(begin, end) on ranges that together are 0 .. count. Each item must write to places of its
// own, so that the result is the same with any number of threads.
template <class Run>
void parallel_for(std::size_t count, Run run, std::size_t least_work = least_parallel_work) {
  const std::size_t threads =
      std::clamp<std::size_t>(count / least_work, 1, std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < threads; ++i)
    others.emplace_back([=, &run] { run(count * i / threads, count * (i + 1) / threads); });
  run(0, count / threads);
}

}  // namespace bldsimp
