// Add and multiply doubles exactly, as expansions: sums of terms that do not overlap, least first.
//
// Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997. Zero terms are dropped as they arise, so that short numbers (grids, single
// precision) cost a fraction of the worst case.
// Precondition: no operation overflows or underflows; `predicates.cpp` sees to it.
#pragma once

#include <cmath>

namespace bldsimp {

template <int N>
struct Expansion {
  double term[N];
  int size = 0;

  Expansion() = default;
  Expansion(const Expansion& other) { *this = other; }
  // Only the terms in use: capacities are large, sizes seldom are.
  Expansion& operator=(const Expansion& other) {
    size = other.size;
    for (int i = 0; i < size; ++i) term[i] = other.term[i];
    return *this;
  }

  void append(double value) {
    if (value != 0.0) term[size++] = value;
  }
  int sign() const { return size == 0 ? 0 : (term[size - 1] > 0.0 ? 1 : -1); }
  // The value rounded to a double, off by a few units in the last place at most.
  double estimate() const {
    double sum = 0.0;
    for (int i = 0; i < size; ++i) sum += term[i];
    return sum;
  }
};

inline double two_sum(double a, double b, double& rest) {
  const double sum = a + b;
  const double b_part = sum - a;
  const double a_part = sum - b_part;
  rest = (a - a_part) + (b - b_part);
  return sum;
}

// Needs |a| >= |b| or a == 0.
inline double quick_two_sum(double a, double b, double& rest) {
  const double sum = a + b;
  rest = b - (sum - a);
  return sum;
}

// Halves of 26 bits by Veltkamp's split: the same on every machine, with or without an fma.
inline double two_product(double a, double b, double& rest) {
  constexpr double splitter = 134217729.0;  // 2^27 + 1
  const double a_wide = splitter * a;
  const double a_high = a_wide - (a_wide - a);
  const double a_low = a - a_high;
  const double b_wide = splitter * b;
  const double b_high = b_wide - (b_wide - b);
  const double b_low = b - b_high;
  const double product = a * b;
  rest = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
  return product;
}

inline Expansion<2> difference(double a, double b) {
  Expansion<2> result;
  double rest;
  const double sum = two_sum(a, -b, rest);
  result.append(rest);
  result.append(sum);
  return result;
}

template <int N>
Expansion<N> operator-(Expansion<N> e) {
  for (int i = 0; i < e.size; ++i) e.term[i] = -e.term[i];
  return e;
}

// Result must have room for e.size + f.size terms.
template <int N, int M, int R>
void add(const Expansion<N>& e, const Expansion<M>& f, Expansion<R>& result) {
  result.size = 0;
  int i = 0, j = 0;
  const auto least = [&] {
    const bool from_e = j == f.size || (i < e.size && std::abs(e.term[i]) < std::abs(f.term[j]));
    return from_e ? e.term[i++] : f.term[j++];
  };
  if (e.size + f.size == 0) return;
  double sum = least();
  while (i < e.size || j < f.size) {
    double rest;
    sum = two_sum(sum, least(), rest);
    result.append(rest);
  }
  result.append(sum);
}

template <int N, int M>
Expansion<N + M> operator+(const Expansion<N>& e, const Expansion<M>& f) {
  Expansion<N + M> result;
  add(e, f, result);
  return result;
}

template <int N, int M>
Expansion<N + M> operator-(const Expansion<N>& e, const Expansion<M>& f) {
  return e + (-f);
}

// Result must have room for twice e.size terms.
template <int N, int R>
void scale(const Expansion<N>& e, double factor, Expansion<R>& result) {
  static_assert(R >= 2 * N);
  result.size = 0;
  if (e.size == 0) return;
  double rest;
  double sum = two_product(e.term[0], factor, rest);
  result.append(rest);
  for (int i = 1; i < e.size; ++i) {
    double low;
    const double high = two_product(e.term[i], factor, low);
    const double middle = two_sum(sum, low, rest);
    result.append(rest);
    sum = quick_two_sum(high, middle, rest);
    result.append(rest);
  }
  result.append(sum);
}

template <int N, int M>
Expansion<2 * N * M> operator*(const Expansion<N>& e, const Expansion<M>& f) {
  Expansion<2 * N * M> result;
  if (f.size > 0) scale(e, f.term[0], result);
  for (int j = 1; j < f.size; ++j) {
    const Expansion<2 * N * M> before = result;
    Expansion<2 * N> part;
    scale(e, f.term[j], part);
    add(before, part, result);
  }
  return result;
}

}  // namespace bldsimp
