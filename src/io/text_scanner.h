// Reads text files line by line and token by token, with messages that name the file, line and element.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "io/source.h"
#include "voropack/observer.h"

namespace voropack::io {

/// Walks over the lines of a text that hold something, and over the tokens of each. Lines end with LF, CRLF or CR; a
/// byte-order mark and comments (from `comment` to the end of the line; '\0' for none) are skipped.
///
/// Every reading function throws InputError with the id it names, the file, the line and the current element.
class TextScanner {
 public:
  TextScanner(const Source& source, char comment, Observer& observer);

  /// Moves to the next line that holds a token. False at the end of the text.
  bool next_line();
  /// The same, and says what is being read for messages. Throws io.truncated if there is no further line.
  void next_line(std::string_view kind, std::uint64_t number);
  void next_line(std::string_view kind) { next_line(kind, kNoNumber); }
  /// Says what is being read, for messages.
  void set_element(std::string_view kind, std::uint64_t number) {
    kind_ = kind;
    number_ = number;
  }

  /// The next token of the line; empty at its end.
  std::string_view token() {
    skip_blanks();
    const char* const begin = at_;
    while (at_ != line_end_ && !is_blank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  [[nodiscard]] bool at_end_of_line() {
    skip_blanks();
    return at_ == line_end_;
  }
  /// The next token of this line or a later one. Throws io.truncated at the end of the text.
  std::string_view token_across_lines();
  void skip_line() { at_ = line_end_; }

  /// A finite number. Throws io.missing_value, io.bad_number, io.not_finite.
  double number(std::string_view what);
  /// A whole number. Throws io.missing_value, io.bad_number.
  std::int64_t integer(std::string_view what);
  /// A whole number that fits an int. Throws io.missing_value, io.bad_number.
  int small_integer(std::string_view what);
  /// A number of things that follow. Throws io.missing_value, io.bad_number; io.bad_count if it is negative or more
  /// than the bytes that are left.
  std::uint64_t count(std::string_view what);
  /// How many of n things to reserve memory for, each with at least `min_bytes` bytes of text: n, or less if the file
  /// cannot hold so many. Reading them then tells where the file ends.
  [[nodiscard]] std::uint64_t capacity(std::uint64_t n, std::uint64_t min_bytes) const {
    return std::min(n, bytes_left() / min_bytes + 1);
  }
  /// The 0-based index that a number in [first, first + n) stands for. Throws io.missing_value, io.bad_number,
  /// io.bad_index.
  std::uint32_t index(std::string_view what, std::uint64_t first, std::uint64_t n);
  /// Throws io.extra_value if the line has another token.
  void end_of_line();
  /// Throws io.bad_count if there is another line.
  void end_of_file(std::string_view after);

  /// The element of the last next_line, such as "point 12".
  [[nodiscard]] std::string element() const;
  [[noreturn]] void fail(std::string id, const std::string& message, std::string fix) const;
  [[nodiscard]] std::uint64_t line() const { return line_; }
  [[nodiscard]] const std::string& file() const { return file_; }
  /// The bytes that follow the current line.
  [[nodiscard]] std::string_view rest() const { return {next_, static_cast<std::size_t>(end_ - next_)}; }
  /// The number of bytes that follow the last token.
  [[nodiscard]] std::uint64_t bytes_left() const { return static_cast<std::uint64_t>(end_ - at_); }

 private:
  static constexpr std::uint64_t kNoNumber = ~std::uint64_t{0};
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
  void skip_blanks() {
    while (at_ != line_end_ && is_blank(*at_)) ++at_;
  }
  std::string_view required_token(std::string_view what);

  std::string file_;
  const char* begin_;
  const char* end_;
  const char* next_;      ///< Where the next line begins.
  const char* at_;        ///< Where the next token is looked for.
  const char* line_end_;  ///< End of the current line without its comment.
  char comment_;
  char newline_ = '\n';
  std::uint64_t line_ = 0;
  std::string_view kind_;  ///< Points to a literal or to what outlives the scanner.
  std::uint64_t number_ = kNoNumber;
  Observer& observer_;
};

}  // namespace voropack::io
