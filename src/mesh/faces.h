// How the faces of a simplex are numbered and oriented, and where the regions of a mesh end.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "voropack/mesh.h"

namespace voropack {

/// Corners of the face opposite to corner i, so that (face, corner i) is positively oriented when the simplex is.
template <int D>
inline constexpr std::array<std::array<int, D>, D + 1> kFaceCorners = {};
template <>
inline constexpr std::array<std::array<int, 2>, 3> kFaceCorners<2> = {{{1, 2}, {2, 0}, {0, 1}}};
template <>
inline constexpr std::array<std::array<int, 3>, 4> kFaceCorners<3> = {{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

/// The face opposite to corner i as vertices, oriented as kFaceCorners.
template <int D>
std::array<VertexId, D> face_vertices(const std::array<VertexId, D + 1>& simplex, int i) {
  std::array<VertexId, D> face;
  for (std::size_t k = 0; k < D; ++k)
    face[k] = simplex[static_cast<std::size_t>(kFaceCorners<D>[static_cast<std::size_t>(i)][k])];
  return face;
}

template <int D>
std::array<VertexId, D> face_vertices(const Mesh<D>& mesh, SimplexId s, int i) {
  return face_vertices<D>(mesh.simplex_vertices[s], i);
}

/// The same with the corner known at compile time.
template <int D, std::size_t I>
std::array<VertexId, D> face_vertices(const std::array<VertexId, D + 1>& simplex) {
  std::array<VertexId, D> face;
  for (std::size_t k = 0; k < D; ++k) face[k] = simplex[static_cast<std::size_t>(kFaceCorners<D>[I][k])];
  return face;
}

/// The face opposite to corner i as a mesh lists its boundary: in space counterclockwise seen from outside of a
/// positively oriented simplex, in the plane with the simplex to its left.
template <int D>
std::array<VertexId, D> boundary_face(const std::array<VertexId, D + 1>& simplex, int i) {
  std::array<VertexId, D> face = face_vertices<D>(simplex, i);
  if constexpr (D == 3) std::swap(face[1], face[2]);
  return face;
}

/// The neighbor across the face opposite to corner i if it lies in the same region; none where the region ends.
///
/// An internal facet with one region on both sides does not end the region: the two parts of a dual edge that it cuts
/// add up to the whole.
template <int D>
SimplexId neighbor_in_region(const Mesh<D>& mesh, SimplexId s, int i) {
  const SimplexId t = mesh.simplex_neighbors[s][static_cast<std::size_t>(i)];
  return !t.is_none() && mesh.simplex_region[t] == mesh.simplex_region[s] ? t : SimplexId::none();
}

/// The corner of t opposite to the face that it shares with s.
template <int D>
int mirror_corner(const Mesh<D>& mesh, SimplexId s, SimplexId t, int corner_of_s) {
  const auto& neighbors = mesh.simplex_neighbors[t];
  int match = -1, n_matches = 0;
  for (int k = 0; k <= D; ++k) {
    if (neighbors[static_cast<std::size_t>(k)] == s) {
      match = k;
      ++n_matches;
    }
  }
  if (n_matches == 1) return match;
  // Two simplices that share two faces (a mesh of very few simplices): compare the faces themselves.
  for (int k = 0; k <= D; ++k) {
    if (neighbors[static_cast<std::size_t>(k)] != s) continue;
    const VertexId apex = mesh.simplex_vertices[t][static_cast<std::size_t>(k)];
    bool on_face = false;
    for (int c = 0; c <= D; ++c)
      on_face |= c != corner_of_s && mesh.simplex_vertices[s][static_cast<std::size_t>(c)] == apex;
    if (!on_face) return k;
  }
  return match;
}

}  // namespace voropack
