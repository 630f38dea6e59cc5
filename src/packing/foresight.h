// What small angles will ask of f, before anything is packed.
#pragma once

#include "voropack/packing.h"

namespace voropack {

/// f with caps where repairs will shrink it because polytopes meet at small angles: a rough model, for estimates only.
template <int D>
Spacing<D> with_foreseen_caps(const Domain<D>& domain, const Spacing<D>& spacing);

}  // namespace voropack
