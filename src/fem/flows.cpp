#include "fem/flows.h"

#include <set>

#include "base/parallel.h"
#include "fem/element_matrices.h"
#include "mesh/incidence.h"
#include "mesh/p1_gradients.h"

namespace voropack {

namespace {

/// Adds `terms_of(s)` to the cells of the corners of each simplex: terms in parallel, sums in order.
template <int D>
void add_to_cells(const Mesh<D>& mesh, const CellIndex& index, const auto& terms_of, IdVector<CellId, double>& sums) {
  IdVector<SimplexId, ElementTerms<D>> terms(mesh.simplex_vertices.size());
  parallel_for(terms.size(), [&](std::size_t k) { terms[SimplexId(k)] = terms_of(SimplexId(k)); });
  for (const SimplexId s : ids(terms))
    for (std::size_t i = 0; i <= D; ++i)
      sums[index(mesh.simplex_vertices[s][i], mesh.simplex_region[s])] += terms[s][i];
}

}  // namespace

template <int D>
ControlVolumes<D> hat_cells(const Mesh<D>& mesh) {
  ControlVolumes<D> hats;
  hats.sites = mesh.points;
  const auto vertex_simplices = invert_incidence<VertexId>(mesh.simplex_vertices, mesh.points.size());
  std::set<int> regions;
  for (const VertexId v : ids(mesh.points)) {
    regions.clear();
    for (const SimplexId s : vertex_simplices[v]) regions.insert(mesh.simplex_region[s]);
    for (const int region : regions) {
      hats.cell_vertex.push_back(v);
      hats.cell_region.push_back(region);
    }
  }
  hats.cell_volume.resize(hats.cell_vertex.size());
  add_to_cells(
      mesh, CellIndex(hats), [&](SimplexId s) { return element_load<D>(mesh, 1.0, s); }, hats.cell_volume);
  return hats;
}

template <int D>
FlowSums add_up_fem_flows(const Mesh<D>& mesh, const ControlVolumes<D>& hats, const DiffusionProblem<D>& problem,
                          const Conditions<D>& conditions, const IdVector<VertexId, double>& sink,
                          const IdVector<VertexId, double>& values) {
  PatchFlows<D> patches = conditions.flows(values);
  const CellTerms terms{CellIndex(hats), {}, {}, {}, std::move(patches.terms), {}, {}};
  const std::size_t n = hats.cell_vertex.size();
  Flows flows{.source = IdVector<CellId, double>(n),
              .absorbed = IdVector<CellId, double>(n),
              .stored = IdVector<CellId, double>(n),
              .deficit = IdVector<CellId, double>(n),
              .inflow = std::move(patches.inflow)};
  add_to_cells(
      mesh, terms.index, [&](SimplexId s) { return element_load(mesh, problem.source, s); }, flows.source);
  add_to_cells(
      mesh, terms.index, [&](SimplexId s) { return element_absorption(mesh, problem.reaction, s, values); },
      flows.absorbed);
  add_to_cells(
      mesh, terms.index, [&](SimplexId s) { return element_diffusion(mesh, problem.conductivity, s, values); },
      flows.deficit);
  for (const CellId c : ids(flows.deficit)) {
    flows.source[c] -= sink[hats.cell_vertex[c]] * hats.cell_volume[c];
    flows.deficit[c] += flows.absorbed[c] - flows.source[c];
  }
  for (const PatchId p : ids(flows.inflow))
    flows.deficit[terms.index(patches.boundary.patch_vertex[p], patches.boundary.patch_region[p])] -= flows.inflow[p];
  return add_up_flows(hats, patches.boundary, terms, flows);
}

template ControlVolumes<2> hat_cells(const Mesh<2>&);
template ControlVolumes<3> hat_cells(const Mesh<3>&);
template FlowSums add_up_fem_flows(const Mesh<2>&, const ControlVolumes<2>&, const DiffusionProblem<2>&,
                                   const Conditions<2>&, const IdVector<VertexId, double>&,
                                   const IdVector<VertexId, double>&);
template FlowSums add_up_fem_flows(const Mesh<3>&, const ControlVolumes<3>&, const DiffusionProblem<3>&,
                                   const Conditions<3>&, const IdVector<VertexId, double>&,
                                   const IdVector<VertexId, double>&);

}  // namespace voropack
