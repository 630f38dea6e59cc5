// The exact flux through dual faces. In a simplex the dual face of an edge is spanned by the midpoint of the edge and
// the circumcenters of the simplex and of its faces at the edge. These parts are signed: where a circumcenter lies
// outside, what one simplex adds too much the next one takes away, and the sum is the integral over the whole face.
#include <algorithm>

#include "base/parallel.h"
#include "geom/quadrature.h"
#include "mesh/p1_gradients.h"
#include "voropack/norms.h"

namespace voropack {

namespace {

template <int D>
using Gradient = std::function<Vec<D>(const Vec<D>&)>;

/// The integral of -du/dn over a simplex's part of the dual face of the edge from corner i to corner j.
double flux_part(const std::array<Vec<2>, 3>& p, const Vec<2>& center, std::size_t i, std::size_t j,
                 const Gradient<2>& gradient) {
  const Vec<2> normal = (p[j] - p[i]) / distance(p[i], p[j]);
  const std::array<Vec<2>, 2> part = {0.5 * (p[i] + p[j]), center};
  // The third corner lies to the left of the edge if i, j is in the order of the corners.
  const bool is_left = j == (i + 1) % 3;
  const double length = (is_left ? 1 : -1) * cross(normal, part[1] - part[0]);
  double mean = 0;
  for (const QuadraturePoint<1>& q : kQuadrature<1>) mean -= q.weight * dot(gradient(q.at(part)), normal);
  return length * mean;
}

double flux_part(const std::array<Vec<3>, 4>& p, const Vec<3>& center, std::size_t i, std::size_t j,
                 const Gradient<3>& gradient) {
  const Vec<3> normal = (p[j] - p[i]) / distance(p[i], p[j]), middle = 0.5 * (p[i] + p[j]);
  // The other corners k and l, so that (i, j, k, l) is positively oriented.
  std::size_t k = 0;
  while (k == i || k == j) ++k;
  std::size_t l = 6 - i - j - k;
  if (((i > j) + (i > k) + (i > l) + (j > k) + (j > l)) % 2 == 1) std::swap(k, l);
  double flux = 0;
  const auto add = [&](const std::array<Vec<3>, 3>& part) {
    const double area = 0.5 * dot(cross(part[1] - part[0], part[2] - part[0]), normal);
    double mean = 0;
    for (const QuadraturePoint<2>& q : kQuadrature<2>) mean -= q.weight * dot(gradient(q.at(part)), normal);
    flux += area * mean;
  };
  add({middle, triangle_circumcenter(p[i], p[j], p[k]), center});
  add({middle, center, triangle_circumcenter(p[i], p[j], p[l])});
  return flux;
}

/// The dual face of an edge in a region; none if its area is zero.
template <int D>
DualFaceId find_face(const ControlVolumes<D>& volumes, std::array<VertexId, 2> edge, int region) {
  if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
  const auto& all = volumes.face_vertices;
  DualFaceId f(static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), edge) - all.begin()));
  while (f.value() < all.size() && all[f] == edge && volumes.face_region[f] != region) ++f;
  return f.value() < all.size() && all[f] == edge ? f : DualFaceId::none();
}

}  // namespace

template <int D>
EdgeValues mean_fluxes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const Gradient<D>& gradient) {
  constexpr std::size_t kEdges = D * (D + 1) / 2;
  IdVector<SimplexId, std::array<double, kEdges>> parts(mesh.simplex_vertices.size());
  IdVector<SimplexId, std::array<DualFaceId, kEdges>> faces(mesh.simplex_vertices.size());
  parallel_for(parts.size(), [&](std::size_t number) {
    const SimplexId s(number);
    const auto p = corner_positions(mesh, s);
    const Vec<D> center = circumcenter<D>(p);
    const auto& corners = mesh.simplex_vertices[s];
    std::size_t edge = 0;
    for (std::size_t a = 0; a <= D; ++a)
      for (std::size_t b = a + 1; b <= D; ++b, ++edge) {
        faces[s][edge] = find_face(volumes, {corners[a], corners[b]}, mesh.simplex_region[s]);
        const bool is_ascending = corners[a] < corners[b];
        parts[s][edge] = flux_part(p, center, is_ascending ? a : b, is_ascending ? b : a, gradient);
      }
  });
  EdgeValues means(volumes.face_area.size(), 0.0);
  for (const SimplexId s : ids(parts))
    for (std::size_t edge = 0; edge < kEdges; ++edge)
      if (!faces[s][edge].is_none()) means[faces[s][edge]] += parts[s][edge];
  for (const DualFaceId f : ids(means)) means[f] /= volumes.face_area[f];
  return means;
}

template EdgeValues mean_fluxes(const Mesh<2>&, const ControlVolumes<2>&, const Gradient<2>&);
template EdgeValues mean_fluxes(const Mesh<3>&, const ControlVolumes<3>&, const Gradient<3>&);

}  // namespace voropack
