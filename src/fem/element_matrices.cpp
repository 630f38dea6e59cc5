// P1 matrices and load vectors, row by row: a vertex sums over its simplices in ascending order, so that the result
// does not depend on the number of threads and (i, j) equals (j, i) to the bit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "fem/coefficient.h"
#include "fem/element_matrices.h"
#include "geom/quadrature.h"
#include "mesh/incidence.h"
#include "mesh/p1_gradients.h"
#include "voropack/error.h"
#include "voropack/fem.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 1024;  // Vertices per task.

template <int D>
using LocalMatrix = std::array<ElementTerms<D>, D + 1>;

struct Entry {
  std::uint32_t column;
  double value;
};

/// Sums entries of equal column, in their order.
void merge_columns(std::vector<Entry>& row) {
  std::stable_sort(row.begin(), row.end(), [](const Entry& a, const Entry& b) { return a.column < b.column; });
  std::size_t n = 0;
  for (const Entry& entry : row) {
    if (n > 0 && row[n - 1].column == entry.column)
      row[n - 1].value += entry.value;
    else
      row[n++] = entry;
  }
  row.resize(n);
}

/// Appends the rows of `block` to `matrix`.
void append_rows(SparseMatrix& matrix, const SparseMatrix& block) {
  const std::uint64_t first = matrix.columns.size();
  matrix.columns.insert(matrix.columns.end(), block.columns.begin(), block.columns.end());
  matrix.values.insert(matrix.values.end(), block.values.begin(), block.values.end());
  for (std::size_t r = 1; r < block.offsets.size(); ++r) matrix.offsets.push_back(first + block.offsets[r]);
}

/// The matrix that has `local(s)` added for each simplex s. Its diagonal is listed also where it is 0.
template <int D, class LocalMatrixOf>
SparseMatrix add_up(const Mesh<D>& mesh, const LocalMatrixOf& local_of) {
  IdVector<SimplexId, LocalMatrix<D>> local(mesh.simplex_vertices.size());
  parallel_for(local.size(), [&](std::size_t s) { local[SimplexId(s)] = local_of(SimplexId(s)); });
  const auto vertex_simplices = invert_incidence<VertexId>(mesh.simplex_vertices, mesh.points.size());
  const std::size_t n = mesh.points.size(), n_blocks = (n + kBlock - 1) / kBlock;
  std::vector<SparseMatrix> blocks(n_blocks);
  parallel_for(
      n_blocks,
      [&](std::size_t b) {
        std::vector<Entry> row;
        for (std::size_t v = b * kBlock; v < std::min(n, (b + 1) * kBlock); ++v) {
          row.assign(1, {static_cast<std::uint32_t>(v), 0.0});
          for (const SimplexId s : vertex_simplices[VertexId(v)]) {
            const auto& corners = mesh.simplex_vertices[s];
            const auto own = std::find(corners.begin(), corners.end(), VertexId(v)) - corners.begin();
            for (std::size_t j = 0; j <= D; ++j)
              row.push_back({corners[j].value(), local[s][static_cast<std::size_t>(own)][j]});
          }
          merge_columns(row);
          for (const Entry& entry : row) {
            blocks[b].columns.push_back(entry.column);
            blocks[b].values.push_back(entry.value);
          }
          blocks[b].offsets.push_back(blocks[b].columns.size());
        }
      },
      1);
  SparseMatrix matrix;
  for (const SparseMatrix& block : blocks) append_rows(matrix, block);
  return matrix;
}

/// The mean of a coefficient over a simplex.
template <int D>
double mean_over(const Coefficient<D>& coefficient, const Mesh<D>& mesh, SimplexId s,
                 const std::array<Vec<D>, D + 1>& p) {
  if (const auto* const constant = std::get_if<double>(&coefficient)) return *constant;
  double mean = 0;
  for (const QuadraturePoint<D>& q : kQuadrature<D>)
    mean += q.weight * value_at(coefficient, mesh, s, q.barycentric, q.at(p));
  return mean;
}

[[noreturn]] void throw_at(const char* id, std::string message, const char* fix, std::vector<double> position) {
  throw InputError(Fault{.id = id, .message = std::move(message), .fix = fix, .position = std::move(position)});
}

template <int D>
LocalMatrix<D> local_stiffness(const Mesh<D>& mesh, const Coefficient<D>& conductivity, SimplexId s) {
  const auto p = corner_positions(mesh, s);
  const P1Gradients<D> g = p1_gradients<D>(p);
  if (!(g.determinant > 0))
    throw_at("mesh.degenerate_simplex",
             fmt::format("simplex {} (counted from 0) is flat or not positively oriented", s.value()),
             "orient all simplices positively and remove flat ones", {p[0].coord.begin(), p[0].coord.end()});
  const double kappa = mean_over(conductivity, mesh, s, p);
  if (!(kappa > 0) || !std::isfinite(kappa))
    throw_at("solve.bad_conductivity",
             fmt::format("the conductivity is {} on simplex {} (counted from 0)", kappa, s.value()),
             "give a positive, finite conductivity", {p[0].coord.begin(), p[0].coord.end()});
  const double scale = kappa / (kFactorial<D> * g.determinant);
  LocalMatrix<D> local;
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t j = 0; j <= D; ++j) local[i][j] = scale * dot(g.normal[i], g.normal[j]);
  return local;
}

template <int D>
LocalMatrix<D> local_mass(const Mesh<D>& mesh, const Coefficient<D>& reaction, SimplexId s) {
  const auto p = corner_positions(mesh, s);
  const double volume = simplex_determinant<D>(p) / kFactorial<D>;
  LocalMatrix<D> local{};
  for (const QuadraturePoint<D>& q : kQuadrature<D>) {
    const double weight = volume * q.weight * value_at(reaction, mesh, s, q.barycentric, q.at(p));
    for (std::size_t i = 0; i <= D; ++i)
      for (std::size_t j = 0; j <= D; ++j) local[i][j] += weight * (q.barycentric[i] * q.barycentric[j]);
  }
  return local;
}

}  // namespace

template <int D>
ElementTerms<D> element_diffusion(const Mesh<D>& mesh, const Coefficient<D>& conductivity, SimplexId s,
                                  const IdVector<VertexId, double>& u) {
  const auto p = corner_positions(mesh, s);
  const P1Gradients<D> g = p1_gradients<D>(p);
  const auto& corners = mesh.simplex_vertices[s];
  Vec<D> gradient;  // Times the determinant. Differences of values first: that of a constant is exactly zero.
  for (std::size_t i = 1; i <= D; ++i) gradient += (u[corners[i]] - u[corners[0]]) * g.normal[i];
  const double scale = mean_over(conductivity, mesh, s, p) / (kFactorial<D> * g.determinant);
  ElementTerms<D> terms{};
  for (std::size_t i = 1; i <= D; ++i) {
    terms[i] = scale * dot(g.normal[i], gradient);
    terms[0] -= terms[i];
  }
  return terms;
}

template <int D>
ElementTerms<D> element_absorption(const Mesh<D>& mesh, const Coefficient<D>& reaction, SimplexId s,
                                   const IdVector<VertexId, double>& u) {
  const LocalMatrix<D> mass = local_mass(mesh, reaction, s);
  ElementTerms<D> terms{};
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t j = 0; j <= D; ++j) terms[i] += mass[i][j] * u[mesh.simplex_vertices[s][j]];
  return terms;
}

template <int D>
ElementTerms<D> element_load(const Mesh<D>& mesh, const Coefficient<D>& source, SimplexId s) {
  const auto p = corner_positions(mesh, s);
  const double volume = simplex_determinant<D>(p) / kFactorial<D>;
  ElementTerms<D> terms{};
  for (const QuadraturePoint<D>& q : kQuadrature<D>) {
    const double value = volume * q.weight * value_at(source, mesh, s, q.barycentric, q.at(p));
    for (std::size_t i = 0; i <= D; ++i) terms[i] += value * q.barycentric[i];
  }
  return terms;
}

template <int D>
SparseMatrix stiffness_matrix(const Mesh<D>& mesh, const Coefficient<D>& conductivity) {
  check_coefficient(conductivity, mesh, "the conductivity");
  return add_up<D>(mesh, [&](SimplexId s) { return local_stiffness(mesh, conductivity, s); });
}

template <int D>
SparseMatrix mass_matrix(const Mesh<D>& mesh, const Coefficient<D>& reaction) {
  check_coefficient(reaction, mesh, "the reaction");
  return add_up<D>(mesh, [&](SimplexId s) { return local_mass(mesh, reaction, s); });
}

template <int D>
IdVector<VertexId, double> load_vector(const Mesh<D>& mesh, const Coefficient<D>& source) {
  check_coefficient(source, mesh, "the source");
  // Simplex by simplex in parallel, since f may be costly; then in order.
  IdVector<SimplexId, ElementTerms<D>> local(mesh.simplex_vertices.size());
  parallel_for(local.size(), [&](std::size_t k) { local[SimplexId(k)] = element_load(mesh, source, SimplexId(k)); });
  IdVector<VertexId, double> load(mesh.points.size(), 0.0);
  for (const SimplexId s : ids(local))
    for (std::size_t i = 0; i <= D; ++i) load[mesh.simplex_vertices[s][i]] += local[s][i];
  return load;
}

template SparseMatrix stiffness_matrix(const Mesh<2>&, const Coefficient<2>&);
template SparseMatrix stiffness_matrix(const Mesh<3>&, const Coefficient<3>&);
template SparseMatrix mass_matrix(const Mesh<2>&, const Coefficient<2>&);
template SparseMatrix mass_matrix(const Mesh<3>&, const Coefficient<3>&);
template IdVector<VertexId, double> load_vector(const Mesh<2>&, const Coefficient<2>&);
template IdVector<VertexId, double> load_vector(const Mesh<3>&, const Coefficient<3>&);
template ElementTerms<2> element_diffusion(const Mesh<2>&, const Coefficient<2>&, SimplexId,
                                           const IdVector<VertexId, double>&);
template ElementTerms<2> element_absorption(const Mesh<2>&, const Coefficient<2>&, SimplexId,
                                            const IdVector<VertexId, double>&);
template ElementTerms<2> element_load(const Mesh<2>&, const Coefficient<2>&, SimplexId);
template ElementTerms<3> element_diffusion(const Mesh<3>&, const Coefficient<3>&, SimplexId,
                                           const IdVector<VertexId, double>&);
template ElementTerms<3> element_absorption(const Mesh<3>&, const Coefficient<3>&, SimplexId,
                                            const IdVector<VertexId, double>&);
template ElementTerms<3> element_load(const Mesh<3>&, const Coefficient<3>&, SimplexId);

}  // namespace voropack
