// From a user's wishes to size atoms: checks them, and throws OptionError.
#pragma once

#include "spacing/size_atoms.h"
#include "voropack/observer.h"
#include "voropack/spacing.h"

namespace voropack {

/// Throws OptionError spacing.bad_gradation, spacing.bad_feature_factor, spacing.bad_size.
void check_spacing_options(const SpacingOptions& options);

/// Adds every wish to `atoms` (without `finish`) and returns the least constant that is wanted everywhere, or infinity.
template <int D>
double add_wishes(const Domain<D>& domain, const SizeWishes<D>& wishes, const SpacingOptions& options,
                  const PolytopeSet<D>& polytopes, const RegionLocator<D>& locator, SizeAtoms<D>& atoms,
                  Observer& observer);

/// The formula as boxes with the least value sampled in each; boxes that others make useless are left out.
template <int D>
void add_expression(const std::string& text, double edge_per_spacing, const Domain<D>& domain,
                    const RegionLocator<D>& locator, SizeAtoms<D>& atoms, Observer& observer);

}  // namespace voropack
