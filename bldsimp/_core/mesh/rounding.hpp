// Round a place as it will be written.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// How coordinates that change are stored.
struct Rounding {
  int decimals;  // below 0 where none may change
  bool single;   // rounded to single precision after that

  Vec3 operator()(Vec3 p) const {
    const double scale = std::pow(10.0, decimals);
    for (double* x : {&p.x, &p.y, &p.z}) {
      if (std::abs(*x) * scale < 0x1p52) *x = std::round(*x * scale) / scale;
      if (single) *x = static_cast<float>(*x);
    }
    return p;
  }
};

}  // namespace bldsimp
