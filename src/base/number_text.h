// Numbers to text and back, independent of the locale. Written in the shortest form that reads back as the same value.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace voropack {

enum class NumberFault : std::uint8_t {
  kNone,
  kNotANumber,  ///< Not the text of a number.
  kNotFinite,   ///< "inf", "nan", or too large for a double.
};

/// Reads all of `text` as a double: decimal or scientific, an optional leading '+'. Values too small become 0.
inline NumberFault parse_double(std::string_view text, double& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  auto [stop, error] = std::from_chars(text.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return NumberFault::kNotANumber;
  if (error == std::errc::result_out_of_range) {
    // Too large or too small? The longer exponent of long double tells.
    long double wide = 0;
    if (std::from_chars(text.data(), end, wide).ec != std::errc{} || std::abs(wide) > 1) return NumberFault::kNotFinite;
    value = static_cast<double>(wide);
  }
  return std::isfinite(value) ? NumberFault::kNone : NumberFault::kNotFinite;
}

/// Reads all of `text` as a decimal integer with an optional leading '+'. False if it is none or does not fit.
template <class Integer>
bool parse_integer(std::string_view text, Integer& value) {
  static_assert(std::is_integral_v<Integer>);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  auto [stop, error] = std::from_chars(text.data(), end, value);
  return stop == end && error == std::errc{};
}

/// Appends the shortest text that reads back as exactly `value`.
inline void append_number(std::string& text, double value) {
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

template <class Integer>
requires std::is_integral_v<Integer>
void append_number(std::string& text, Integer value) {
  char buffer[24];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

}  // namespace voropack
