// Integrals over dual faces, simplex by simplex. In a simplex the dual face of an edge is spanned by the midpoint of
// the edge and the circumcenters of the simplex and of its faces at the edge. These parts are signed: where a
// circumcenter lies outside, what one simplex adds too much the next one takes away, and the sum is the integral over
// the whole face.
#pragma once

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include "base/parallel.h"
#include "mesh/p1_gradients.h"
#include "voropack/norms.h"

namespace voropack {

/// A segment (2D) or triangle (3D) of a dual face.
template <int D>
struct DualFacePart {
  std::array<Vec<D>, D> corners;
  double measure;  ///< Signed: length^(D-1).
};

/// The parts in the simplex p of the dual face of the edge from corner i to corner j.
inline std::array<DualFacePart<2>, 1> dual_face_parts(const std::array<Vec<2>, 3>& p, const Vec<2>& center,
                                                      std::size_t i, std::size_t j) {
  const Vec<2> normal = (p[j] - p[i]) / distance(p[i], p[j]);
  const Vec<2> middle = 0.5 * (p[i] + p[j]);
  // The third corner lies to the left of the edge if i, j is in the order of the corners.
  const bool is_left = j == (i + 1) % 3;
  return {{{{middle, center}, (is_left ? 1 : -1) * cross(normal, center - middle)}}};
}

inline std::array<DualFacePart<3>, 2> dual_face_parts(const std::array<Vec<3>, 4>& p, const Vec<3>& center,
                                                      std::size_t i, std::size_t j) {
  const Vec<3> normal = (p[j] - p[i]) / distance(p[i], p[j]), middle = 0.5 * (p[i] + p[j]);
  // The other corners k and l, so that (i, j, k, l) is positively oriented.
  std::size_t k = 0;
  while (k == i || k == j) ++k;
  std::size_t l = 6 - i - j - k;
  if (((i > j) + (i > k) + (i > l) + (j > k) + (j > l)) % 2 == 1) std::swap(k, l);
  const auto part = [&](const Vec<3>& a, const Vec<3>& b) {
    return DualFacePart<3>{{middle, a, b}, 0.5 * dot(cross(a - middle, b - middle), normal)};
  };
  return {part(triangle_circumcenter(p[i], p[j], p[k]), center), part(center, triangle_circumcenter(p[i], p[j], p[l]))};
}

/// The dual face of an edge in a region; none if its area is zero.
template <int D>
DualFaceId find_dual_face(const ControlVolumes<D>& volumes, std::array<VertexId, 2> edge, int region) {
  if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
  const auto& all = volumes.face_vertices;
  DualFaceId f(static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), edge) - all.begin()));
  while (f.value() < all.size() && all[f] == edge && volumes.face_region[f] != region) ++f;
  return f.value() < all.size() && all[f] == edge ? f : DualFaceId::none();
}

/// [face] the mean over each dual face of what mean_over(corners, normal) is on a part of it; the normal goes from the
/// first to the second vertex of the edge. It may ask for the simplex and that edge, too. Cost: O(n log n). The same
/// result for any number of threads.
template <class Value, int D, class MeanOver>
IdVector<DualFaceId, Value> mean_over_dual_faces(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                                                 MeanOver&& mean_over) {
  constexpr std::size_t kEdges = D * (D + 1) / 2;
  IdVector<SimplexId, std::array<Value, kEdges>> parts(mesh.simplex_vertices.size());
  IdVector<SimplexId, std::array<DualFaceId, kEdges>> faces(mesh.simplex_vertices.size());
  parallel_for(parts.size(), [&](std::size_t number) {
    const SimplexId s(number);
    const auto p = corner_positions(mesh, s);
    const Vec<D> center = circumcenter<D>(p);
    const auto& corners = mesh.simplex_vertices[s];
    std::size_t edge = 0;
    for (std::size_t a = 0; a <= D; ++a)
      for (std::size_t b = a + 1; b <= D; ++b, ++edge) {
        faces[s][edge] = find_dual_face(volumes, {corners[a], corners[b]}, mesh.simplex_region[s]);
        const std::size_t i = corners[a] < corners[b] ? a : b, j = a + b - i;
        const Vec<D> normal = (p[j] - p[i]) / distance(p[i], p[j]);
        Value sum{};
        for (const DualFacePart<D>& part : dual_face_parts(p, center, i, j)) {
          if constexpr (std::is_invocable_v<MeanOver&, const std::array<Vec<D>, D>&, const Vec<D>&>)
            sum += part.measure * mean_over(part.corners, normal);
          else
            sum += part.measure * mean_over(part.corners, normal, s, std::array{corners[i], corners[j]});
        }
        parts[s][edge] = sum;
      }
  });
  IdVector<DualFaceId, Value> means(volumes.face_area.size(), Value{});
  for (const SimplexId s : ids(parts))
    for (std::size_t edge = 0; edge < kEdges; ++edge)
      if (!faces[s][edge].is_none()) means[faces[s][edge]] += parts[s][edge];
  for (const DualFaceId f : ids(means)) means[f] = means[f] / volumes.face_area[f];
  return means;
}

}  // namespace voropack
