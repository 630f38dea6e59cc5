// One input file in memory, and how its faults are told.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "voropack/error.h"

namespace voropack::io {

/// The content of one input, and its name for messages. Readers take this, so that they also run on memory.
struct Source {
  std::string file;
  std::string_view bytes;
};

struct FileContent {
  std::string file;
  std::string bytes;
  [[nodiscard]] Source source() const { return {file, bytes}; }
};

/// Reads a whole regular file. Throws: InputError io.cannot_open, io.empty_file.
FileContent read_file(const std::filesystem::path& path);

/// The file, or nothing where there is none. Throws as read_file for one that is there and cannot be read.
std::optional<FileContent> read_file_if_present(const std::filesystem::path& path);

/// Throws InputError.
[[noreturn]] void fail(const std::string& file, std::string id, std::string message, std::string fix,
                       std::optional<std::uint64_t> line = {});

/// The lower-case extension with its dot, such as ".off".
std::string lower_extension(const std::filesystem::path& path);

/// `text` cut to a printable length with unprintable bytes replaced: what a message may quote of a file.
std::string quote(std::string_view text);

/// More elements than 32-bit ids can name is a LimitError.
void check_id_range(const std::string& file, std::string_view kind, std::uint64_t count);

}  // namespace voropack::io
