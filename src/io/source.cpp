#include "io/source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <limits>

namespace voropack::io {

namespace {

/// A file descriptor that closes itself.
struct Descriptor {
  int fd;
  explicit Descriptor(int d) : fd(d) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

[[noreturn]] void cannot_open(const std::filesystem::path& path, std::string_view reason, std::string fix) {
  fail(path.string(), "io.cannot_open", fmt::format("cannot be read: {}", reason), std::move(fix));
}

}  // namespace

FileContent read_file(const std::filesystem::path& path) {
  // Non-blocking, so that opening a pipe by mistake does not hang; no effect on regular files.
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.fd < 0)
    cannot_open(path, std::strerror(errno),
                errno == ENOENT ? "check the name of the file" : "check the permissions of the file");
  struct stat status {};
  if (::fstat(descriptor.fd, &status) != 0) cannot_open(path, std::strerror(errno), "check the file system");
  if (S_ISDIR(status.st_mode)) cannot_open(path, "it is a folder", "name a file in it");
  if (!S_ISREG(status.st_mode)) cannot_open(path, "it is not a regular file", "copy its content to a regular file");

  FileContent content{path.string(), {}};
  const auto size = static_cast<std::size_t>(status.st_size);
  try {
    content.bytes.resize(size);
  } catch (const std::bad_alloc&) {
    throw LimitError(Fault{.id = "limit.memory",
                           .message = fmt::format("the file has {} bytes, more than there is memory", size),
                           .fix = "use a machine with more memory",
                           .file = content.file});
  }
  std::size_t got = 0;
  while (got < size) {
    const ssize_t n = ::read(descriptor.fd, content.bytes.data() + got, size - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) cannot_open(path, std::strerror(errno), "check the disk");
    if (n == 0) break;  // It shrank meanwhile: the reader reports what is missing.
    got += static_cast<std::size_t>(n);
  }
  content.bytes.resize(got);
  if (content.bytes.empty()) fail(content.file, "io.empty_file", "the file is empty", "check how it was made");
  return content;
}

std::optional<FileContent> read_file_if_present(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return {};
  return read_file(path);
}

void fail(const std::string& file, std::string id, std::string message, std::string fix,
          std::optional<std::uint64_t> line) {
  throw InputError(
      Fault{.id = std::move(id), .message = std::move(message), .fix = std::move(fix), .file = file, .line = line});
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "\"";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...\"" : "\"");
}

void check_id_range(const std::string& file, std::string_view kind, std::uint64_t count) {
  if (count < std::numeric_limits<std::uint32_t>::max()) return;
  throw LimitError(Fault{.id = "limit.ids",
                         .message = fmt::format("{} {}s are more than 32-bit ids can name", count, kind),
                         .fix = "split the input",
                         .file = file});
}

}  // namespace voropack::io
