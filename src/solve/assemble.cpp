#include "solve/assemble.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace voropack {

namespace {

/// Whether the face belongs to the edge of the one before it, in another region.
template <int D>
bool repeats_edge(const ControlVolumes<D>& volumes, DualFaceId f) {
  return f.value() > 0 && volumes.face_vertices[f] == volumes.face_vertices[DualFaceId(f.value() - std::size_t{1})];
}

/// Rows with room for the diagonal and an entry for each edge. `diagonal[i]` is the place of entry (i, i): behind one
/// entry for each edge to an earlier vertex.
template <int D>
SparseMatrix empty_rows(const ControlVolumes<D>& volumes, std::vector<std::uint64_t>& diagonal) {
  const std::size_t n = volumes.sites.size();
  SparseMatrix matrix;
  matrix.offsets.assign(n + 1, 0);
  diagonal.assign(n, 0);
  for (const DualFaceId f : ids(volumes.face_vertices)) {
    if (repeats_edge(volumes, f)) continue;
    const auto [i, j] = volumes.face_vertices[f];
    ++matrix.offsets[i.value() + std::size_t{1}];
    ++matrix.offsets[j.value() + std::size_t{1}];
    ++diagonal[j.value()];
  }
  for (std::size_t i = 0; i < n; ++i) {
    matrix.offsets[i + 1] += matrix.offsets[i] + 1;
    diagonal[i] += matrix.offsets[i];
  }
  matrix.columns.resize(matrix.offsets[n]);
  matrix.values.resize(matrix.offsets[n]);
  return matrix;
}

/// The couplings, and minus their sum on the diagonal. Faces are sorted by (i, j): so the entries of a row come in
/// ascending order on either side of the diagonal.
template <int D>
SparseMatrix assemble_couplings(const ControlVolumes<D>& volumes, const CellTerms& terms,
                                std::vector<std::uint64_t>& diagonal) {
  SparseMatrix matrix = empty_rows(volumes, diagonal);
  const std::size_t n = matrix.size();
  std::vector<std::uint64_t> lower(matrix.offsets.begin(), matrix.offsets.end() - 1), upper(n);
  for (std::size_t i = 0; i < n; ++i) {
    upper[i] = diagonal[i] + 1;
    matrix.columns[diagonal[i]] = static_cast<std::uint32_t>(i);
  }
  for (const DualFaceId f : ids(volumes.face_vertices)) {
    const std::uint32_t i = volumes.face_vertices[f][0].value(), j = volumes.face_vertices[f][1].value();
    if (!repeats_edge(volumes, f)) {
      matrix.columns[upper[i]++] = j;
      matrix.columns[lower[j]++] = i;
    }
    const double coupling = terms.coupling[f];
    matrix.values[upper[i] - 1] -= coupling;
    matrix.values[lower[j] - 1] -= coupling;
    matrix.values[diagonal[i]] += coupling;
    matrix.values[diagonal[j]] += coupling;
  }
  return matrix;
}

}  // namespace

template <int D>
LinearSystem assemble_terms(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                            const CellTerms& terms) {
  const std::size_t n = volumes.sites.size();
  std::vector<std::uint64_t> diagonal;
  LinearSystem system{.matrix = assemble_couplings(volumes, terms, diagonal),
                      .load = IdVector<VertexId, double>(n),
                      .absorption = IdVector<VertexId, double>(n),
                      .is_fixed = IdVector<VertexId, std::uint8_t>(n),
                      .fixed_value = IdVector<VertexId, double>(n)};
  for (const CellId c : ids(volumes.cell_vertex)) {
    system.load[volumes.cell_vertex[c]] += terms.source[c];
    system.absorption[volumes.cell_vertex[c]] += terms.absorption[c];
  }
  for (const PatchId p : ids(terms.patches)) {
    const PatchTerm& term = terms.patches[p];
    const VertexId v = boundary.patch_vertex[p];
    system.load[v] += term.inflow;
    system.absorption[v] += term.transfer;
    if (!term.is_fixed || system.is_fixed[v] != 0) continue;
    system.is_fixed[v] = 1;  // Patches are sorted by marker: the smallest one wins.
    system.fixed_value[v] = term.value;
  }
  for (std::size_t i = 0; i < n; ++i) system.matrix.values[diagonal[i]] += system.absorption[VertexId(i)];
  return system;
}

template <int D>
LinearSystem assemble(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                      const DiffusionProblem<D>& problem) {
  return assemble_terms(volumes, boundary, evaluate(volumes, boundary, problem));
}

template LinearSystem assemble_terms(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellTerms&);
template LinearSystem assemble_terms(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellTerms&);
template LinearSystem assemble(const ControlVolumes<2>&, const BoundaryAreas<2>&, const DiffusionProblem<2>&);
template LinearSystem assemble(const ControlVolumes<3>&, const BoundaryAreas<3>&, const DiffusionProblem<3>&);

}  // namespace voropack
