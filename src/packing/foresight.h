// What small angles will ask of f, before anything is packed.
#pragma once

#include "voropack/packing.h"

namespace voropack {

/// f with caps where repairs will shrink it because polytopes meet at small angles: a rough model, for estimates only.
Spacing<2> with_foreseen_caps(const Domain<2>& domain, const Spacing<2>& spacing);
Spacing<3> with_foreseen_caps(const Domain<3>& domain, const Spacing<3>& spacing);

}  // namespace voropack
