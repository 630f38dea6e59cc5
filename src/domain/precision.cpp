#include "domain/precision.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace voropack::domain_impl {

namespace {

/// With fewer digits than six, numbers are more likely exact than rounded; beyond nine, rounding is below any
/// tolerance.
constexpr int kFewestDigits = 6;
constexpr int kMostDigits = 9;

/// Digits of the shortest decimal that stands for x.
int n_digits(double x) {
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), std::abs(x), std::chars_format::scientific);
  return static_cast<int>(
      std::count_if(text.data(), std::find(text.data(), end, 'e'), [](char c) { return c != '.'; }));
}

bool is_single(double x) { return std::abs(x) <= std::numeric_limits<float>::max() && x == static_cast<float>(x); }

}  // namespace

double coordinate_unit(const DomainInput<3>& input) {
  double largest = 0;
  int digits = kFewestDigits;
  bool single = true;
  for (const Vec<3>& x : input.points)
    for (const double c : x.coord) {
      largest = std::max(largest, std::abs(c));
      single = single && is_single(c);
      if (digits <= kMostDigits) digits = std::max(digits, n_digits(c));
    }
  if (largest == 0) return 0;
  const double decimal = std::pow(10, std::floor(std::log10(largest)) + 1 - digits);
  const double binary = std::ldexp(std::numeric_limits<float>::epsilon(), std::ilogb(largest));
  if (single) return digits <= kMostDigits ? std::min(decimal, binary) : binary;
  return digits <= kMostDigits ? decimal : 0;
}

}  // namespace voropack::domain_impl
