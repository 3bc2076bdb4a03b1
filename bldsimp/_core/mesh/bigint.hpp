// Compute with whole numbers of any length: the last resort of the predicates, for coordinates so far apart in
// magnitude that expansions would overflow or underflow. Slow, short, and exact for every double.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace bldsimp {

class BigInt {
 public:
  BigInt() = default;
  // value * 2^-exponent, which must be whole.
  BigInt(double value, int exponent) {
    if (value == 0.0) return;
    int power;
    const double fraction = std::frexp(std::abs(value), &power);
    auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
    int shift = power - 53 - exponent;
    for (; shift < 0; ++shift) mantissa >>= 1;  // only zero bits, since the result is whole
    negative_ = value < 0.0;
    digit_.assign(static_cast<std::size_t>(shift / 32), 0);
    const int bits = shift % 32;
    digit_.push_back(static_cast<std::uint32_t>(mantissa << bits));
    digit_.push_back(static_cast<std::uint32_t>((mantissa >> (32 - bits)) & 0xffffffffu));
    digit_.push_back(bits == 0 ? 0 : static_cast<std::uint32_t>(mantissa >> (64 - bits)));
    trim();
  }

  int sign() const { return digit_.empty() ? 0 : (negative_ ? -1 : 1); }

  friend BigInt operator-(BigInt a) {
    a.negative_ = !a.negative_;
    return a;
  }
  friend BigInt operator+(const BigInt& a, const BigInt& b) {
    if (a.negative_ == b.negative_) return with_sign(combine(a.digit_, b.digit_, 1), a.negative_);
    return less(a.digit_, b.digit_) ? with_sign(combine(b.digit_, a.digit_, -1), b.negative_)
                                    : with_sign(combine(a.digit_, b.digit_, -1), a.negative_);
  }
  friend BigInt operator-(const BigInt& a, const BigInt& b) { return a + (-b); }
  friend BigInt operator*(const BigInt& a, const BigInt& b) {
    Digits product(a.digit_.size() + b.digit_.size(), 0);
    for (std::size_t i = 0; i < a.digit_.size(); ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < b.digit_.size(); ++j) {
        carry += std::uint64_t{a.digit_[i]} * b.digit_[j] + product[i + j];
        product[i + j] = static_cast<std::uint32_t>(carry);
        carry >>= 32;
      }
      product[i + b.digit_.size()] = static_cast<std::uint32_t>(carry);
    }
    return with_sign(std::move(product), a.negative_ != b.negative_);
  }

 private:
  using Digits = std::vector<std::uint32_t>;  // least first, no leading zero

  static BigInt with_sign(Digits digits, bool negative) {
    BigInt result;
    result.digit_ = std::move(digits);
    result.negative_ = negative;
    result.trim();
    return result;
  }
  void trim() {
    while (!digit_.empty() && digit_.back() == 0) digit_.pop_back();
  }
  static bool less(const Digits& a, const Digits& b) {
    if (a.size() != b.size()) return a.size() < b.size();
    return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
  }
  // a + sign * b, which must not be negative.
  static Digits combine(const Digits& a, const Digits& b, int sign) {
    Digits result(std::max(a.size(), b.size()) + 1, 0);
    std::int64_t carry = 0;
    for (std::size_t i = 0; i < result.size(); ++i) {
      carry += (i < a.size() ? std::int64_t{a[i]} : 0) + sign * (i < b.size() ? std::int64_t{b[i]} : 0);
      result[i] = static_cast<std::uint32_t>(carry & 0xffffffff);
      carry >>= 32;
    }
    return result;
  }

  Digits digit_;
  bool negative_ = false;
};

}  // namespace bldsimp
