// Files that appear whole or not at all: written beside their place under a temporary name, renamed when complete.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace voropack::io {

/// One output file. Until `rename` the temporary is removed by the destructor. A place that holds something other than
/// a regular file, such as /dev/stdout, is written to directly.
///
/// All functions throw InputError io.cannot_write with the system's reason.
class AtomicFile {
 public:
  /// Makes missing parent folders and opens the temporary.
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  /// Appends.
  void write(std::string_view bytes);
  /// The number of bytes appended so far.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  /// Overwrites bytes that were appended earlier. Not for what is written to directly.
  void overwrite(std::uint64_t position, std::string_view bytes);

  /// All is written: hands the rest to the system and closes, so that a full disk shows now.
  void finish();
  /// Puts the finished file into its place.
  void rename();

 private:
  void flush();
  void write_out(std::string_view bytes, std::uint64_t position);
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  std::filesystem::path temporary_;  ///< Empty if written directly, or once renamed.
  int fd_ = -1;
  std::string buffer_;
  std::uint64_t position_ = 0;
};

}  // namespace voropack::io
