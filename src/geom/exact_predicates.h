// The exact stage behind the floating-point filters: the same signs as predicates.h, faster on lattices.
//
// Points of lattices, plates and cylinders are cospherical or nearly so, and filters fail on them all the time. The
// differences of their coordinates are multiples of one power of two that is not much smaller than they are, so the
// determinants are evaluated with integers of fixed width. What does not fit goes to predicates.h.
#pragma once

#include "voropack/vec.h"

namespace voropack {

int orientation_exact(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);
int orientation_exact(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d);
int in_circumball_exact(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& e);
int in_circumball_exact(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, const Vec<3>& e);

}  // namespace voropack
