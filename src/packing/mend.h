// Mends simplices whose circumradius is large beside their shortest edge: single spheres inside of the domain come, go
// and move until no such simplex is left, or no move helps.
#pragma once

#include <cstddef>
#include <cstdint>

#include "packing/incidence.h"
#include "spheres/packing_problem.h"
#include "voropack/observer.h"
#include "voropack/packing.h"

namespace voropack {

/// Of a Voronoi-maximal packing with its triangulation, which it stays; spheres from `n_boundary` on may move. Where a
/// protecting ball is much larger than the spheres beside it, the circumcenters there cannot be added, and what could
/// be added elsewhere is not asked for: so maximality alone does not bound these simplices (docs/theory/sharp.md).
///
/// Returns how many stretched simplices are left. Some ten milliseconds for each that is there, and up to some seconds
/// for those that stay. The same seed gives the same packing.
template <int D>
std::size_t mend_stretched(Packing<D>& packing, std::size_t n_boundary, const PackingProblem<D>& problem,
                           const Incidence<D>& incidence, const Observer& observer);

}  // namespace voropack
