// Test data that is not part of the project: found beside it, or where VOROPACK_SHARED says.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>

namespace voropack::test {

/// The path of a file or folder in the shared data, such as "plc/solids/cubes.off"; nothing if it is absent.
/// Tests run in the project's root, and their data is in `../shared/data`, unless the environment says otherwise.
inline std::optional<std::filesystem::path> shared_data(std::string_view relative) {
  const char* const folder = std::getenv("VOROPACK_SHARED");
  std::filesystem::path path = folder != nullptr ? std::filesystem::path(folder) : std::filesystem::path("../shared");
  path = path / "data" / relative;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  return path;
}

}  // namespace voropack::test
