// How far points and faces lie from a surface of faces: the measure behind the baseline and the bound of needles.
#pragma once

#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

// Greatest distance of any of the queries from the faces; `faces` must not be empty and in range.
// Stops early with a greater value than `limit` once one query lies beyond it. About O((n + m) log m).
double farthest(std::span<const Vec3> queries, std::span<const Vec3> points, std::span<const Face> faces,
                double limit);

// For each three corners in a row, how far any point of their face is from `faces` at most. It is never too small,
// and exact but for `precision`, or for `enough` or the height of the face where it is less than those.
// O(log m) for each place where the face leaves one of `faces` for another.
std::vector<double> reach_of(std::span<const Vec3> corners, std::span<const Vec3> points, std::span<const Face> faces,
                             double enough, double precision);

}  // namespace bldsimp
