// Compute with sums of two doubles, rounded to about 106 bits: the stage between the filter and expansions.
//
// Source: M. Joldes, J.-M. Muller, V. Popescu, "Tight and Rigorous Error Bounds for Basic Building
// Blocks of Double-Word Arithmetic", 2017: the sum is its algorithm 6 (relative error at most
// 3 u^2 + 13 u^3), the product its algorithm 10 (at most 7 u^2), u = 2^-53.
// Precondition: no operation overflows or underflows; `predicates.cpp` sees to it.
#pragma once

#include "mesh/expansion.hpp"

namespace bldsimp {

struct DoubleWord {
  double high, low;
};

inline DoubleWord operator-(const DoubleWord& a) { return {-a.high, -a.low}; }

inline DoubleWord operator+(const DoubleWord& a, const DoubleWord& b) {
  double rest, low_rest;
  double high = two_sum(a.high, b.high, rest);
  const double low = two_sum(a.low, b.low, low_rest);
  high = quick_two_sum(high, rest + low, rest);
  high = quick_two_sum(high, low_rest + rest, rest);
  return {high, rest};
}

inline DoubleWord operator-(const DoubleWord& a, const DoubleWord& b) { return a + (-b); }

inline DoubleWord operator*(const DoubleWord& a, const DoubleWord& b) {
  double rest;
  const double product = two_product(a.high, b.high, rest);
  const double high = quick_two_sum(product, rest + (a.high * b.low + a.low * b.high), rest);
  return {high, rest};
}

}  // namespace bldsimp
