#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "adaptivity/cell_neighbors.h"
#include "adaptivity/consistency.h"
#include "adaptivity/symmetric.h"
#include "norms/dual_face_parts.h"
#include "solve/assemble.h"
#include "solve/cell_index.h"
#include "solve/coefficients.h"
#include "solve/floating_parts.h"
#include "voropack/adaptivity.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Of the misfit of the recovered polynomials, the part that is error: measured at corners and at unresolved layers.
constexpr double kRoughShare = 0.8;

/// Moments of a part of a dual face about the midpoint of its edge, per measure: what is integrated over faces.
template <int D>
struct Moments {
  Vec<D> first;
  SymmetricEntries<D> second{};

  Moments& operator+=(const Moments& m) {
    first += m.first;
    for (std::size_t k = 0; k < second.size(); ++k) second[k] += m.second[k];
    return *this;
  }
  friend Moments operator*(double factor, Moments m) {
    m.first = factor * m.first;
    for (double& x : m.second) x *= factor;
    return m;
  }
  friend Moments operator/(const Moments& m, double divisor) { return (1 / divisor) * m; }
};

/// Of a simplex of dimension D - 1, whose first corner is that midpoint. Far from the origin, moments about that would
/// leave rounding alone.
template <int D>
Moments<D> moments_of(std::array<Vec<D>, D> corners) {
  const Vec<D> middle = corners[0];
  Vec<D> sum;
  for (Vec<D>& c : corners) sum += c -= middle;
  Moments<D> m;
  m.first = sum / static_cast<double>(D);
  for_symmetric_entries<D>([&](std::size_t entry, int k, int l) {
    double products = sum[k] * sum[l];
    for (const Vec<D>& c : corners) products += c[k] * c[l];
    m.second[entry] = products / (D * (D + 1));
  });
  return m;
}

/// U1 - U2 by Taylor's theorem about the midpoint m of the edge, of length h along n: with the Hessian H there, its
/// change H' from end to end, the centroid g of the dual face and its second moments M about m,
///
///     U2 = -(n . grad u + n . H (g - m) + H' : M / (2 h)),    U1 = -(n . grad u + h n . H' n / 24).
template <int D>
EdgeValues find_defects(const Mesh<D>& mesh, const ControlVolumes<D>& volumes,
                        const RecoveredDerivatives<D>& derivatives) {
  const auto moments = mean_over_dual_faces<Moments<D>>(
      mesh, volumes, [](const std::array<Vec<D>, D>& part, const Vec<D>&) { return moments_of<D>(part); });
  const auto sides = cells_of_faces(volumes);
  const auto& hessian = derivatives.hessian;
  EdgeValues defect(volumes.face_area.size());
  parallel_for(defect.size(), [&](std::size_t number) {
    const DualFaceId f(number);
    const auto [i, j] = volumes.face_vertices[f];
    const double h = volumes.face_edge_length[f];
    const Vec<D> normal = (volumes.sites[j] - volumes.sites[i]) / h;
    SymmetricEntries<D> mean, change;
    for_symmetric_entries<D>([&](std::size_t entry, int, int) {
      const double first = hessian[sides[f][0]][entry], second = hessian[sides[f][1]][entry];
      mean[entry] = 0.5 * (first + second);
      change[entry] = second - first;
    });
    defect[f] = dot(normal, times<D>(mean, moments[f].first)) + contract<D>(change, moments[f].second) / (2 * h) -
                h * dot(normal, times<D>(change, normal)) / 24;
  });
  return defect;
}

/// The error's equation has the matrix of the problem, and as its load the defects and what cells miss besides.
template <int D>
CellTerms error_terms(const SolvedProblem<D>& solved, const BoundaryAreas<D>& boundary, const EdgeValues& defect) {
  const ControlVolumes<D>& volumes = solved.volumes;
  const CellIndex index(volumes);
  CellTerms terms = evaluate(volumes, boundary, index, solved.problem, &solved.values);
  terms.source = find_consistency_errors(solved);
  for (const DualFaceId f : ids(defect)) {
    const double load = -terms.coupling[f] * volumes.face_edge_length[f] * defect[f];
    const auto [i, j] = volumes.face_vertices[f];
    terms.source[index(i, volumes.face_region[f])] += load;
    terms.source[index(j, volumes.face_region[f])] -= load;
  }
  for (PatchTerm& patch : terms.patches) patch.value = patch.inflow = 0;
  return terms;
}

}  // namespace

template <int D>
ErrorEstimate estimate_error(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const BoundaryAreas<D>& boundary,
                             const DiffusionProblem<D>& problem, const VertexValues& values,
                             const RecoveredDerivatives<D>& derivatives, const LinearOptions& options,
                             Observer& observer) {
  observer.begin_stage("estimate");
  if (values.size() != volumes.sites.size() || derivatives.hessian.size() != volumes.cell_vertex.size() ||
      derivatives.misfit.size() != volumes.face_area.size())
    throw InputError(Fault{
        .id = "adapt.wrong_length",
        .message = fmt::format("{} values and derivatives in {} cells for {} vertices with {} cells", values.size(),
                               derivatives.hessian.size(), volumes.sites.size(), volumes.cell_vertex.size()),
        .fix = "give one value for each vertex, and derivatives recovered on the same mesh"});
  ErrorEstimate result;
  result.defect = find_defects(mesh, volumes, derivatives);
  const SolvedProblem<D> solved{mesh, volumes, problem, values, derivatives};
  add_conductivity_defects(solved, result.defect);
  const CellTerms terms = error_terms(solved, boundary, result.defect);
  LinearSystem system = assemble_terms(volumes, boundary, terms);
  if (!terms.source_slope.empty() || !terms.coupling_slope.empty()) differentiate_terms(volumes, terms, values, system);
  const VertexValues volume = vertex_volumes(volumes);
  const std::optional<double> mean = problem.mean ? std::optional(0.0) : std::nullopt;
  const auto parts = ground_floating_parts(
      volume, [](const std::vector<VertexId>&) { return std::set<int>{}; }, mean, system);
  result.error = solve_linear_system(system, options, observer).values;
  if (!parts.empty()) shift_to_mean(volume, parts, 0, result.error);
  const VertexFlags hull = find_hull_vertices(mesh);
  result.smooth = w_norm(volumes, result.error, hull);
  result.rough = std::sqrt(w_product(volumes, derivatives.misfit, derivatives.misfit, hull));
  result.rough *= kRoughShare;
  result.w = std::hypot(result.smooth, result.rough);
  result.truncation = std::sqrt(w_product(volumes, result.defect, result.defect, hull));
  return result;
}

#define VOROPACK_INSTANTIATE(D)                                                                            \
  template ErrorEstimate estimate_error(const Mesh<D>&, const ControlVolumes<D>&, const BoundaryAreas<D>&, \
                                        const DiffusionProblem<D>&, const VertexValues&,                   \
                                        const RecoveredDerivatives<D>&, const LinearOptions&, Observer&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
