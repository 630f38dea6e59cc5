// Exact geometric predicates on doubles: the sign is that of exact arithmetic on the given coordinates. Filtered:
// usually fast.
#pragma once

#include "voropack/vec.h"

namespace voropack {

/// Sign of the area of triangle (a, b, c): +1 counterclockwise, 0 collinear, -1 clockwise.
int orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);

/// Sign of det[b-a, c-a, d-a]: +1 if d is on the side of the plane abc from which a, b, c look counterclockwise... that
/// is, where (b-a) x (c-a) points; 0 coplanar.
int orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d);

/// +1 if e is strictly inside the circumcircle of the counterclockwise triangle (a, b, c), 0 on it, -1 outside.
int in_circumball(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& e);

/// +1 if e is strictly inside the circumsphere of the positively oriented tetrahedron (a, b, c, d), 0 on it, -1
/// outside.
int in_circumball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, const Vec<3>& e);

/// +1 if e is strictly inside the ball with diameter ab, 0 on its sphere, -1 outside.
int in_diametral_ball(const Vec<2>& a, const Vec<2>& b, const Vec<2>& e);
int in_diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& e);

/// +1 if e is strictly inside the smallest ball whose sphere passes through the corners of triangle abc (its equatorial
/// ball).
int in_diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& e);

}  // namespace voropack
