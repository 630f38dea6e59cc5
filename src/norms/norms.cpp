#include "voropack/norms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/parallel.h"
#include "geom/quadrature.h"
#include "mesh/faces.h"
#include "mesh/p1_gradients.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 4096;  // Simplices or dual faces per task.

double sum_blocks(std::size_t n, const auto& term) {
  return parallel_reduce_ordered(
      n, kBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += term(i);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

}  // namespace

template <int D>
VertexFlags find_hull_vertices(const Mesh<D>& mesh) {
  VertexFlags flags(mesh.points.size(), 0);
  for (const SimplexId s : ids(mesh.simplex_vertices))
    for (int i = 0; i <= D; ++i)
      if (mesh.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none())
        for (const VertexId v : face_vertices(mesh, s, i)) flags[v] = 1;
  return flags;
}

template <int D>
EdgeValues difference_quotients(const ControlVolumes<D>& volumes, const VertexValues& values) {
  EdgeValues quotients(volumes.face_vertices.size());
  parallel_for(quotients.size(), [&](std::size_t k) {
    const DualFaceId f(k);
    const auto [i, j] = volumes.face_vertices[f];
    quotients[f] = (values[i] - values[j]) / volumes.face_edge_length[f];
  });
  return quotients;
}

template <int D>
double w_product(const ControlVolumes<D>& volumes, const EdgeValues& a, const EdgeValues& b,
                 const VertexFlags& boundary) {
  return sum_blocks(volumes.face_area.size(), [&](std::size_t k) {
    const DualFaceId f(k);
    const auto [i, j] = volumes.face_vertices[f];
    const bool counts = boundary[i] == 0 || boundary[j] == 0;
    return counts ? volumes.face_area[f] * volumes.face_edge_length[f] * a[f] * b[f] : 0.0;
  });
}

template <int D>
double w_norm(const ControlVolumes<D>& volumes, const VertexValues& values, const VertexFlags& boundary) {
  const EdgeValues quotients = difference_quotients(volumes, values);
  return std::sqrt(w_product(volumes, quotients, quotients, boundary));
}

template <int D>
VertexValues vertex_errors(const IdVector<VertexId, Vec<D>>& points, const VertexValues& values,
                           const std::function<double(const Vec<D>&)>& exact) {
  VertexValues errors(points.size());
  for (const VertexId v : ids(points)) errors[v] = values[v] - exact(points[v]);
  return errors;
}

double max_norm(const VertexValues& values) {
  double largest = 0;
  for (const double x : values) {
    if (std::isnan(x)) return x;
    largest = std::max(largest, std::abs(x));
  }
  return largest;
}

namespace {

/// Where a simplex is integrated over.
template <int D>
std::array<Vec<D>, kFineQuadrature<D>.size()> fine_points(const std::array<Vec<D>, D + 1>& p) {
  std::array<Vec<D>, kFineQuadrature<D>.size()> x;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = kFineQuadrature<D>[k].at(p);
  return x;
}

/// A function of one point as one of many.
template <int D, class T>
auto of_many(const std::function<T(const Vec<D>&)>& function) {
  return [&function](std::span<const Vec<D>> x, std::span<T> values) {
    for (std::size_t k = 0; k < x.size(); ++k) values[k] = function(x[k]);
  };
}

}  // namespace

template <int D>
double l2_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<void(std::span<const Vec<D>>, std::span<double>)>& exact) {
  return std::sqrt(sum_blocks(mesh.simplex_vertices.size(), [&](std::size_t s_index) {
    const SimplexId s(s_index);
    const auto p = corner_positions(mesh, s);
    const auto x = fine_points<D>(p);
    std::array<double, x.size()> wanted;
    exact(x, wanted);
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const QuadraturePoint<D>& q = kFineQuadrature<D>[k];
      double value = 0;
      for (std::size_t i = 0; i <= D; ++i) value += q.barycentric[i] * values[mesh.simplex_vertices[s][i]];
      const double error = value - wanted[k];
      sum += q.weight * error * error;
    }
    return sum * simplex_determinant<D>(p) / kFactorial<D>;
  }));
}

template <int D>
double l2_error(const Mesh<D>& mesh, const VertexValues& values, const std::function<double(const Vec<D>&)>& exact) {
  return l2_error<D>(mesh, values, std::function<void(std::span<const Vec<D>>, std::span<double>)>(of_many<D>(exact)));
}

template <int D>
double h1_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<void(std::span<const Vec<D>>, std::span<Vec<D>>)>& exact_gradient,
                const std::function<bool(SimplexId)>& keep) {
  return std::sqrt(sum_blocks(mesh.simplex_vertices.size(), [&](std::size_t s_index) {
    const SimplexId s(s_index);
    if (keep && !keep(s)) return 0.0;
    const auto p = corner_positions(mesh, s);
    const P1Gradients<D> g = p1_gradients<D>(p);
    // Differences of values first: the gradient of a constant is exactly zero.
    const auto& corners = mesh.simplex_vertices[s];
    Vec<D> gradient;
    for (std::size_t i = 1; i <= D; ++i) gradient += (values[corners[i]] - values[corners[0]]) * g.normal[i];
    gradient = gradient / g.determinant;
    const auto x = fine_points<D>(p);
    std::array<Vec<D>, x.size()> wanted;
    exact_gradient(x, wanted);
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) sum += kFineQuadrature<D>[k].weight * norm_sq(gradient - wanted[k]);
    return sum * g.determinant / kFactorial<D>;
  }));
}

template <int D>
double h1_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<Vec<D>(const Vec<D>&)>& exact_gradient,
                const std::function<bool(SimplexId)>& keep) {
  return h1_error<D>(mesh, values,
                     std::function<void(std::span<const Vec<D>>, std::span<Vec<D>>)>(of_many<D>(exact_gradient)), keep);
}

template VertexFlags find_hull_vertices(const Mesh<2>&);
template EdgeValues difference_quotients(const ControlVolumes<2>&, const VertexValues&);
template double w_product(const ControlVolumes<2>&, const EdgeValues&, const EdgeValues&, const VertexFlags&);
template double w_norm(const ControlVolumes<2>&, const VertexValues&, const VertexFlags&);
template VertexValues vertex_errors(const IdVector<VertexId, Vec<2>>&, const VertexValues&,
                                    const std::function<double(const Vec<2>&)>&);
template double l2_error(const Mesh<2>&, const VertexValues&, const std::function<double(const Vec<2>&)>&);
template double l2_error(const Mesh<2>&, const VertexValues&,
                         const std::function<void(std::span<const Vec<2>>, std::span<double>)>&);
template double h1_error(const Mesh<2>&, const VertexValues&,
                         const std::function<void(std::span<const Vec<2>>, std::span<Vec<2>>)>&,
                         const std::function<bool(SimplexId)>&);
template double h1_error(const Mesh<2>&, const VertexValues&, const std::function<Vec<2>(const Vec<2>&)>&,
                         const std::function<bool(SimplexId)>&);

template VertexFlags find_hull_vertices(const Mesh<3>&);
template EdgeValues difference_quotients(const ControlVolumes<3>&, const VertexValues&);
template double w_product(const ControlVolumes<3>&, const EdgeValues&, const EdgeValues&, const VertexFlags&);
template double w_norm(const ControlVolumes<3>&, const VertexValues&, const VertexFlags&);
template VertexValues vertex_errors(const IdVector<VertexId, Vec<3>>&, const VertexValues&,
                                    const std::function<double(const Vec<3>&)>&);
template double l2_error(const Mesh<3>&, const VertexValues&, const std::function<double(const Vec<3>&)>&);
template double l2_error(const Mesh<3>&, const VertexValues&,
                         const std::function<void(std::span<const Vec<3>>, std::span<double>)>&);
template double h1_error(const Mesh<3>&, const VertexValues&,
                         const std::function<void(std::span<const Vec<3>>, std::span<Vec<3>>)>&,
                         const std::function<bool(SimplexId)>&);
template double h1_error(const Mesh<3>&, const VertexValues&, const std::function<Vec<3>(const Vec<3>&)>&,
                         const std::function<bool(SimplexId)>&);

}  // namespace voropack
