// What is wrong with a problem, in words: the refusals that control volumes and finite elements have in common.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "voropack/index.h"

namespace voropack {

[[noreturn]] void fail_input(std::string id, std::string message, std::string fix, std::vector<double> position = {});

/// Throws InputError solve.unknown_region unless `name` has a value for each of the regions and no other.
void check_regions(const std::map<int, double>& by_region, const std::set<int>& regions, std::string_view name);

/// Throws InputError solve.wrong_length unless `name` has one value for each vertex.
void check_length(const IdVector<VertexId, double>& by_vertex, std::size_t n_vertices, std::string_view name);

/// Throws InputError solve.unknown_marker unless the marker of a condition is one of those of the boundary.
void check_marker(int marker, const std::set<int>& markers);

/// Throws InputError solve.nonlinear: `name` depends on the solution, where it may not.
[[noreturn]] void refuse_state_function(std::string_view name, std::string fix);

}  // namespace voropack
