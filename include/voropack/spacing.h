// Stage 2: Domain<D> and wishes -> Spacing<D>: local feature size, user sizes, made Lipschitz exactly.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voropack/domain.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"
#include "voropack/vec.h"

namespace voropack {

/// The local feature size of [Miller1996], section 3: the radius of the smallest closed ball around x that meets two
/// disjoint polytopes of dimension < D. Exact (up to rounding) at every point; infinite where the domain has no two
/// disjoint polytopes.
template <int D>
class LocalFeatureSize {
 public:
  explicit LocalFeatureSize(const Domain<D>& domain);
  ~LocalFeatureSize();
  LocalFeatureSize(LocalFeatureSize&&) noexcept;
  LocalFeatureSize& operator=(LocalFeatureSize&&) noexcept;
  /// Nearest-first search. O(k log n) for k polytopes nearer than the answer. Safe to call from many threads.
  double operator()(const Vec<D>& x) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// What a user asks for. Sizes are mean edge lengths far from features; `spacing` is f itself. Domain units.
template <int D>
struct SizeWishes {
  /// Wanted edge length at the nodes of a mesh, linear in between, without effect outside it (but for the Lipschitz
  /// condition).
  struct Field {
    Mesh<D> mesh;
    std::vector<double> size;  ///< [mesh.points.size()]
    /// Its simplices fill the domain: there is no inside without a size. If the mesh has neighbors and the sizes are
    /// Lipschitz along all edges, too, only the simplex that holds a point is looked at, and constants are seen.
    bool fills_domain = false;
  };
  /// Within a distance of a polyline; with one point, in a ball.
  struct Tube {
    std::vector<Vec<D>> points;
    double radius = 0;  ///< Length; 0: on the line itself.
    double size = 0;
  };
  struct InBox {
    Box<D> box;
    double size = 0;
  };
  std::optional<double> size;         ///< Everywhere.
  std::optional<double> spacing;      ///< Upper bound on f, everywhere.
  std::map<int, double> region_size;  ///< By region id; binds in the region's closure.
  std::map<int, double> marker_size;  ///< By marker of facets, segments or points; binds on them.
  std::optional<Field> field;
  std::optional<Field> spacing_field;  ///< The same for f itself.
  std::vector<Tube> tubes;
  std::vector<InBox> boxes;
  std::optional<std::string> expression;  ///< Edge length as a formula in x, y (and z).
};

/// A ball in which f shall not exceed a value: how a repair shrinks f locally.
template <int D>
struct SpacingCap {
  Vec<D> center;
  double radius;  ///< Length.
  double value;   ///< f <= value in the ball.
  /// The polytopes that are too near to each other there; twice the same if only one is known.
  std::optional<std::array<PolytopeId, 2>> between = std::nullopt;
};

/// One of the functions that geometry makes f the minimum of, at a point: a pair of disjoint polytopes, or a cap.
struct SpacingCause {
  double value;                         ///< Of the function, at the point.
  std::array<PolytopeId, 2> polytopes;  ///< Of a pair: the smaller id first. Of a cap: what is between it.
  double size;                          ///< Of a pair: its distance. Of a cap: the radius of its ball. Length.
  bool is_cap;
};

/// A point that stands for a part of an integral.
template <int D>
struct IntegralSample {
  Vec<D> position;
  double part;
};

struct SpacingOptions {
  double gradation = 0.25;        ///< b, Lipschitz constant of f. In (0, 0.4].
  double feature_factor = 0.75;   ///< a: f <= a * lfs on every polytope of dimension < D. In (0, 1].
  double edge_per_spacing = 3.3;  ///< Mean edge length divided by f, far from features: turns sizes into f.
};

/// f(x) = the smallest of a family of b-Lipschitz functions ("atoms"), hence b-Lipschitz and the same on every thread.
///
/// A quadtree (octree) keeps, in each leaf, the atoms that can be smallest there, so that an evaluation is exact and
/// O(depth + a few). Cheap to copy (shared, immutable).
template <int D>
class Spacing {
 public:
  struct Impl;
  explicit Spacing(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

  /// f(x) > 0. Defined everywhere. Safe to call from many threads.
  double operator()(const Vec<D>& x) const;
  [[nodiscard]] double lipschitz() const;
  [[nodiscard]] double feature_factor() const;
  /// The value if f is known to be constant on `box`, else nothing. Never wrong, but may miss a constant.
  [[nodiscard]] std::optional<double> constant_on(const Box<D>& box) const;
  /// min(f, caps), still b-Lipschitz: cap k contributes value + b * max(0, |x - center| - radius).
  [[nodiscard]] Spacing with_caps(const std::vector<SpacingCap<D>>& caps) const;
  /// The integral of f^-D over the domain, up to some percent: the size that the theory speaks of.
  [[nodiscard]] double integral(const Domain<D>& domain) const;
  /// The same integral as at most 20 000 samples, whose parts add up to it.
  [[nodiscard]] std::vector<IntegralSample<D>> integral_samples(const Domain<D>& domain) const;
  /// What f would be at x without disjoint pairs and caps: what the user's sizes (and the diameter) ask for.
  [[nodiscard]] double wished(const Vec<D>& x) const;
  /// What decides f at x if that is less than `wished`, and what comes next up to `reach` times f(x), the smallest
  /// value first. Of many that come next, those of the nearest polytopes only. By search: tens of microseconds.
  [[nodiscard]] std::vector<SpacingCause> causes(const Vec<D>& x, double reach) const;

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Builds the spacing function of `domain` under `wishes`.
///
/// With b >= a the geometric part is a * lfs itself. With b < a it is the largest minimum over disjoint pairs (P, Q) of
/// b * max(d(x,P), d(x,Q)) + (a - b) * d(P,Q) / 2, which is b-Lipschitz and at most a * lfs (docs/theory/spacing.md).
/// A constant, feature_factor times the diameter, bounds f everywhere; it never binds in the domain's box if there is a
/// disjoint pair. Marker 0 is taken as a name of walls only, since on other polytopes it means that none was given.
///
/// Throws: OptionError spacing.bad_size, spacing.unknown_region, spacing.unknown_marker, spacing.bad_gradation,
///         spacing.bad_feature_factor, spacing.expression (with the column, or the place where it is not positive),
///         spacing.unbounded if the domain has no extent.
///         Cancelled if the observer asks to stop.
template <int D>
Spacing<D> build_spacing(const Domain<D>& domain, const SizeWishes<D>& wishes, const SpacingOptions& options = {},
                         Observer& observer = silent_observer());

}  // namespace voropack
