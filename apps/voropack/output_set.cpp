#include "output_set.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <system_error>

#include "voropack/error.h"

namespace voropack::app {

namespace fs = std::filesystem;

namespace {

/// What belongs to a mesh in a .node file.
constexpr std::array<const char*, 3> kCompanions = {".ele", ".face", ".edge"};

InputError cannot_write(const fs::path& target, const std::string& reason) {
  return InputError(Fault{.id = "io.cannot_write",
                          .message = fmt::format("cannot write: {}", reason),
                          .fix = "choose a place that can be written to and has room.",
                          .file = target.string()});
}

/// The folders of `folder` that do not exist yet, outermost first.
std::vector<fs::path> missing_folders(fs::path folder) {
  std::vector<fs::path> missing;
  std::error_code ignored;
  while (!folder.empty() && !fs::exists(folder, ignored)) {
    missing.insert(missing.begin(), folder);
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return missing;
}

/// Where a target really is: what a symbolic link points to.
fs::path resolved(const fs::path& target) {
  std::error_code error;
  const fs::path real = fs::is_symlink(target, error) ? fs::weakly_canonical(target, error) : target;
  return error ? target : real;
}

bool is_special_file(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// A device or pipe cannot be replaced by renaming: its bytes are sent to it.
void copy_bytes(const fs::path& from, const fs::path& to, const fs::path& target) {
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  if (fs::file_size(from) > 0) out << in.rdbuf();
  out.flush();
  if (!in || !out) throw cannot_write(target, "the device took no more");
}

}  // namespace

OutputSet::~OutputSet() { abandon(); }

fs::path OutputSet::stage(const fs::path& target) {
  const std::scoped_lock lock(mutex_);
  std::error_code error;
  if (!target.has_filename() || fs::is_directory(target, error)) throw cannot_write(target, "it is a folder");
  for (const Entry& entry : entries_)
    if (fs::weakly_canonical(fs::absolute(entry.target), error) == fs::weakly_canonical(fs::absolute(target), error))
      throw OptionError(Fault{.id = "cli.same_file",
                              .message = fmt::format("{} is given as output twice", target.string()),
                              .fix = "give each output its own name."});

  refuse_input(target);

  const fs::path place = resolved(target);
  // What is written to a device is staged where there is room for files.
  const fs::path parent = is_special_file(place) ? fs::temp_directory_path()
                                                 : (place.has_parent_path() ? place.parent_path() : fs::path("."));
  for (fs::path& folder : missing_folders(parent)) {
    if (!fs::create_directory(folder, error) && error) throw cannot_write(target, error.message());
    made_folders_.push_back(std::move(folder));
  }
  // A folder of an earlier process of the same number, killed before it could clean up, is stepped over.
  fs::path folder;
  for (int k = 0; k < 1000; ++k) {
    folder = parent / fmt::format(".voropack-{}-{}", getpid(), k);
    if (fs::create_directory(folder, error) || error) break;
  }
  if (error) throw cannot_write(target, error.message());
  entries_.push_back({target, folder});
  return folder / target.filename();
}

void OutputSet::protect(const fs::path& input) {
  const std::scoped_lock lock(mutex_);
  inputs_.push_back(input);
  if (input.extension() == ".node")
    for (const char* extension : kCompanions) inputs_.push_back(fs::path(input).replace_extension(extension));
  for (const Entry& entry : entries_) refuse_input(entry.target);
  for (const fs::path& old : replaced_) refuse_input(old);
}

void OutputSet::replace(const fs::path& old) {
  const std::scoped_lock lock(mutex_);
  refuse_input(old);
  replaced_.push_back(old);
}

void OutputSet::refuse_input(const fs::path& target) const {
  std::error_code ignored;
  for (const fs::path& input : inputs_)
    if (fs::equivalent(target, input, ignored))
      throw OptionError(Fault{.id = "cli.overwrites_input",
                              .message = fmt::format("{} is the input and the output", input.string()),
                              .fix = "give the output another name."});
}

std::string OutputSet::in_users_words(std::string message) const {
  for (const Entry& entry : entries_) {
    const std::string staged = entry.folder.string() + '/';
    const std::string given = entry.target.has_parent_path() ? (entry.target.parent_path() / "").string() : "";
    for (std::size_t at = message.find(staged); at != std::string::npos; at = message.find(staged, at + given.size()))
      message.replace(at, staged.size(), given);
  }
  return message;
}

std::vector<OutputSet::Move> OutputSet::moves(const Entry& entry) {
  const fs::path place = resolved(entry.target);
  std::vector<Move> result;
  for (const fs::directory_entry& file : fs::directory_iterator(entry.folder)) {
    const fs::path name = file.path().filename();
    result.push_back({file.path(), name == entry.target.filename() ? place : place.parent_path() / name});
  }
  std::sort(result.begin(), result.end(), [](const Move& a, const Move& b) { return a.from < b.from; });
  return result;
}

void OutputSet::publish_entry(const Entry& entry) {
  const fs::path place = resolved(entry.target);
  const bool is_special = is_special_file(place);
  const std::vector<Move> written = moves(entry);
  for (const Move& move : written) {
    if (is_special) {
      copy_bytes(move.from, place, entry.target);
      continue;
    }
    std::error_code error;
    fs::rename(move.from, move.to, error);
    if (error) throw cannot_write(move.to, error.message());
  }
  // What an older run left under the same name and this one did not write would be read as part of the new mesh.
  if (entry.target.extension() != ".node") return;
  for (const char* extension : kCompanions) {
    const fs::path name = fs::path(entry.target.filename()).replace_extension(extension);
    const bool is_new =
        std::any_of(written.begin(), written.end(), [&](const Move& move) { return move.from.filename() == name; });
    std::error_code ignored;
    if (!is_new) fs::remove(place.parent_path() / name, ignored);
  }
}

void OutputSet::remove_replaced(const std::vector<fs::path>& written) const {
  for (const fs::path& old : replaced_) {
    std::error_code error;
    const bool is_new = std::any_of(written.begin(), written.end(),
                                    [&](const fs::path& file) { return fs::equivalent(file, old, error); });
    error.clear();
    if (!is_new) fs::remove(old, error);
    if (error) throw cannot_write(old, error.message());
  }
}

void OutputSet::publish() {
  const std::scoped_lock lock(mutex_);
  if (abandoned_) throw Cancelled();
  std::vector<fs::path> written;
  for (const Entry& entry : entries_)
    for (const Move& move : moves(entry)) written.push_back(move.to);
  for (const fs::path& file : written) refuse_input(file);
  for (const Entry& entry : entries_) publish_entry(entry);
  remove_replaced(written);
  made_folders_.clear();
  for (const Entry& entry : entries_) {
    std::error_code ignored;
    fs::remove_all(entry.folder, ignored);
  }
  entries_.clear();
}

void OutputSet::abandon() noexcept {
  const std::scoped_lock lock(mutex_);
  abandoned_ = true;
  std::error_code ignored;
  for (const Entry& entry : entries_) {
    // Another thread may add a file while we remove: try again until the folder is gone.
    for (int attempt = 0; attempt < 100 && fs::exists(entry.folder, ignored); ++attempt)
      fs::remove_all(entry.folder, ignored);
  }
  std::for_each(made_folders_.rbegin(), made_folders_.rend(), [&](const fs::path& made) { fs::remove(made, ignored); });
  entries_.clear();
  made_folders_.clear();
}

}  // namespace voropack::app
