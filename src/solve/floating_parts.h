// Connected parts of a system where the solution is free up to a constant.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "voropack/linear_system.h"

namespace voropack {

/// The first vertex of the connected part of each vertex.
std::vector<std::uint32_t> part_roots(const SparseMatrix& matrix);

/// The first vertex of each connected part that has no fixed vertex and absorbs nothing, ascending.
std::vector<VertexId> floating_roots(const LinearSystem& system);

/// A connected part without fixed vertices where nothing is absorbed.
struct FloatingPart {
  std::vector<VertexId> vertices;  ///< Ascending. The first one is fixed at 0 while the system is solved.
  double volume = 0;
  double gain = 0;  ///< What its load added up to, and what was taken away from it, in proportion to volumes.
};

/// Makes a singular system solvable: fixes one vertex of every floating part and takes away what the part gains.
/// `volume` is that of the vertices, `regions_of` the regions that some vertices (ascending) lie in, for messages.
/// Throws InputError solve.no_condition, solve.mean_not_free, solve.incompatible.
std::vector<FloatingPart> ground_floating_parts(
    const IdVector<VertexId, double>& volume,
    const std::function<std::set<int>(const std::vector<VertexId>& vertices)>& regions_of,
    const std::optional<double>& mean, LinearSystem& system);

/// Shifts the values of every part so that their mean over its volume is `mean`.
void shift_to_mean(const IdVector<VertexId, double>& volume, const std::vector<FloatingPart>& parts, double mean,
                   IdVector<VertexId, double>& values);

}  // namespace voropack
