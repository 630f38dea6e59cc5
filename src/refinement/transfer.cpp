// From one mesh to another: which vertices they share, and values in between.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "base/parallel.h"
#include "base/random.h"
#include "coarsening/prolongation.h"
#include "voropack/dual.h"
#include "voropack/error.h"
#include "voropack/norms.h"
#include "voropack/refinement.h"

namespace voropack {

namespace {

template <int D>
struct PositionHash {
  std::size_t operator()(const Vec<D>& x) const noexcept {
    std::uint64_t h = 0;
    for (const double c : x.coord) h = hash_words(h, std::bit_cast<std::uint64_t>(c == 0 ? 0.0 : c));
    return h;
  }
};

/// What a region holds of a field, and how much of it lies about vertices that may change.
struct RegionContent {
  double integral = 0, free_volume = 0;
};

/// By region: the integral over control volumes, and the volume about the vertices of which `is_free` is true.
template <int D, class IsFree>
std::map<int, RegionContent> contents(const ControlVolumes<D>& volumes, const IdVector<VertexId, double>& values,
                                      IsFree&& is_free) {
  std::map<int, RegionContent> result;
  for (const CellId c : ids(volumes.cell_vertex)) {
    const VertexId v = volumes.cell_vertex[c];
    RegionContent& content = result[volumes.cell_region[c]];
    content.integral += volumes.cell_volume[c] * values[v];
    if (is_free(v)) content.free_volume += volumes.cell_volume[c];
  }
  return result;
}

/// [n_vertices] true for vertices inside the domain whose control volume lies in one region. Values on the boundary may
/// be given by conditions.
template <int D>
VertexFlags find_inside(const Mesh<D>& mesh, const ControlVolumes<D>& volumes) {
  const VertexFlags on_hull = find_hull_vertices(mesh);
  VertexFlags count(volumes.sites.size(), 0);
  for (const VertexId v : volumes.cell_vertex) count[v] = count[v] == 0 ? 1 : 2;
  for (const VertexId v : ids(count)) count[v] = count[v] == 1 && on_hull[v] == 0 ? 1 : 0;
  return count;
}

template <int D>
void conserve(const Mesh<D>& from, const IdVector<VertexId, double>& before, const Mesh<D>& to,
              const IdVector<VertexId, VertexId>& old_vertex, IdVector<VertexId, double>& values) {
  const auto wanted = contents(build_control_volumes(from), before, [](VertexId) { return false; });
  const ControlVolumes<D> volumes = build_control_volumes(to);
  const auto inside = find_inside(to, volumes);
  const auto is_new = [&](VertexId v) { return inside[v] != 0 && old_vertex[v].is_none(); };
  const auto among_new = contents(volumes, values, is_new);
  const auto among_all = contents(volumes, values, [&](VertexId v) { return inside[v] != 0; });
  std::map<int, std::pair<double, bool>> shift;  // By region, and whether it is for new vertices only.
  for (const auto& [region, content] : wanted) {
    const auto found = among_new.find(region);
    if (found == among_new.end()) continue;
    const double missing = content.integral - found->second.integral;
    const bool has_new = found->second.free_volume > 0;
    const double volume = has_new ? found->second.free_volume : among_all.at(region).free_volume;
    if (missing != 0 && !(volume > 0))
      throw InputError(
          Fault{.id = "transfer.not_conserved",
                .message = fmt::format("region {} has no vertex inside that could take {}", region, missing),
                .fix = "refine the region, or transfer without conserving"});
    shift[region] = {volume > 0 ? missing / volume : 0, has_new};
  }
  for (const CellId c : ids(volumes.cell_vertex)) {
    const VertexId v = volumes.cell_vertex[c];
    const auto found = shift.find(volumes.cell_region[c]);
    if (found == shift.end() || inside[v] == 0) continue;
    if (!found->second.second || old_vertex[v].is_none()) values[v] += found->second.first;
  }
}

/// [n_vertices] the longest edge at each vertex.
template <int D>
IdVector<VertexId, double> longest_edges(const Mesh<D>& mesh) {
  IdVector<VertexId, double> longest(mesh.points.size(), 0);
  for (const auto& corners : mesh.simplex_vertices)
    for (const VertexId v : corners)
      for (const VertexId w : corners) longest[v] = std::max(longest[v], distance(mesh.points[v], mesh.points[w]));
  return longest;
}

/// The vertices of `to` take values at the places that the weights describe; those are the vertices themselves but for
/// vertices outside of `from`.
template <int D>
void check_cover(const Mesh<D>& from, const SparseMatrix& weights, const Mesh<D>& to) {
  const IdVector<VertexId, double> longest = longest_edges(from);
  IdVector<VertexId, double> away(to.points.size()), allowed(to.points.size());
  parallel_for(away.size(), [&](std::size_t row) {
    const VertexId v(row);
    Vec<D> offset{};
    double reach = 0;
    for (std::uint64_t k = weights.offsets[row]; k < weights.offsets[row + 1]; ++k) {
      const VertexId column(weights.columns[k]);
      offset = offset + weights.values[k] * (from.points[column] - to.points[v]);
      reach = std::max(reach, longest[column]);
    }
    away[v] = norm(offset);
    allowed[v] = reach;
  });
  VertexId worst;
  for (const VertexId v : ids(away))
    if (away[v] > allowed[v] && (worst.is_none() || away[v] * allowed[worst] > away[worst] * allowed[v])) worst = v;
  if (worst.is_none()) return;
  const auto& x = to.points[worst].coord;
  throw InputError(Fault{.id = "transfer.not_covered",
                         .message = fmt::format("the mesh of the values does not reach ({}): it ends {:.3g} away from "
                                                "there, where its edges are at most {:.3g} long",
                                                fmt::join(x, ", "), away[worst], allowed[worst]),
                         .fix = "give values on a mesh of the same domain",
                         .position = {x.begin(), x.end()}});
}

}  // namespace

template <int D>
void require_cover(const Mesh<D>& from, const Mesh<D>& to) {
  check_cover(from, barycentric_prolongation(from, to, same_vertices(from, to).raw()), to);
}

template <int D>
IdVector<VertexId, VertexId> same_vertices(const Mesh<D>& from, const Mesh<D>& to) {
  std::unordered_map<Vec<D>, VertexId, PositionHash<D>> at;
  at.reserve(from.points.size());
  for (const VertexId v : ids(from.points)) at.emplace(from.points[v], v);
  IdVector<VertexId, VertexId> result(to.points.size());
  parallel_for(result.size(), [&](std::size_t i) {
    const auto found = at.find(to.points[VertexId(i)]);
    if (found != at.end()) result[VertexId(i)] = found->second;
  });
  return result;
}

template <int D>
std::vector<CoarseLevel<D>> nested_levels(const Mesh<D>& finest, std::vector<Mesh<D>> coarser) {
  std::vector<CoarseLevel<D>> levels;
  levels.reserve(coarser.size());  // Each is linked to the one before by its address.
  for (std::size_t k = 0; k < coarser.size(); ++k) {
    const CoarseLevel<D>* const finer = k == 0 ? nullptr : &levels.back();
    CoarseLevel<D> level;
    level.mesh = std::move(coarser[k]);
    level.finest_vertex = same_vertices(finer == nullptr ? finest : finer->mesh, level.mesh);
    for (const VertexId v : ids(level.finest_vertex)) {
      VertexId& at = level.finest_vertex[v];
      if (at.is_none())
        throw InputError(
            Fault{.id = "refine.not_nested",
                  .message = fmt::format("vertex {} (counted from 0) of coarse mesh {} is not in the next finer mesh",
                                         v.value(), k + 1),
                  .fix = "give meshes that were refined with all vertices kept, or coarsened, the finest first",
                  .position = {level.mesh.points[v].coord.begin(), level.mesh.points[v].coord.end()}});
      if (finer != nullptr) at = finer->finest_vertex[at];  // It was in the finer mesh.
    }
    link_level(finest, finer, level);
    levels.push_back(std::move(level));
  }
  return levels;
}

template <int D>
IdVector<VertexId, double> transfer(const Mesh<D>& from, const IdVector<VertexId, double>& values, const Mesh<D>& to,
                                    const TransferOptions& options) {
  if (values.size() != from.points.size())
    throw InputError(
        Fault{.id = "transfer.wrong_length",
              .message = fmt::format("there are {} values for {} vertices", values.size(), from.points.size()),
              .fix = "give one value for each vertex"});
  const IdVector<VertexId, VertexId> old_vertex = same_vertices(from, to);
  const SparseMatrix weights = barycentric_prolongation(from, to, old_vertex.raw());
  check_cover(from, weights, to);
  IdVector<VertexId, double> result(to.points.size());
  parallel_for(result.size(), [&](std::size_t row) {
    double sum = 0;
    for (std::uint64_t k = weights.offsets[row]; k < weights.offsets[row + 1]; ++k)
      sum += weights.values[k] * values[VertexId(weights.columns[k])];
    result[VertexId(row)] = sum;
  });
  if (options.conserve) {
    require_cover(to, from);  // Else the integrals are over different domains.
    conserve(from, values, to, old_vertex, result);
  }
  return result;
}

#define VOROPACK_INSTANTIATE(D)                                                                                   \
  template void require_cover(const Mesh<D>&, const Mesh<D>&);                                                    \
  template IdVector<VertexId, VertexId> same_vertices(const Mesh<D>&, const Mesh<D>&);                            \
  template std::vector<CoarseLevel<D>> nested_levels(const Mesh<D>&, std::vector<Mesh<D>>);                       \
  template IdVector<VertexId, double> transfer(const Mesh<D>&, const IdVector<VertexId, double>&, const Mesh<D>&, \
                                               const TransferOptions&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
