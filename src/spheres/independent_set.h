// The conflict graph of f-spheres and its maximal independent set: filtering, in the words of [Miller1996].
#pragma once

#include <cstdint>
#include <vector>

#include "spheres/sphere_set.h"

namespace voropack {

/// Marks a maximal independent set of the conflict graph of `candidates`: the one that a pass through them in ascending
/// order of (priority, index) would choose. Computed in parallel rounds (Blelloch, Fineman, Shun, SPAA 2012), so that
/// it does not depend on the number of threads. `lipschitz` bounds how fast radii vary.
template <int K>
std::vector<std::uint8_t> independent_set(const std::vector<Ball<K>>& candidates,
                                          const std::vector<std::uint64_t>& priority, double lipschitz);

}  // namespace voropack
