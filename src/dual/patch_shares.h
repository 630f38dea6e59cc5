// What single faces, edges and points add to the patches of their vertices.
#pragma once

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <vector>

#include "voropack/mesh.h"

namespace voropack {

/// The vertices of a face, ascending.
template <int D>
using FaceKey = std::array<VertexId, D>;

template <int D>
FaceKey<D> sorted(FaceKey<D> vertices) {
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// One side of a face: what lies there, and the part of the face's area that counts for it.
template <int D>
struct FaceSide {
  FaceKey<D> key;
  int region = 0;
  int marker = 0;
  double weight = 1;
};

/// What one face, edge or point adds to the patch of one of its vertices.
template <int D>
struct Share {
  VertexId vertex;
  int marker = 0, region = 0;
  double area = 0;
  Vec<D> moment;  ///< Area times centroid.

  [[nodiscard]] auto patch() const { return std::tie(vertex, marker, region); }
};

/// The halves of a segment.
template <int D>
void add_segment_shares(const Mesh<D>& mesh, const std::array<VertexId, 2>& segment, int marker, int region,
                        double weight, std::vector<Share<D>>& shares) {
  const std::array<Vec<D>, 2> x = {mesh.points[segment[0]], mesh.points[segment[1]]};
  const double area = 0.5 * weight * distance(x[0], x[1]);
  for (std::size_t k = 0; k < 2; ++k)
    shares.push_back({segment[k], marker, region, area, area * (0.75 * x[k] + 0.25 * x[1 - k])});
}

/// The parts of one side of a face in its corners' cells.
void add_face_shares(const Mesh<2>& mesh, const FaceSide<2>& face, std::vector<Share<2>>& shares);
void add_face_shares(const Mesh<3>& mesh, const FaceSide<3>& face, std::vector<Share<3>>& shares);

/// The patches of `markers`, which no face of the hull has (see build_boundary_areas). `hull` is sorted by key.
template <int D>
void add_inner_shares(const Mesh<D>& mesh, const std::set<int>& markers, const std::vector<FaceSide<D>>& hull,
                      std::vector<Share<D>>& shares);

}  // namespace voropack
