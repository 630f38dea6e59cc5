// Help with names that a user misspelt.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace voropack {

/// The known name that differs from `name` by the fewest insertions, deletions, replacements and swaps of neighbors, if
/// those are at most a third of its letters (at least one); else an empty string. The first of equals.
std::string nearest_name(std::string_view name, std::span<const std::string> known);

/// "a, b, c".
std::string join_names(std::span<const std::string> names);

}  // namespace voropack
