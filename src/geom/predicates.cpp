#include "geom/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace voropack {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_2 cg(const Vec<2>& p) { return {p[0], p[1]}; }
Kernel::Point_3 cg(const Vec<3>& p) { return {p[0], p[1], p[2]}; }

}  // namespace

int orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  return static_cast<int>(CGAL::orientation(cg(a), cg(b), cg(c)));
}

int orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  return static_cast<int>(CGAL::orientation(cg(a), cg(b), cg(c), cg(d)));
}

int in_circumball(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& e) {
  return static_cast<int>(CGAL::side_of_oriented_circle(cg(a), cg(b), cg(c), cg(e)));
}

int in_circumball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, const Vec<3>& e) {
  return static_cast<int>(CGAL::side_of_oriented_sphere(cg(a), cg(b), cg(c), cg(d), cg(e)));
}

int in_diametral_ball(const Vec<2>& a, const Vec<2>& b, const Vec<2>& e) {
  return static_cast<int>(CGAL::side_of_bounded_circle(cg(a), cg(b), cg(e)));
}

int in_diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& e) {
  return static_cast<int>(CGAL::side_of_bounded_sphere(cg(a), cg(b), cg(e)));
}

int in_diametral_ball(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& e) {
  return static_cast<int>(CGAL::side_of_bounded_sphere(cg(a), cg(b), cg(c), cg(e)));
}

}  // namespace voropack
