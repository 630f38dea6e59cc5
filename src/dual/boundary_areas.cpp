#include "voropack/boundary_areas.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "dual/patch_shares.h"
#include "geom/kite_halves.h"
#include "mesh/faces.h"

namespace voropack {

namespace {

/// Every face without a neighbor, sorted by its vertices, with the marker that the mesh lists for it.
template <int D>
std::vector<FaceSide<D>> hull_faces(const Mesh<D>& mesh) {
  std::vector<FaceSide<D>> hull;
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i)
      if (mesh.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none())
        hull.push_back({sorted<D>(face_vertices(mesh, s, i)), mesh.simplex_region[s]});
  std::sort(hull.begin(), hull.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  for (const BoundaryId b : ids(mesh.boundary_vertices)) {
    const FaceKey<D> key = sorted<D>(mesh.boundary_vertices[b]);
    const auto found =
        std::lower_bound(hull.begin(), hull.end(), key, [](const auto& face, const auto& k) { return face.key < k; });
    if (found != hull.end() && found->key == key) found->marker = mesh.boundary_marker[b];
  }
  return hull;
}

}  // namespace

void add_face_shares(const Mesh<2>& mesh, const FaceSide<2>& face, std::vector<Share<2>>& shares) {
  add_segment_shares(mesh, face.key, face.marker, face.region, face.weight, shares);
}

void add_face_shares(const Mesh<3>& mesh, const FaceSide<3>& face, std::vector<Share<3>>& shares) {
  std::array<Share<3>, 3> of_corner;
  for (std::size_t a = 0; a < 3; ++a) of_corner[a] = {face.key[a], face.marker, face.region, 0, {}};
  for (const KiteHalf& half :
       kite_halves({mesh.points[face.key[0]], mesh.points[face.key[1]], mesh.points[face.key[2]]})) {
    const double area = face.weight * half.area;
    const auto& [corner, middle, center] = half.corners;
    of_corner[half.corner].area += area;
    of_corner[half.corner].moment += (area / 3) * (corner + middle + center);
  }
  shares.insert(shares.end(), of_corner.begin(), of_corner.end());
}

template <int D>
BoundaryAreas<D> build_boundary_areas(const Mesh<D>& mesh, const std::set<int>& inner_markers) {
  std::vector<Share<D>> shares;
  const std::vector<FaceSide<D>> hull = hull_faces(mesh);
  std::set<int> inside = inner_markers;
  for (const FaceSide<D>& face : hull) {
    add_face_shares(mesh, face, shares);
    inside.erase(face.marker);
  }
  if (!inside.empty()) add_inner_shares(mesh, inside, hull, shares);
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.patch() < b.patch(); });

  BoundaryAreas<D> out;
  for (std::size_t begin = 0, end = 0; begin < shares.size(); begin = end) {
    Share<D> sum = shares[begin];
    for (end = begin + 1; end < shares.size() && shares[end].patch() == sum.patch(); ++end) {
      sum.area += shares[end].area;
      sum.moment += shares[end].moment;
    }
    out.patch_vertex.push_back(sum.vertex);
    out.patch_marker.push_back(sum.marker);
    out.patch_region.push_back(sum.region);
    out.patch_area.push_back(sum.area);
    out.patch_centroid.push_back(sum.area > 0 ? sum.moment / sum.area : mesh.points[sum.vertex]);
  }
  return out;
}

template BoundaryAreas<2> build_boundary_areas(const Mesh<2>&, const std::set<int>&);
template BoundaryAreas<3> build_boundary_areas(const Mesh<3>&, const std::set<int>&);

}  // namespace voropack
