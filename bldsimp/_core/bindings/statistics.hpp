// Give the statistics of triangulations to Python.
#pragma once

#include "bindings/cast.hpp"
#include "cdt/cdt.hpp"

namespace bldsimp {

inline auto row_of(const Statistics& counts) {
  return std::tuple(counts.by_poles, counts.by_determinant, counts.located, counts.walked, counts.flips);
}

}  // namespace bldsimp
