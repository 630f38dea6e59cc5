// Points in words, for messages.
#pragma once

#include <fmt/format.h>

#include <string>

#include "voropack/vec.h"

namespace voropack {

/// "(0.5, 0.25)": ten digits tell points apart that lie far from the origin, too.
template <int D>
std::string place_text(const Vec<D>& x) {
  std::string text = "(";
  for (int k = 0; k < D; ++k) text += fmt::format("{}{:.10g}", k > 0 ? ", " : "", x[k]);
  return text + ')';
}

}  // namespace voropack
