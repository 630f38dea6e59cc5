// The integral of f^-D over a domain, by adaptive sampling.
#pragma once

#include <functional>

#include "spacing/region_locator.h"
#include "voropack/spacing.h"

namespace voropack {

/// Cells are cut in halves where they contribute most to the error, until that is about 2 % or there are 20000 of them.
/// Cells that meet a wall are sampled by jittered points, of which those in the domain count; the sampled volume is
/// then scaled to the true one, so that thin domains come out right. Deterministic.
template <int D>
double integrate_density(const Domain<D>& domain, const RegionLocator<D>& locator, const Spacing<D>& f);

/// The same integral as samples whose parts add up to it: in each cell one point of the domain, drawn by its density.
template <int D>
std::vector<IntegralSample<D>> sample_density(const Domain<D>& domain, const RegionLocator<D>& locator,
                                              const Spacing<D>& f);

}  // namespace voropack
