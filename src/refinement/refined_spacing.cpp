#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "coarsening/initial_spacing.h"
#include "mesh/edge_graph.h"
#include "voropack/error.h"
#include "voropack/refinement.h"

namespace voropack {

namespace {

/// f is Lipschitz already.
template <int D>
Spacing<D> interpolate(const Mesh<D>& mesh, const Domain<D>& domain, IdVector<VertexId, double> f,
                       const SizeWishes<D>& wishes, const SpacingOptions& options, Observer& observer) {
  const double largest = *std::max_element(f.begin(), f.end());
  SizeWishes<D> all = wishes;
  all.spacing = std::min(largest, wishes.spacing.value_or(std::numeric_limits<double>::infinity()));
  // Where f is the same everywhere, that constant says it all.
  if (std::ranges::any_of(f, [&](double value) { return value < largest; })) {
    typename SizeWishes<D>::Field field;
    field.mesh.simplex_vertices = mesh.simplex_vertices;
    field.mesh.simplex_neighbors = mesh.simplex_neighbors;
    field.mesh.points = mesh.points;
    field.size = std::move(f.raw());
    field.fills_domain = true;
    all.spacing_field = std::move(field);
  }
  return build_spacing(domain, all, options, observer);
}

}  // namespace

template <int D>
IdVector<VertexId, double> spacing_at_vertices(const Mesh<D>& mesh, double lipschitz) {
  const EdgeGraph edges = build_edge_graph(mesh);
  IdVector<VertexId, double> f = mesh.vertex_spacing.empty()
                                     ? initial_spacing(mesh, edges, InitialSpacing::kNearest).nearest
                                     : mesh.vertex_spacing;
  make_lipschitz(edges, lipschitz, f);
  return f;
}

template <int D>
Spacing<D> spacing_through(const Mesh<D>& mesh, const Domain<D>& domain, IdVector<VertexId, double> f,
                           const SizeWishes<D>& wishes, const SpacingOptions& options, Observer& observer) {
  make_lipschitz(build_edge_graph(mesh), options.gradation, f);
  return interpolate(mesh, domain, std::move(f), wishes, options, observer);
}

template <int D>
Spacing<D> refined_spacing(const Mesh<D>& mesh, const Domain<D>& domain, double factor, const SizeWishes<D>& wishes,
                           const SpacingOptions& options, Observer& observer) {
  if (!(factor > 0 && factor <= 1))
    throw OptionError(Fault{.id = "refine.bad_factor",
                            .message = fmt::format("the factor of the spacing is {}", factor),
                            .fix = "give a number greater than 0 and at most 1"});
  IdVector<VertexId, double> f = spacing_at_vertices(mesh, options.gradation);
  for (double& value : f) value *= factor;
  return interpolate(mesh, domain, std::move(f), wishes, options, observer);
}

template IdVector<VertexId, double> spacing_at_vertices(const Mesh<2>&, double);
template IdVector<VertexId, double> spacing_at_vertices(const Mesh<3>&, double);
template Spacing<2> spacing_through(const Mesh<2>&, const Domain<2>&, IdVector<VertexId, double>, const SizeWishes<2>&,
                                    const SpacingOptions&, Observer&);
template Spacing<3> spacing_through(const Mesh<3>&, const Domain<3>&, IdVector<VertexId, double>, const SizeWishes<3>&,
                                    const SpacingOptions&, Observer&);
template Spacing<2> refined_spacing(const Mesh<2>&, const Domain<2>&, double, const SizeWishes<2>&,
                                    const SpacingOptions&, Observer&);
template Spacing<3> refined_spacing(const Mesh<3>&, const Domain<3>&, double, const SizeWishes<3>&,
                                    const SpacingOptions&, Observer&);

}  // namespace voropack
