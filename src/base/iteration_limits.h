// Refusals of limits that no iteration could keep.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "voropack/error.h"

namespace voropack {

/// Throws OptionError `id` unless the relative `tolerance` is between 0 and 1 and `most` is at least 1. In the message
/// `method` may make `most` times what `steps` names.
inline void check_iteration_limits(const std::string& id, std::string_view method, double tolerance, int most,
                                   std::string_view steps) {
  if (!(tolerance > 0 && tolerance < 1))
    throw OptionError(Fault{.id = id,
                            .message = fmt::format("the tolerance of {} is {}", method, tolerance),
                            .fix = "choose it between 0 and 1"});
  if (most < 1)
    throw OptionError(
        Fault{.id = id, .message = fmt::format("{} may make {} {}", method, most, steps), .fix = "allow at least 1"});
}

}  // namespace voropack
