#include "adaptivity/consistency.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <variant>

#include "adaptivity/cell_neighbors.h"
#include "adaptivity/symmetric.h"
#include "geom/kite_halves.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "norms/dual_face_parts.h"
#include "solve/cell_index.h"

namespace voropack {

namespace {

/// The rule of second degree with a point near each corner of a K-simplex: its coordinates are kMinor and 1 - K kMinor.
template <int K>
constexpr double kMinor = K == 1   ? 0.21132486540518712
                          : K == 2 ? 1.0 / 6
                                   : 0.13819660112501051;

/// The mean of a function over a simplex of any dimension.
template <int D, std::size_t N, class Function>
double mean_over_simplex(const std::array<Vec<D>, N>& corners, Function&& function) {
  constexpr int kDimension = static_cast<int>(N) - 1;
  Vec<D> all;
  for (const Vec<D>& c : corners) all += kMinor<kDimension> * c;
  double sum = 0;
  for (const Vec<D>& c : corners) sum += function(all + (1 - static_cast<double>(N) * kMinor<kDimension>)*c);
  return sum / static_cast<double>(N);
}

/// A coefficient between sites; by vertex only, it is that of the site.
template <int D>
double value_of(const Coefficient<D>& coefficient, const Vec<D>& x, int region, double u, VertexId site) {
  struct Visitor {
    const Vec<D>& x;
    int region;
    double u;
    VertexId site;
    double operator()(double value) const { return value; }
    double operator()(const std::map<int, double>& values) const { return values.at(region); }
    double operator()(const IdVector<VertexId, double>& values) const { return values[site]; }
    double operator()(const RegionFunction<D>& f) const { return f(x, region); }
    double operator()(const StateFunction<D>& f) const { return f.value(x, region, u); }
  };
  return std::visit(Visitor{x, region, u, site}, coefficient);
}

/// True if it may have different values in one cell.
template <int D>
bool varies(const Coefficient<D>& coefficient) {
  return std::holds_alternative<RegionFunction<D>>(coefficient) ||
         std::holds_alternative<StateFunction<D>>(coefficient);
}

template <int D>
double value_at(const BoundaryValue<D>& given, const Vec<D>& x) {
  const double* const constant = std::get_if<double>(&given);
  return constant != nullptr ? *constant : std::get<1>(given)(x);
}

/// The polynomial of second degree at the site of a cell.
template <int D>
double solution_near(const SolvedProblem<D>& solved, CellId c, const Vec<D>& from_site) {
  return solved.values[solved.volumes.cell_vertex[c]] + dot(solved.derivatives.gradient[c], from_site) +
         0.5 * dot(from_site, times<D>(solved.derivatives.hessian[c], from_site));
}

template <int D>
class Integrator {
 public:
  explicit Integrator(const SolvedProblem<D>& solved) : solved_(solved), cell_(solved.volumes) {}

  /// sigma u - s over cells.
  void add_cells(IdVector<CellId, double>& errors) const {
    const DiffusionProblem<D>& problem = solved_.problem;
    const double* const reaction = std::get_if<double>(&problem.reaction);
    const bool has_reaction = reaction == nullptr || *reaction != 0;
    const bool has_source = !problem.source_integrals && varies<D>(problem.source);
    if (!has_reaction && !has_source) return;
    const auto density = [&](const Vec<D>& x, int region, double u, VertexId site) {
      const double absorbed = has_reaction ? value_of<D>(problem.reaction, x, region, u, site) * u : 0;
      return has_source ? absorbed - value_of<D>(problem.source, x, region, u, site) : absorbed;
    };
    IdVector<SimplexId, std::array<double, D + 1>> parts(solved_.mesh.simplex_vertices.size());
    parallel_for(parts.size(), [&](std::size_t s) { parts[SimplexId(s)] = over_simplex(SimplexId(s), density); });
    for (const SimplexId s : ids(parts))
      for (std::size_t a = 0; a <= D; ++a)
        errors[cell_(solved_.mesh.simplex_vertices[s][a], solved_.mesh.simplex_region[s])] += parts[s][a];
  }

  /// What enters through the hull.
  void add_patches(IdVector<CellId, double>& errors) const {
    const auto& conditions = solved_.problem.conditions;
    const auto is_fixed = [](const auto& entry) { return std::holds_alternative<Dirichlet<D>>(entry.second); };
    if (std::all_of(conditions.begin(), conditions.end(), is_fixed)) return;
    const IdVector<BoundaryId, SimplexId> simplices = hull_simplices();
    for (const BoundaryId b : ids(simplices)) {
      const auto condition = conditions.find(solved_.mesh.boundary_marker[b]);
      if (condition == conditions.end() || simplices[b].is_none()) continue;
      const auto* const robin = std::get_if<Robin<D>>(&condition->second);
      if (robin == nullptr) continue;
      Face face = solved_.mesh.boundary_vertices[b];
      sort_vertices(face);  // The same sums in whatever order the mesh lists its vertices.
      const auto inflow = [&](const Vec<D>& x, double u) {
        return value_at<D>(robin->transfer, x) * (value_at<D>(robin->outside, x) - u);
      };
      add_patch(face, solved_.mesh.simplex_region[simplices[b]], inflow, errors);
    }
  }

 private:
  using Face = std::array<VertexId, D>;

  /// [n_boundary] the simplex at each boundary face, if that is on the hull.
  [[nodiscard]] IdVector<BoundaryId, SimplexId> hull_simplices() const {
    const Mesh<D>& mesh = solved_.mesh;
    VertexSetTable<D> listed(mesh.boundary_vertices.size());
    for (const BoundaryId b : ids(mesh.boundary_vertices)) listed.insert(mesh.boundary_vertices[b], b.value());
    IdVector<BoundaryId, SimplexId> simplices(mesh.boundary_vertices.size());
    for (const SimplexId s : ids(mesh.simplex_vertices))
      for (int i = 0; i <= D; ++i) {
        if (!mesh.simplex_neighbors[s][static_cast<std::size_t>(i)].is_none()) continue;
        const std::uint32_t b = listed.find(face_vertices(mesh, s, i));
        if (b != VertexSetTable<D>::kAbsent) simplices[BoundaryId(b)] = s;
      }
    return simplices;
  }

  /// By corner: over the pyramids between the site and the parts of its dual faces.
  template <class Density>
  std::array<double, D + 1> over_simplex(SimplexId s, const Density& density) const {
    const Mesh<D>& mesh = solved_.mesh;
    const auto p = corner_positions(mesh, s);
    const Vec<D> center = circumcenter<D>(p);
    const int region = mesh.simplex_region[s];
    std::array<double, D + 1> result{};
    for (std::size_t a = 0; a <= D; ++a)
      for (std::size_t b = a + 1; b <= D; ++b)
        for (const DualFacePart<D>& part : dual_face_parts(p, center, a, b))
          for (const std::size_t k : {a, b}) {
            const VertexId v = mesh.simplex_vertices[s][k];
            const CellId c = cell_(v, region);
            std::array<Vec<D>, D + 1> pyramid;
            std::ranges::copy(part.corners, pyramid.begin());
            pyramid[D] = p[k];
            const double volume = part.measure * distance(p[a], p[b]) / (2 * D);
            const double at_site = density(p[k], region, solved_.values[v], v);
            result[k] += volume * mean_over_simplex<D>(pyramid, [&](const Vec<D>& x) {
                           return density(x, region, solution_near(solved_, c, x - p[k]), v) - at_site;
                         });
          }
    return result;
  }

  /// What `inflow` is at the site, less its mean over the site's part of a boundary face, times the area.
  template <class Inflow>
  void add_patch(const Face& face, int region, const Inflow& inflow, IdVector<CellId, double>& errors) const {
    std::array<Vec<D>, D> x;
    for (std::size_t i = 0; i < D; ++i) x[i] = solved_.mesh.points[face[i]];
    const auto add = [&](std::size_t a, const std::array<Vec<D>, D>& part, double area) {
      const CellId c = cell_(face[a], region);
      const double at_site = inflow(x[a], solved_.values[face[a]]);
      errors[c] -= area * mean_over_simplex<D>(part, [&](const Vec<D>& y) {
                     return inflow(y, solution_near(solved_, c, y - x[a])) - at_site;
                   });
    };
    if constexpr (D == 2) {
      for (std::size_t a = 0; a < 2; ++a) add(a, {x[a], 0.5 * (x[0] + x[1])}, 0.5 * distance(x[0], x[1]));
    } else {
      for (const auto& [a, part, area] : kite_halves(x)) add(a, part, area);
    }
  }

  const SolvedProblem<D>& solved_;
  CellIndex cell_;
};

/// The mean of kappa over a part, and of kappa times the way from the middle of its edge.
template <int D>
struct WeightedMoments {
  double mean = 0;
  Vec<D> first;

  WeightedMoments& operator+=(const WeightedMoments& m) {
    mean += m.mean;
    first += m.first;
    return *this;
  }
  friend WeightedMoments operator*(double factor, const WeightedMoments& m) {
    return {factor * m.mean, factor * m.first};
  }
  friend WeightedMoments operator/(const WeightedMoments& m, double divisor) { return (1 / divisor) * m; }
};

}  // namespace

template <int D>
IdVector<CellId, double> find_consistency_errors(const SolvedProblem<D>& solved) {
  IdVector<CellId, double> errors(solved.volumes.cell_vertex.size(), 0.0);
  const Integrator<D> integrator(solved);
  integrator.add_cells(errors);
  integrator.add_patches(errors);
  return errors;
}

template <int D>
void add_conductivity_defects(const SolvedProblem<D>& solved, EdgeValues& defect) {
  const auto& [mesh, volumes, problem, values, derivatives] = solved;
  if (!varies<D>(problem.conductivity)) return;
  // On the face, a solution that kappa depends on is linear between the sites' values, and bends as it does there.
  const auto kappa = [&](const Vec<D>& x, int region, double u) {
    return value_of<D>(problem.conductivity, x, region, u, VertexId::none());
  };
  const CellIndex cell(volumes);
  const auto u_near = [&](CellId c, const Vec<D>& x) {
    return solution_near(solved, c, x - volumes.sites[volumes.cell_vertex[c]]);
  };
  const auto moments = mean_over_dual_faces<WeightedMoments<D>>(
      mesh, volumes,
      [&](const std::array<Vec<D>, D>& part, const Vec<D>&, SimplexId s, const std::array<VertexId, 2>& edge) {
        const int region = mesh.simplex_region[s];
        const CellId i = cell(edge[0], region), j = cell(edge[1], region);
        const auto at = [&](const Vec<D>& x) { return kappa(x, region, 0.5 * (u_near(i, x) + u_near(j, x))); };
        WeightedMoments<D> m;
        m.mean = mean_over_simplex<D>(part, at);
        for (int k = 0; k < D; ++k)
          m.first[k] = mean_over_simplex<D>(part, [&](const Vec<D>& x) { return at(x) * (x[k] - part[0][k]); });
        return m;
      });
  const auto lever =
      mean_over_dual_faces<WeightedMoments<D>>(mesh, volumes, [](const std::array<Vec<D>, D>& part, const Vec<D>&) {
        WeightedMoments<D> m;
        for (const Vec<D>& c : part) m.first += (c - part[0]) / static_cast<double>(D);
        return m;
      });
  parallel_for(defect.size(), [&](std::size_t number) {
    const DualFaceId f(number);
    const auto [i, j] = volumes.face_vertices[f];
    const int region = volumes.face_region[f];
    const double h = volumes.face_edge_length[f];
    const double a = kappa(volumes.sites[i], region, values[i]), b = kappa(volumes.sites[j], region, values[j]);
    const double used = 2 / (1 / a + 1 / b);
    const Vec<D> normal = (volumes.sites[j] - volumes.sites[i]) / h;
    const Vec<D> bend = 0.5 * (times<D>(derivatives.hessian[cell(i, region)], normal) +
                               times<D>(derivatives.hessian[cell(j, region)], normal));
    const double slope = (values[j] - values[i]) / h;
    defect[f] += ((moments[f].mean - used) * slope + dot(bend, moments[f].first - used * lever[f].first)) / used;
  });
}

#define VOROPACK_INSTANTIATE(D)                                                          \
  template IdVector<CellId, double> find_consistency_errors<D>(const SolvedProblem<D>&); \
  template void add_conductivity_defects<D>(const SolvedProblem<D>&, EdgeValues&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
