#include "io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "io/source.h"

namespace voropack::io {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  if (path_.filename().empty() || std::filesystem::is_directory(path_, error)) fail(EISDIR);
  if (std::filesystem::exists(path_, error) && !std::filesystem::is_regular_file(path_, error)) {
    fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd_ < 0) fail(errno);
    return;
  }
  // Follow a link, so that it stays one.
  if (std::filesystem::is_symlink(path_, error)) {
    const std::filesystem::path target = std::filesystem::weakly_canonical(path_, error);
    if (!error) path_ = target;
  }
  if (path_.has_parent_path()) {
    std::filesystem::create_directories(path_.parent_path(), error);
    if (error) fail(error.value());
  }
  constexpr int kMaxTries = 10000;
  for (int i = 0; i < kMaxTries && fd_ < 0; ++i) {
    temporary_ = path_.parent_path() / fmt::format(".{}.{}-{}.tmp", path_.filename().string(), ::getpid(), i);
    fd_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd_ < 0 && errno != EEXIST) break;
  }
  if (fd_ < 0) {
    const int reason = errno;
    temporary_.clear();
    fail(reason);
  }
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() > kBufferBytes)
    write_out(bytes, position_);
  else
    buffer_ += bytes;
  position_ += bytes.size();
}

void AtomicFile::overwrite(std::uint64_t position, std::string_view bytes) {
  if (temporary_.empty()) fail(ESPIPE);
  flush();
  write_out(bytes, position);
}

void AtomicFile::flush() {
  write_out(buffer_, position_ - buffer_.size());
  buffer_.clear();
}

void AtomicFile::write_out(std::string_view bytes, std::uint64_t position) {
  const bool seekable = !temporary_.empty();
  while (!bytes.empty()) {
    const ssize_t n = seekable ? ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(position))
                               : ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(n));
    position += static_cast<std::uint64_t>(n);
  }
}

void AtomicFile::finish() {
  flush();
  // Network file systems may report a full disk only here.
  if (::close(std::exchange(fd_, -1)) != 0) fail(errno);
}

void AtomicFile::rename() {
  if (temporary_.empty()) return;
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(errno);
  temporary_.clear();
}

void AtomicFile::fail(int error) const {
  std::string fix = "choose another place with -o";
  if (error == ENOSPC || error == EDQUOT) fix = "free some space, or choose another disk";
  if (error == EFBIG) fix = "raise the limit on the size of files (ulimit -f), or choose another disk";
  if (error == EACCES || error == EPERM || error == EROFS) fix = "choose a folder that you may write to";
  if (error == EISDIR) fix = "name a file, not a folder";
  io::fail(path_.string(), "io.cannot_write", fmt::format("cannot be written: {}", std::strerror(error)),
           std::move(fix));
}

}  // namespace voropack::io
