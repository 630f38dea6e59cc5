// What was built, as known when CMake ran.
#pragma once

#include <string_view>

namespace voropack::app {

std::string_view version();
std::string_view commit();  ///< Empty if the sources were not a git checkout.

}  // namespace voropack::app
