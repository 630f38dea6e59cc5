// The checks of the certificate. Each takes the subject and returns a finished Certificate::Check.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "certificate/box_tree.h"
#include "certificate/geometry.h"
#include "certificate/sharp_features.h"
#include "certificate/tally.h"
#include "certificate/topology.h"
#include "voropack/certificate.h"

namespace voropack::judge {

using Check = Certificate::Check;

/// Blocks of this many elements are the units of parallel work; results do not depend on it but for rounding of sums.
inline constexpr std::size_t kBlock = 4096;

/// All finite vertices in a tree, with their spacings as weights, and copies of the data in the tree's order.
template <int D>
struct VertexTree {
  BoxTree<D> tree;
  std::vector<std::uint32_t> id;  ///< [n] vertex at each position of the tree.
  std::vector<Vec<D>> point;      ///< [n]
  std::vector<double> spacing;    ///< [n], 0 where there is none or it is not positive and finite.
};

/// A protecting ball: the smallest ball through the corners of a boundary simplex or segment edge.
template <int D>
struct ProtectingBall {
  std::array<std::uint32_t, D> corner{};  ///< The first n_corners are used.
  int n_corners = 0;                      ///< 2: edge ball (Lemma 3.8, case 1), 3: face ball (case 2).
  std::uint32_t index = 0;                ///< In the boundary complex, or in the list of segment edges.
  bool is_segment_edge = false;           ///< 3D only.
  bool derived = false;                   ///< An edge that is no part of the file: explains a circumcenter, untested.
  DiametralBall<D> ball;
};

template <int D>
struct Subject {
  const Mesh<D>& mesh;
  const ControlVolumes<D>& volumes;
  const Domain<D>* domain;
  const CertificateOptions& options;
  const Observer& observer;
  const Topology<D>& topology;
  VertexTree<D> vertices;
  std::vector<ProtectingBall<D>> balls;
  SharpFeatures<D> sharp;
  bool has_spacing = false;
  double gradation = 0;  ///< b: claimed, or measured by `check_spacing_lipschitz`.

  [[nodiscard]] double spacing(std::uint32_t v) const { return mesh.vertex_spacing[VertexId(v)]; }
  [[nodiscard]] const Vec<D>& point(std::uint32_t v) const { return mesh.points[VertexId(v)]; }

  // Elements in words, for `where`.
  [[nodiscard]] std::string vertex_text(std::uint32_t v) const;
  [[nodiscard]] std::string simplex_text(std::uint32_t s) const;
  [[nodiscard]] std::string boundary_text(std::uint32_t b) const;
  [[nodiscard]] std::string ball_text(const ProtectingBall<D>& ball) const;
};

template <int D>
VertexTree<D> build_vertex_tree(const Mesh<D>& mesh, const Topology<D>& topology, bool has_spacing);
template <int D>
std::vector<ProtectingBall<D>> list_protecting_balls(const Mesh<D>& mesh, const Topology<D>& topology);

/// Vertices at (nearly) the same place, found while looking for overlapping spheres.
struct Duplicates {
  Tally tally;  ///< ids: the two vertices.
};

template <int D>
Check check_packing(const Subject<D>& subject, Duplicates& duplicates);
/// Also returns the largest slope seen.
template <int D>
Check check_spacing_lipschitz(const Subject<D>& subject, double& measured);
template <int D>
Check check_delaunay(const Subject<D>& subject, const Tally& structure);
template <int D>
Check check_protecting_balls(const Subject<D>& subject);
/// voronoi_maximal, voronoi_containment and radius_edge: one pass over the circumcenters.
template <int D>
std::array<Check, 3> check_circumcenters(const Subject<D>& subject);
template <int D>
Check check_conformity(const Subject<D>& subject, const Duplicates& duplicates);
/// dual_nonnegative, volume_sum and closure.
template <int D>
std::array<Check, 3> check_volumes(const Subject<D>& subject);

}  // namespace voropack::judge
