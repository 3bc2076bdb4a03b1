// How far points lie from a surface of faces: the measure behind the baseline.
#pragma once

#include <span>

#include "vec3.hpp"

namespace bldsimp {

// Greatest distance of any of the queries from the faces; `faces` must not be empty and in range.
// Stops early with a greater value than `limit` once one query lies beyond it. About O((n + m) log m).
double farthest(std::span<const Vec3> queries, std::span<const Vec3> points, std::span<const Face> faces,
                double limit);

}  // namespace bldsimp
