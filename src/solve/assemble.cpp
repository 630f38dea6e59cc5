#include "solve/assemble.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "solve/check_volumes.h"

namespace voropack {

namespace {

/// The faces of each vertex: those to later vertices are consecutive, since faces are sorted by (i, j); those to
/// earlier ones are listed.
template <int D>
class VertexFaces {
 public:
  explicit VertexFaces(const ControlVolumes<D>& volumes) : volumes_(volumes), first_(volumes.sites.size() + 1) {
    find_first();
    list_earlier();
  }

  /// fn(other vertex, begins an edge, face) for each face of v to an earlier vertex, in ascending order of these. An
  /// edge with parts in several regions has several faces.
  template <class Fn>
  void for_each_earlier(std::size_t v, Fn&& fn) const {
    VertexId before;
    for (const DualFaceId f : earlier_[VertexId(v)]) {
      const VertexId other = volumes_.face_vertices[f][0];
      fn(other, other != before, f);
      before = other;
    }
  }

  /// The same for later vertices.
  template <class Fn>
  void for_each_later(std::size_t v, Fn&& fn) const {
    VertexId before;
    for (std::size_t f = first_[v]; f != first_[v + 1]; ++f) {
      const VertexId other = volumes_.face_vertices[DualFaceId(f)][1];
      fn(other, other != before, DualFaceId(f));
      before = other;
    }
  }

  /// The number of edges at v.
  [[nodiscard]] std::size_t degree(std::size_t v) const {
    if (!edges_repeat_) return earlier_[VertexId(v)].size() + (first_[v + 1] - first_[v]);
    std::size_t n_edges = 0;
    const auto count = [&](VertexId, bool begins_edge, DualFaceId) { n_edges += begins_edge ? 1U : 0U; };
    for_each_earlier(v, count);
    for_each_later(v, count);
    return n_edges;
  }

 private:
  void find_first() {
    const auto& vertices = volumes_.face_vertices.raw();
    const auto owner = [&](std::size_t f) {
      return f == vertices.size() ? first_.size() - 1 : std::size_t{vertices[f][0].value()};
    };
    parallel_for(vertices.size() + 1, [&](std::size_t f) {
      if (f > 0 && f < vertices.size() && vertices[f] == vertices[f - 1])
        std::atomic_ref(edges_repeat_).store(true, std::memory_order_relaxed);
      for (std::size_t v = f == 0 ? 0 : owner(f - 1) + 1; v <= owner(f); ++v) first_[v] = f;
    });
  }

  /// A counting sort, in which threads meet; then each row is sorted.
  void list_earlier() {
    const auto& vertices = volumes_.face_vertices.raw();
    // offsets[v + 2] counts row v, so that offsets[v + 1] is where row v grows while it is filled.
    std::vector<std::uint64_t>& offsets = earlier_.offsets;
    const auto increment = [&](std::size_t k) {
      return std::atomic_ref(offsets[k]).fetch_add(1, std::memory_order_relaxed);
    };
    offsets.assign(volumes_.sites.size() + 2, 0);
    parallel_for(vertices.size(), [&](std::size_t f) { increment(vertices[f][1].value() + std::size_t{2}); });
    for (std::size_t k = 2; k < offsets.size(); ++k) offsets[k] += offsets[k - 1];
    earlier_.values.resize(vertices.size());
    parallel_for(vertices.size(), [&](std::size_t f) {
      earlier_.values[increment(vertices[f][1].value() + std::size_t{1})] = DualFaceId(f);
    });
    offsets.pop_back();
    parallel_for(volumes_.sites.size(), [&](std::size_t v) {
      const auto row = earlier_[VertexId(v)];
      std::sort(row.begin(), row.end());
    });
  }

  const ControlVolumes<D>& volumes_;
  std::vector<std::size_t> first_;  ///< [n_vertices + 1] the first face to a later vertex.
  bool edges_repeat_ = false;       ///< Some edge has several faces.
  Csr<VertexId, DualFaceId> earlier_;
};

/// A row for each vertex. flow(f, is_first) are the derivatives of what leaves a vertex through face f, by its own
/// value and by the other one's, where the vertex is the first or second of the face. On the diagonal is their sum and
/// `diagonal`.
template <int D, class Flow>
SparseMatrix assemble_matrix(const ControlVolumes<D>& volumes, const Flow& flow,
                             const IdVector<VertexId, double>& diagonal) {
  const std::size_t n = volumes.sites.size();
  const VertexFaces<D> faces(volumes);
  SparseMatrix matrix;
  matrix.offsets.assign(n + 1, 0);
  parallel_for(n, [&](std::size_t v) { matrix.offsets[v + 1] = faces.degree(v) + 1; });
  for (std::size_t v = 0; v < n; ++v) matrix.offsets[v + 1] += matrix.offsets[v];
  matrix.columns.resize(matrix.offsets[n]);
  matrix.values.resize(matrix.offsets[n]);
  parallel_for(n, [&](std::size_t v) {
    std::uint64_t next = matrix.offsets[v];
    double sum = diagonal[VertexId(v)];
    const auto add = [&](VertexId other, bool begins_edge, DualFaceId f, bool is_first) {
      const auto [by_own, by_other] = flow(f, is_first);
      if (begins_edge) matrix.columns[next++] = other.value();
      matrix.values[next - 1] += by_other;
      sum += by_own;
    };
    faces.for_each_earlier(v, [&](VertexId other, bool begins, DualFaceId f) { add(other, begins, f, false); });
    const std::uint64_t own = next++;
    faces.for_each_later(v, [&](VertexId other, bool begins, DualFaceId f) { add(other, begins, f, true); });
    matrix.columns[own] = static_cast<std::uint32_t>(v);
    matrix.values[own] = sum;
  });
  return matrix;
}

}  // namespace

template <int D>
LinearSystem assemble_terms(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary, const CellTerms& terms,
                            const StepTerms* step) {
  const std::size_t n = volumes.sites.size();
  LinearSystem system{.matrix = {},
                      .load = IdVector<VertexId, double>(n),
                      .absorption = IdVector<VertexId, double>(n),
                      .is_fixed = IdVector<VertexId, std::uint8_t>(n),
                      .fixed_value = IdVector<VertexId, double>(n)};
  for (const CellId c : ids(volumes.cell_vertex)) {
    system.load[volumes.cell_vertex[c]] += terms.source[c];
    system.absorption[volumes.cell_vertex[c]] += terms.absorption[c];
  }
  if (step != nullptr)
    for (const VertexId v : ids(volumes.sites)) {
      system.load[v] += step->load[v];
      system.absorption[v] += step->storage[v];
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
  const auto flow = [&](DualFaceId f, bool) { return std::pair(terms.coupling[f], -terms.coupling[f]); };
  system.matrix = assemble_matrix(volumes, flow, system.absorption);
  return system;
}

template <int D>
void differentiate_terms(const ControlVolumes<D>& volumes, const CellTerms& terms,
                         const IdVector<VertexId, double>& values, LinearSystem& system) {
  if (!terms.source_slope.empty())
    for (const CellId c : ids(volumes.cell_vertex)) {
      system.absorption[volumes.cell_vertex[c]] -= terms.source_slope[c];
      // An indefinite matrix needs the methods for unsymmetric ones.
      if (terms.source_slope[c] > 0) system.is_symmetric = false;
    }
  if (!terms.coupling_slope.empty()) system.is_symmetric = false;
  // Through face (i, j) flows c (u_i - u_j), where c depends on both.
  const auto flow = [&](DualFaceId f, bool is_first) {
    const double c = terms.coupling[f];
    if (terms.coupling_slope.empty()) return std::pair(c, -c);
    const auto [i, j] = volumes.face_vertices[f];
    const double difference = values[i] - values[j];
    const double by_i = c + terms.coupling_slope[f][0] * difference,
                 by_j = -c + terms.coupling_slope[f][1] * difference;
    return is_first ? std::pair(by_i, by_j) : std::pair(-by_j, -by_i);
  };
  system.matrix = assemble_matrix(volumes, flow, system.absorption);
}

template <int D>
LinearSystem assemble(const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                      const DiffusionProblem<D>& problem) {
  check_volumes(volumes, boundary);
  return assemble_terms(volumes, boundary, evaluate(volumes, boundary, CellIndex(volumes), problem));
}

template LinearSystem assemble_terms(const ControlVolumes<2>&, const BoundaryAreas<2>&, const CellTerms&,
                                     const StepTerms*);
template LinearSystem assemble_terms(const ControlVolumes<3>&, const BoundaryAreas<3>&, const CellTerms&,
                                     const StepTerms*);
template void differentiate_terms(const ControlVolumes<2>&, const CellTerms&, const IdVector<VertexId, double>&,
                                  LinearSystem&);
template void differentiate_terms(const ControlVolumes<3>&, const CellTerms&, const IdVector<VertexId, double>&,
                                  LinearSystem&);
template LinearSystem assemble(const ControlVolumes<2>&, const BoundaryAreas<2>&, const DiffusionProblem<2>&);
template LinearSystem assemble(const ControlVolumes<3>&, const BoundaryAreas<3>&, const DiffusionProblem<3>&);

}  // namespace voropack
