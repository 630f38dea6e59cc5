#include "spacing/wishes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/names.h"

namespace voropack {

namespace {

[[noreturn]] void fail(std::string id, std::string message, std::string fix) {
  throw OptionError(Fault{.id = std::move(id), .message = std::move(message), .fix = std::move(fix)});
}

void check_size(double size, const std::string& what) {
  if (std::isfinite(size) && size / 2 > 0) return;  // Spheres of half the size have to be some.
  fail("spacing.bad_size", fmt::format("{} is {}, which is no length", what, size), "give a number greater than 0");
}

std::string listed(const std::set<int>& numbers) {
  constexpr std::size_t kShown = 30;
  std::vector<std::string> names;
  for (int n : numbers) {
    if (names.size() == kShown) {
      names.push_back(fmt::format("... ({} in all)", numbers.size()));
      break;
    }
    names.push_back(std::to_string(n));
  }
  return names.empty() ? "none" : join_names(names);
}

/// The edge length of the regular simplex of the given area or volume.
template <int D>
double regular_edge(double measure) {
  return D == 2 ? std::sqrt(4 * measure / std::sqrt(3.0)) : std::cbrt(6 * std::sqrt(2.0) * measure);
}

template <int D>
void add_region_wishes(const Domain<D>& domain, const SizeWishes<D>& wishes, double edge_per_spacing,
                       SizeAtoms<D>& atoms) {
  for (const auto& [id, size] : wishes.region_size) {
    check_size(size, fmt::format("the size of region {}", id));
    bool found = false;
    for (RegionId r : ids(domain.region_id)) {
      if (domain.region_id[r] != id) continue;
      atoms.add_region(size / edge_per_spacing, r);
      found = true;
    }
    if (!found)
      fail("spacing.unknown_region", fmt::format("a size is given for region {}, which does not exist", id),
           "use one of the regions " + listed({domain.region_id.begin(), domain.region_id.end()}));
  }
  for (RegionId r : ids(domain.region_max_simplex)) {
    if (!domain.region_max_simplex[r]) continue;
    const double measure = *domain.region_max_simplex[r];
    check_size(measure,
               fmt::format("the largest {} wanted in region {}", D == 2 ? "area" : "volume", domain.region_id[r]));
    atoms.add_region(regular_edge<D>(measure) / edge_per_spacing, r);
  }
}

/// Visits every polytope with its marker; marker 0 counts on walls only, since on others it means "none given".
template <int D, class Visit>
void for_each_marked(const Domain<D>& domain, const PolytopeSet<D>& polytopes, Visit&& visit) {
  for (PointId p : ids(domain.point_marker))
    if (domain.point_marker[p] != 0) visit(domain.point_marker[p], polytopes.of_point(p));
  for (SegmentId s : ids(domain.segment_marker))
    if (D == 2 || domain.segment_marker[s] != 0) visit(domain.segment_marker[s], polytopes.of_segment(s));
  for (FacetId f : ids(domain.facet_marker)) visit(domain.facet_marker[f], polytopes.of_facet(f));
}

template <int D>
void add_marker_wishes(const Domain<D>& domain, const SizeWishes<D>& wishes, double edge_per_spacing,
                       const PolytopeSet<D>& polytopes, SizeAtoms<D>& atoms) {
  if (wishes.marker_size.empty()) return;
  std::set<int> known;
  for_each_marked(domain, polytopes, [&](int marker, std::uint32_t) { known.insert(marker); });
  for (const auto& [marker, size] : wishes.marker_size) {
    check_size(size, fmt::format("the size of marker {}", marker));
    if (known.count(marker) == 0)
      fail("spacing.unknown_marker", fmt::format("a size is given for marker {}, which nothing has", marker),
           "use one of the markers " + listed(known));
  }
  for_each_marked(domain, polytopes, [&](int marker, std::uint32_t polytope) {
    const auto wish = wishes.marker_size.find(marker);
    if (wish != wishes.marker_size.end()) atoms.add_polytope(wish->second / edge_per_spacing, polytope);
  });
}

template <int D>
void add_field(const typename SizeWishes<D>::Field& field, double edge_per_spacing, SizeAtoms<D>& atoms) {
  const auto& mesh = field.mesh;
  if (field.size.size() != mesh.points.size())
    fail("spacing.bad_size",
         fmt::format("the size field has {} sizes for {} points", field.size.size(), mesh.points.size()),
         "give one size for each point of the mesh");
  for (VertexId v : ids(mesh.points))
    check_size(field.size[v.value()], fmt::format("the size at point {} (counted from 0)", v.value()));
  std::vector<double> spacing = field.size;
  for (double& value : spacing) value /= edge_per_spacing;
  const auto simplex = [&](const std::array<VertexId, D + 1>& vertices) {
    FieldSimplex<D> result;
    for (std::size_t i = 0; i <= D; ++i) {
      result.corner[i] = mesh.points[vertices[i]];
      result.value[i] = spacing[vertices[i].value()];
    }
    return result;
  };
  const bool is_filling = field.fills_domain && mesh.simplex_neighbors.size() == mesh.simplex_vertices.size() &&
                          std::ranges::all_of(mesh.simplex_vertices, [&](const auto& vertices) {
                            const FieldSimplex<D> here = simplex(vertices);
                            return is_lipschitz<D>(here.corner, here.value, atoms.slope());
                          });
  if (is_filling)
    atoms.add_field({mesh, std::move(spacing), atoms.slope()});
  else
    for (const auto& vertices : mesh.simplex_vertices) atoms.add_simplex(simplex(vertices));
}

template <int D>
void add_places(const SizeWishes<D>& wishes, double edge_per_spacing, SizeAtoms<D>& atoms) {
  for (const auto& [points, radius, size] : wishes.tubes) {
    check_size(size, "the size along a line");
    if (!(std::isfinite(radius) && radius >= 0) || points.empty())
      fail("spacing.bad_size",
           points.size() == 1 ? fmt::format("a ball has the radius {}", radius)
                              : fmt::format("a line of {} points has the radius {}", points.size(), radius),
           "give at least one point, and a radius of at least 0");
    const std::size_t last = points.size() - 1;
    for (std::size_t i = 0; i < std::max<std::size_t>(last, 1); ++i)
      atoms.add_tube(size / edge_per_spacing, {points[i], points[std::min(i + 1, last)], radius});
  }
  for (const auto& [box, size] : wishes.boxes) {
    check_size(size, "the size in a box");
    atoms.add_box(size / edge_per_spacing, box);
  }
}

}  // namespace

void check_spacing_options(const SpacingOptions& options) {
  constexpr double kMaxGradation = 0.4;  // Below sqrt(2) - 1, which lemma 3.4 needs.
  if (!(options.gradation > 0 && options.gradation <= kMaxGradation))
    fail("spacing.bad_gradation", fmt::format("the gradation is {}", options.gradation),
         "give a number greater than 0 and at most 0.4");
  if (!(options.feature_factor > 0 && options.feature_factor <= 1))
    fail("spacing.bad_feature_factor", fmt::format("the feature factor is {}", options.feature_factor),
         "give a number greater than 0 and at most 1");
  check_size(options.edge_per_spacing, "the ratio of edge length to spacing");
}

template <int D>
double add_wishes(const Domain<D>& domain, const SizeWishes<D>& wishes, const SpacingOptions& options,
                  const PolytopeSet<D>& polytopes, const RegionLocator<D>& locator, SizeAtoms<D>& atoms,
                  Observer& observer) {
  const double edge_per_spacing = options.edge_per_spacing;
  double everywhere = std::numeric_limits<double>::infinity();
  if (wishes.size) {
    check_size(*wishes.size, "the size");
    everywhere = *wishes.size / edge_per_spacing;
  }
  if (wishes.spacing) {
    check_size(*wishes.spacing, "the spacing");
    everywhere = std::min(everywhere, *wishes.spacing);
  }
  add_region_wishes(domain, wishes, edge_per_spacing, atoms);
  add_marker_wishes(domain, wishes, edge_per_spacing, polytopes, atoms);
  add_places(wishes, edge_per_spacing, atoms);
  if (wishes.field) add_field<D>(*wishes.field, edge_per_spacing, atoms);
  if (wishes.spacing_field) add_field<D>(*wishes.spacing_field, 1, atoms);
  if (wishes.expression) add_expression(*wishes.expression, edge_per_spacing, domain, locator, atoms, observer);
  return everywhere;
}

template double add_wishes<2>(const Domain<2>&, const SizeWishes<2>&, const SpacingOptions&, const PolytopeSet<2>&,
                              const RegionLocator<2>&, SizeAtoms<2>&, Observer&);
template double add_wishes<3>(const Domain<3>&, const SizeWishes<3>&, const SpacingOptions&, const PolytopeSet<3>&,
                              const RegionLocator<3>&, SizeAtoms<3>&, Observer&);

}  // namespace voropack
