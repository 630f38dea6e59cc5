// Points in words, for messages.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "voropack/vec.h"

namespace voropack {

/// "(0.5, 0.25)". Ten digits tell points apart that lie far from the origin, too.
template <int D>
std::string place_text(const Vec<D>& x, int n_digits = 10) {
  std::string text = "(";
  for (int k = 0; k < D; ++k) text += fmt::format("{}{:.{}g}", k > 0 ? ", " : "", x[k], n_digits);
  return text + ')';
}

/// With six significant digits, and as many more as all points in `box` have in common.
template <int D>
std::string place_text(const Vec<D>& x, const Box<D>& box) {
  constexpr int kDigits = 6, kMostInCommon = 11;
  double largest = 0;
  for (int k = 0; k < D; ++k) largest = std::max({largest, std::abs(box.lo[k]), std::abs(box.hi[k])});
  const double common = std::log10(largest / box.diagonal());
  const int more = common > 0 ? static_cast<int>(std::ceil(std::min<double>(common, kMostInCommon))) : 0;
  return place_text(x, kDigits + more);
}

}  // namespace voropack
