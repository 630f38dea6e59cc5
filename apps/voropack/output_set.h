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
  /// before the work. Throws InputError io.cannot_write; OptionError cli.same_file if the target was given before,
  /// cli.overwrites_input if it is an input.
  std::filesystem::path stage(const std::filesystem::path& target);

  /// Nothing may take the place of `input`, nor of the files that belong to it if it is a .node file: neither what is
  /// staged before or after, nor what `publish` finds beside it. Throws OptionError cli.overwrites_input.
  void protect(const std::filesystem::path& input);

  /// What is published replaces `old`: a file of an earlier run that is removed then, unless it is written again.
  /// Throws OptionError cli.overwrites_input if it is an input.
  void replace(const std::filesystem::path& old);

  /// `message` with the places of staged files replaced by those that the user gave.
  [[nodiscard]] std::string in_users_words(std::string message) const;

  /// Moves every staged file to its place. Throws InputError io.cannot_write; OptionError cli.overwrites_input before
  /// anything is moved.
  void publish();

  /// Removes what was staged and not published, and lets nothing be published any more.
  void abandon() noexcept;

 private:
  struct Entry {
    std::filesystem::path target;  ///< As the user gave it.
    std::filesystem::path folder;  ///< The hidden folder.
  };
  /// A file that was written, and where it goes.
  struct Move {
    std::filesystem::path from, to;
  };
  static std::vector<Move> moves(const Entry& entry);
  static void publish_entry(const Entry& entry);
  void refuse_input(const std::filesystem::path& target) const;
  void remove_replaced(const std::vector<std::filesystem::path>& written) const;

  std::mutex mutex_;  ///< Guards everything below against `abandon`.
  bool abandoned_ = false;
  std::vector<Entry> entries_;
  std::vector<std::filesystem::path> inputs_, replaced_;
  std::vector<std::filesystem::path> made_folders_;  ///< Outermost first; removed if nothing is published.
};

}  // namespace voropack::app
