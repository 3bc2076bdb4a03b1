// Find the eigenvectors of symmetric 3 x 3 matrices, without any library, so that every machine gets the same bits.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct EigenSystem {
  std::array<double, 3> values;
  Triangle vectors;  // of unit length
};

// Of the matrix with these entries: xx xy xz yy yz zz.
EigenSystem decompose(const std::array<double, 6>& matrix);

}  // namespace bldsimp
