#include "io/text_scanner.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "base/number_text.h"

namespace voropack::io {

namespace {

/// The observer is asked whether to stop once in so many lines.
constexpr std::uint64_t kLinesPerCheck = 1U << 16U;

}  // namespace

TextScanner::TextScanner(const Source& source, char comment, Observer& observer)
    : file_(source.file),
      begin_(source.bytes.data()),
      end_(source.bytes.data() + source.bytes.size()),
      next_(begin_),
      at_(begin_),
      line_end_(begin_),
      comment_(comment),
      observer_(observer) {
  if (source.bytes.starts_with("\xEF\xBB\xBF")) next_ += 3;
  // Only files of the old Macintosh have CR alone.
  if (source.bytes.find('\n') == std::string_view::npos && source.bytes.find('\r') != std::string_view::npos)
    newline_ = '\r';
}

bool TextScanner::next_line() {
  while (next_ != end_) {
    const char* const begin = next_;
    const auto* newline =
        static_cast<const char*>(std::memchr(begin, newline_, static_cast<std::size_t>(end_ - begin)));
    line_end_ = newline != nullptr ? newline : end_;
    next_ = newline != nullptr ? newline + 1 : end_;
    if (++line_ % kLinesPerCheck == 0) {
      observer_.check_cancelled();
      observer_.progress(static_cast<std::uint64_t>(next_ - begin_), static_cast<std::uint64_t>(end_ - begin_));
    }
    if (comment_ != '\0') {
      const auto* hash =
          static_cast<const char*>(std::memchr(begin, comment_, static_cast<std::size_t>(line_end_ - begin)));
      if (hash != nullptr) line_end_ = hash;
    }
    at_ = begin;
    if (!at_end_of_line()) return true;
  }
  return false;
}

void TextScanner::next_line(std::string_view kind, std::uint64_t number) {
  kind_ = kind;
  number_ = number;
  if (!next_line())
    fail("io.truncated", fmt::format("the file ends before {}", element()),
         "check that the file is complete and that its counts are right");
}

std::string_view TextScanner::token_across_lines() {
  while (at_end_of_line())
    if (!next_line())
      fail("io.truncated", fmt::format("the file ends within {}", element()), "check that the file is complete");
  return token();
}

std::string_view TextScanner::required_token(std::string_view what) {
  const std::string_view text = token();
  if (text.empty())
    fail("io.missing_value", fmt::format("{}: the {} is missing", element(), what),
         "complete the line, or correct the number of columns that the header announces");
  return text;
}

double TextScanner::number(std::string_view what) {
  const std::string_view text = required_token(what);
  double value = 0;
  switch (parse_double(text, value)) {
    case NumberFault::kNone:
      break;
    case NumberFault::kNotANumber:
      fail("io.bad_number", fmt::format("{}: the {} {} is not a number", element(), what, quote(text)),
           "write it as a decimal number such as 1.5 or -2e-3");
    case NumberFault::kNotFinite:
      fail("io.not_finite", fmt::format("{}: the {} {} is not a finite double", element(), what, quote(text)),
           "write a number of magnitude below 1.8e308");
  }
  return value;
}

std::int64_t TextScanner::integer(std::string_view what) {
  const std::string_view text = required_token(what);
  std::int64_t value = 0;
  if (!parse_integer(text, value))
    fail("io.bad_number", fmt::format("{}: the {} {} is not a whole number", element(), what, quote(text)),
         "write a whole number");
  return value;
}

int TextScanner::small_integer(std::string_view what) {
  const std::int64_t value = integer(what);
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max())
    fail("io.bad_number", fmt::format("{}: the {} {} does not fit into 32 bits", element(), what, value),
         "use a number between -2147483648 and 2147483647");
  return static_cast<int>(value);
}

std::uint64_t TextScanner::count(std::string_view what) {
  const std::int64_t value = integer(what);
  if (value < 0)
    fail("io.bad_count", fmt::format("{}: the {} is {}, a negative number", element(), what, value),
         "correct the count");
  const auto n = static_cast<std::uint64_t>(value);
  if (n > bytes_left() + 1)
    fail("io.bad_count",
         fmt::format("{}: the {} is {}, more than the remaining {} bytes of the file can hold", element(), what, n,
                     bytes_left()),
         "correct the count, or check that the file is complete");
  check_id_range(file_, what, n);
  return n;
}

std::uint32_t TextScanner::index(std::string_view what, std::uint64_t first, std::uint64_t n) {
  const std::int64_t value = integer(what);
  if (value < static_cast<std::int64_t>(first) || static_cast<std::uint64_t>(value) - first >= n) {
    if (n == 0)
      fail("io.bad_index", fmt::format("{}: the {} is {}, but there are none", element(), what, value),
           "list the points first");
    fail("io.bad_index",
         fmt::format("{}: the {} is {}, outside of {} to {}", element(), what, value, first, first + n - 1),
         "correct the index; the first point's number decides whether counting starts at 0 or 1");
  }
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) - first);
}

void TextScanner::end_of_line() {
  if (at_end_of_line()) return;
  fail("io.extra_value", fmt::format("{}: the line goes on with {} where it should end", element(), quote(token())),
       "remove the extra value, or correct the number of columns that the header announces");
}

void TextScanner::end_of_file(std::string_view after) {
  if (!next_line()) return;
  fail("io.bad_count", fmt::format("the file goes on with {} after the last {}", quote(token()), after),
       fmt::format("correct the number of {}s that is announced, or remove the rest", after));
}

std::string TextScanner::element() const {
  if (kind_.empty()) return "the file";
  return number_ == kNoNumber ? "the " + std::string(kind_) : fmt::format("{} {}", kind_, number_);
}

void TextScanner::fail(std::string id, const std::string& message, std::string fix) const {
  io::fail(file_, std::move(id), message, std::move(fix), line_ > 0 ? std::optional(line_) : std::nullopt);
}

}  // namespace voropack::io
