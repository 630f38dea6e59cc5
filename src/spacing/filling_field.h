// A size field on a mesh that fills the domain, Lipschitz at its nodes: f is linear in the simplex that holds a point.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geom/box_tree.h"
#include "voropack/mesh.h"
#include "voropack/vec.h"

namespace voropack {

struct Interval {
  double lo, hi;
};

/// True if values at the corners of a simplex differ by no more than is Lipschitz, pairwise.
template <int D>
bool is_lipschitz(const std::array<Vec<D>, D + 1>& corners, const std::array<double, D + 1>& values, double slope);

template <int D>
class FillingField {
 public:
  /// `mesh` with its neighbors. `values` by point, Lipschitz along all edges. O(n log n).
  FillingField(const Mesh<D>& mesh, std::vector<double> values, double slope);

  [[nodiscard]] std::size_t size() const { return simplices_.size(); }
  /// The Lipschitz envelope of the field, as seen from x: of what lies across a gap of a domain that is not convex
  /// nothing is asked where a simplex holds x. O(log n).
  [[nodiscard]] double at(const Vec<D>& x) const;
  /// What the values at points of the field in a box are between; zero and infinity where the box may have none.
  [[nodiscard]] Interval range(const Box<D>& box) const;

  /// The value of the field in a box, if it has one value in all simplices whose boxes meet it.
  [[nodiscard]] std::optional<double> constant_on(const Box<D>& box) const;

 private:
  template <std::size_t N>
  [[nodiscard]] std::array<Vec<D>, N> corners(const std::array<VertexId, N>& vertices) const;
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> values(const std::array<VertexId, N>& vertices) const;
  template <std::size_t N>
  [[nodiscard]] Box<D> box(const std::array<VertexId, N>& vertices) const;
  /// A tree over simplices or faces whose values are their least ones.
  template <std::size_t N>
  [[nodiscard]] BoxTree<D> build_tree(const std::vector<std::array<VertexId, N>>& simplices) const;
  void find_dips();
  [[nodiscard]] bool is_steep(const std::array<VertexId, D + 1>& simplex) const;
  /// Nothing if x is outside of the simplex.
  [[nodiscard]] std::optional<double> inside(const std::array<VertexId, D + 1>& simplex, const Vec<D>& x) const;
  /// The least of `bound` and the envelope over a simplex or face at x.
  template <std::size_t N>
  [[nodiscard]] double envelope(const std::array<VertexId, N>& simplex, const Vec<D>& x, double bound) const;

  IdVector<VertexId, Vec<D>> points_;
  std::vector<double> values_;
  double slope_;
  std::vector<std::array<VertexId, D + 1>> simplices_;
  std::vector<std::array<VertexId, D + 1>> steep_;  ///< Those on which the linear function is not Lipschitz.
  std::vector<std::array<VertexId, D>> outer_;      ///< Faces without a neighbor.
  BoxTree<D> tree_, steep_tree_, outer_tree_;       ///< Over these.
  std::vector<double> largest_;                     ///< By node of tree_: the largest value below.
  std::vector<std::uint8_t> has_dip_;  ///< By simplex: whether the envelope of a steep one may be less in it.
};

}  // namespace voropack
