// How many spheres a packing will need, from integrals of powers of 1 / f over the domain and its boundary.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "base/adaptive.h"
#include "packing/attribution.h"
#include "spheres/lattice.h"
#include "voropack/packing.h"

namespace voropack {

namespace {

/// A part of a segment (M = 1) or of a facet (M = 2).
template <int D, int M>
struct Piece {
  std::array<Vec<D>, M + 1> corner;
  double integral = 0;
  double error = 0;
  bool is_exact = false;  ///< f is constant on it.
};

template <int D>
double measure_of(const std::array<Vec<D>, 2>& s) {
  return distance(s[0], s[1]);
}
double measure_of(const std::array<Vec<3>, 3>& s) { return 0.5 * norm(cross(s[1] - s[0], s[2] - s[0])); }

/// Integrates f^-M by Simpson's rule, or by that of the triangle with corners and centroid, both exact for quadratic
/// polynomials. The error is the difference from the midpoint rule.
template <int D, int M>
void examine(Piece<D, M>& piece, const Spacing<D>& f) {
  const double measure = measure_of(piece.corner);
  Box<D> box;
  for (const Vec<D>& x : piece.corner) box.add(x);
  if (const auto constant = f.constant_on(box)) {
    piece.integral = measure / std::pow(*constant, M);
    piece.is_exact = true;
    return;
  }
  Vec<D> center;
  double at_corners = 0;
  for (const Vec<D>& x : piece.corner) {
    center += x / (M + 1.0);
    at_corners += 1 / std::pow(f(x), M) / (M + 1.0);
  }
  const double at_center = 1 / std::pow(f(center), M);
  constexpr double weight = M == 1 ? 1.0 / 3 : 1.0 / 4;
  piece.integral = measure * (weight * at_corners + (1 - weight) * at_center);
  piece.error = std::abs(piece.integral - measure * at_center);
}

/// Cuts a piece at the middle of its longest edge.
template <int D, int M>
std::array<Piece<D, M>, 2> halves(const Piece<D, M>& piece) {
  const auto& x = piece.corner;
  std::size_t a = 0, b = 1;
  for (std::size_t i = 0; i <= M; ++i)
    for (std::size_t j = i + 1; j <= M; ++j)
      if (distance_sq(x[i], x[j]) > distance_sq(x[a], x[b])) {
        a = i;
        b = j;
      }
  std::array<Piece<D, M>, 2> result = {Piece<D, M>{x}, Piece<D, M>{x}};
  result[0].corner[a] = result[1].corner[b] = 0.5 * (x[a] + x[b]);
  return result;
}

template <int D, int M>
double relative_error(const std::vector<Piece<D, M>>& pieces) {
  double integral = 0, error = 0;
  for (const Piece<D, M>& piece : pieces) {
    integral += piece.integral;
    error += piece.error;
  }
  return error / integral;
}

/// All pieces with their integrals of f^-M.
template <int D, int M>
std::vector<Piece<D, M>> integrate(std::vector<Piece<D, M>> pieces, const Spacing<D>& f) {
  return cut_adaptively(
      std::move(pieces), [&](Piece<D, M>& piece, std::uint64_t /*round*/, std::size_t /*i*/) { examine(piece, f); },
      halves<D, M>, relative_error<D, M>);
}

template <int D>
std::vector<Piece<D, 1>> integrate_over_segments(const Domain<D>& domain, const Spacing<D>& f) {
  std::vector<Piece<D, 1>> pieces;
  for (const auto& s : domain.segments) pieces.push_back({{domain.points[s[0]], domain.points[s[1]]}});
  return integrate(std::move(pieces), f);
}

std::vector<Piece<3, 2>> integrate_over_facets(const Domain<3>& domain, const Spacing<3>& f) {
  std::vector<Piece<3, 2>> pieces;
  for (const FacetId facet : ids(domain.facet_frame))
    for (const auto& t : domain.facet_triangles[facet])
      pieces.push_back({{domain.points[t[0]], domain.points[t[1]], domain.points[t[2]]}});
  return integrate(std::move(pieces), f);
}

/// Vertices per point and per unit of the integrals of 1 / f over segments, f^-2 over facets and f^-D over regions.
/// Those of segments are negative in 3D because facets keep their centers 2 f away from them. Fitted to the counts of
/// 216 meshes of 15 domains that needed no repair (docs/theory/packing.md).
struct Weights {
  double points, segments, facets, regions;
};

template <int D>
Weights weights_of(PackingForm form) {
  if (form != PackingForm::kVoronoi)
    return D == 3 ? Weights{1, -0.162, 0.0855, 0.0883} : Weights{-0.23, 0.201, 0, 0.165};
  return D == 3 ? Weights{1, -0.031, 0.070, 0.0915} : Weights{-0.65, 0.333, 0, 0.167};
}

/// The same where a lattice fills the interior; its density is known.
template <int D>
constexpr Weights kLatticeWeights = D == 3 ? Weights{1, -0.135, 0.1436, 0} : Weights{-0.69, 0.508, 0, 0};

/// Each piece by its center.
template <int D, int M>
void append(std::vector<CountedPoint<D>>& points, const std::vector<Piece<D, M>>& pieces, double weight,
            double weight_if_constant) {
  for (const Piece<D, M>& piece : pieces) {
    Vec<D> center;
    for (const Vec<D>& x : piece.corner) center += x / (M + 1.0);
    points.push_back({center, M, (piece.is_exact ? weight_if_constant : weight) * piece.integral});
  }
}

/// The lattice of a plateau goes on beside it where it fits; walls and the Lipschitz condition leave so much of that.
constexpr double kLatticeBeside = 0.6;

/// Spheres of a lattice per unit of the integral of f^-D where f is constant. Lattices come in few sizes, one of which
/// fits the plateau: others are up to 2.8 times (in the plane 2.9 times) as dense as they had to be.
template <int D>
double lattice_density(const LatticeFamily<D>& lattices, int cls, double f) {
  const double spheres_per_cell = D == 3 ? 2 : 2 / std::sqrt(3.0);
  return spheres_per_cell * std::pow(f / lattices.side(cls), D);
}

template <int D>
void append_interior(const std::vector<IntegralSample<D>>& samples, const Spacing<D>& f, double weight,
                     bool has_lattice, CountEstimate<D>& estimate) {
  std::vector<std::optional<double>> constant(samples.size());
  std::vector<double> value(samples.size());
  std::map<double, double> integral;  // By value of f.
  double largest = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vec<D>& x = samples[i].position;
    const double here = value[i] = f(x);
    largest = std::max(largest, here);
    if (!has_lattice) continue;
    Box<D> near(x, x);
    near.inflate(here);
    constant[i] = f.constant_on(near);
    if (constant[i]) integral[*constant[i]] += samples[i].part;
  }
  const auto most =
      std::ranges::max_element(integral, {}, [](const auto& value_and_part) { return value_and_part.second; });
  if (most != integral.end()) estimate.plateau = most->first;
  const LatticeFamily<D> lattices({}, estimate.plateau.value_or(largest), largest, 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double density = weight;
    if (constant[i]) {
      density = lattice_density(lattices, *lattices.class_for(*constant[i], *constant[i]), value[i]);
    } else if (estimate.plateau && value[i] >= *estimate.plateau) {
      if (const auto cls = lattices.class_for(*estimate.plateau, value[i]))
        density += kLatticeBeside * (lattice_density(lattices, *cls, value[i]) - weight);
    }
    estimate.points.push_back({samples[i].position, D, samples[i].part * density});
  }
}

}  // namespace

template <int D>
double CountEstimate<D>::count() const {
  double sum = 0;
  for (const CountedPoint<D>& p : points) sum += p.count;
  return sum;
}

template <int D>
CountEstimate<D> estimate_count(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options) {
  const bool has_lattice = options.form == PackingForm::kVoronoi && options.interior == Interior::kLattice;
  const Weights w = weights_of<D>(options.form), where_constant = has_lattice ? kLatticeWeights<D> : w;
  CountEstimate<D> estimate;
  std::vector<CountedPoint<D>>& points = estimate.points;
  for (const Vec<D>& x : domain.points) points.push_back({x, 0, w.points});
  append(points, integrate_over_segments(domain, spacing), w.segments, where_constant.segments);
  if constexpr (D == 3) append(points, integrate_over_facets(domain, spacing), w.facets, where_constant.facets);
  append_interior(spacing.integral_samples(domain), spacing, w.regions, has_lattice, estimate);
  return estimate;
}

template <int D>
double estimate_sphere_count(const Domain<D>& domain, const Spacing<D>& spacing, const PackingOptions& options) {
  return std::max(static_cast<double>(domain.points.size()), estimate_count(domain, spacing, options).count());
}

template <int D>
std::vector<CostlyFeature<D>> estimate_costliest_features(const Domain<D>& domain, const Spacing<D>& spacing,
                                                          const PackingOptions& options) {
  return attribute(domain, spacing, estimate_count(domain, spacing, options).points);
}

#define VOROPACK_INSTANTIATE(D)                                                                           \
  template struct CountEstimate<D>;                                                                       \
  template CountEstimate<D> estimate_count(const Domain<D>&, const Spacing<D>&, const PackingOptions&);   \
  template double estimate_sphere_count(const Domain<D>&, const Spacing<D>&, const PackingOptions&);      \
  template std::vector<CostlyFeature<D>> estimate_costliest_features(const Domain<D>&, const Spacing<D>&, \
                                                                     const PackingOptions&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
