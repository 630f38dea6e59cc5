// The files of one command, which appear together or not at all.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

namespace voropack::app {

/// Files are written to a hidden folder beside their place and renamed at the end. Whatever is left goes away with the
/// object, or with `abandon`, which another thread may call at any time.
class OutputSet {
 public:
  OutputSet() = default;
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;
  ~OutputSet();

  /// The path to write to so that `publish` moves it to `target`, with every file of the same stem beside it (a mesh
  /// file .node has .ele, .face, .edge). Makes missing folders, so that a place that cannot be written to is found
  /// before the work. Throws InputError io.cannot_write; OptionError cli.same_file if the target was given before.
  std::filesystem::path stage(const std::filesystem::path& target);

  /// Throws OptionError cli.overwrites_input if a target of `stage` is `input`.
  void protect(const std::filesystem::path& input) const;

  /// `message` with the places of staged files replaced by those that the user gave.
  [[nodiscard]] std::string in_users_words(std::string message) const;

  /// Moves every staged file to its place. Throws InputError io.cannot_write.
  void publish();

  /// Removes what was staged and not published, and lets nothing be published any more.
  void abandon() noexcept;

 private:
  struct Entry {
    std::filesystem::path target;  ///< As the user gave it.
    std::filesystem::path folder;  ///< The hidden folder.
  };
  static void publish_entry(const Entry& entry);

  std::mutex mutex_;  ///< Guards everything below against `abandon`.
  bool abandoned_ = false;
  std::vector<Entry> entries_;
  std::vector<std::filesystem::path> made_folders_;  ///< Outermost first; removed if nothing is published.
};

}  // namespace voropack::app
