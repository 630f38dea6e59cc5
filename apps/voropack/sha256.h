// SHA-256 (FIPS 180-4) of a file, which names an input in a report.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace voropack::app {

class Sha256 {
 public:
  void add(std::string_view bytes);
  /// The digest of everything added, as 64 hexadecimal digits. Call once.
  std::string finish();

 private:
  void add_block(const char* block);

  std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<char, 64> pending_{};
  std::size_t n_pending_ = 0;
  std::uint64_t n_bytes_ = 0;
};

/// Nothing if the file cannot be read.
std::optional<std::string> sha256_of_file(const std::filesystem::path& path);

}  // namespace voropack::app
