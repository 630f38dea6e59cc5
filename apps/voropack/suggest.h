// "Did you mean": the known name nearest to what was typed.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace voropack::app {

/// The smallest number of insertions, deletions, substitutions and swaps of neighbors that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name with the smallest edit distance to `typed`; the first of several. Nothing if `known` is empty.
std::optional<std::string> nearest_name(std::string_view typed, std::span<const std::string> known);

}  // namespace voropack::app
