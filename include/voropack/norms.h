// Stage 7: norms of section 2.3 of [Miller1996] over dual faces, and errors of P1 functions on a mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "voropack/mesh.h"

namespace voropack {

/// One value per dual face, in the direction from the first to the second vertex of the edge.
using EdgeValues = IdVector<DualFaceId, double>;
using VertexValues = IdVector<VertexId, double>;
/// [n_vertices] 1 for the vertices of a set, else 0.
using VertexFlags = IdVector<VertexId, std::uint8_t>;

/// The vertices of faces that have a simplex on one side only.
template <int D>
VertexFlags find_hull_vertices(const Mesh<D>& mesh);

/// [edge] U_ij = (u_i - u_j) / h_ij.
template <int D>
EdgeValues difference_quotients(const ControlVolumes<D>& volumes, const VertexValues& values);

/// [edge] U2_ij of Theorem 2.1: the mean over the dual face of -du/dn, n from i to j. Each simplex adds its signed part
/// of the face, integrated with degree 5. Cost: O(n log n) for n simplices. The same result for any number of threads.
template <int D>
EdgeValues mean_fluxes(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                       const std::function<Vec<D>(const Vec<D>&)>& gradient);

/// (U, V)_W: the sum of |A_ij| h_ij U_ij V_ij over the dual faces whose edge has an end that is not in `boundary`. It
/// is not scaled; with all edges, the sum of |A_ij| h_ij is D times the volume, so that ||U||_W is about the L2 norm of
/// the gradient.
template <int D>
double w_product(const ControlVolumes<D>& volumes, const EdgeValues& a, const EdgeValues& b,
                 const VertexFlags& boundary);

/// The W norm of the difference quotients of `values`.
template <int D>
double w_norm(const ControlVolumes<D>& volumes, const VertexValues& values, const VertexFlags& boundary);

/// values - u at the vertices.
template <int D>
VertexValues vertex_errors(const IdVector<VertexId, Vec<D>>& points, const VertexValues& values,
                           const std::function<double(const Vec<D>&)>& exact);

/// The largest magnitude; NaN if there is one.
double max_norm(const VertexValues& values);

/// || u_h - u || in L2 for the P1 function u_h with the given vertex values, by quadrature of degree 7.
template <int D>
double l2_error(const Mesh<D>& mesh, const VertexValues& values, const std::function<double(const Vec<D>&)>& exact);

/// The same, for a function that is faster for many points at once: all those of a simplex.
template <int D>
double l2_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<void(std::span<const Vec<D>> x, std::span<double> exact)>& exact);

/// || grad(u_h - u) || in L2, by quadrature of degree 7. With `keep`, over the simplices for which it is true.
template <int D>
double h1_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<Vec<D>(const Vec<D>&)>& exact_gradient,
                const std::function<bool(SimplexId)>& keep = {});
template <int D>
double h1_error(const Mesh<D>& mesh, const VertexValues& values,
                const std::function<void(std::span<const Vec<D>> x, std::span<Vec<D>> exact)>& exact_gradient,
                const std::function<bool(SimplexId)>& keep = {});

}  // namespace voropack
