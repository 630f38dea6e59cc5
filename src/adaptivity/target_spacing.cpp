#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "adaptivity/cell_neighbors.h"
#include "mesh/edge_graph.h"
#include "solve/cell_index.h"
#include "voropack/adaptivity.h"
#include "voropack/error.h"
#include "voropack/refinement.h"

namespace voropack {

namespace {

/// Recovered derivatives scatter from vertex to vertex: so many averages over neighbors even that out.
constexpr int kAverages = 1;
/// Where the solution is straight, f would be infinite: it grows to this multiple of its least value at most.
constexpr double kLargestRatio = 1024;
/// The least value is kept up to where this multiple of it would do: there irregular cells beside the lattice cost less
/// than more of the lattice does. Measured, as what follows.
template <int D>
constexpr double kFirstStep = D == 2 ? 2.1 : 2;
/// In the plane also up to larger multiples: each so many times the one before, and how many are tried.
constexpr double kStepFactor = 1.1;
constexpr int kFirstSteps = 15;
/// Squares of errors, by volume: of irregular cells this times f^2 |H|^2, of a lattice f^4 T^2.
constexpr double kIrregularity = 0.7;
/// In the plane f begins with this multiple of its least value beside the lattice, which fits up to 1.7 of it: edges
/// there are as long as those of the lattice.
constexpr double kJump = 1.6;
/// Beyond, f grows in steps of 2 in space; in the plane, where lattices fit a wider range of f, as it likes.
template <int D>
constexpr bool kGrowsInSteps = D == 3;
/// Halvings of the interval that holds the factor k.
constexpr int kBisections = 60;
/// Paths along edges are longer than straight lines, by up to 1.998 in the plane: values that differ by half of what is
/// Lipschitz along edges do so across them as well. Few paths are much longer: this is measured.
constexpr double kEdgeSlope = 0.85;
/// Packings of the same spacing differ by some percent.
constexpr double kCountTolerance = 0.05;
constexpr int kCountTrials = 5;

/// [n_cells] the mean over each cell and its neighbors, so many times.
IdVector<CellId, double> smoothed(const Csr<CellId, CellId>& neighbors, IdVector<CellId, double> x) {
  IdVector<CellId, double> average(x.size());
  for (int k = 0; k < kAverages; ++k) {
    parallel_for(x.size(), [&](std::size_t i) {
      const CellId c(i);
      double sum = x[c];
      for (const CellId d : neighbors[c]) sum += x[d];
      average[c] = sum / static_cast<double>(neighbors[c].size() + 1);
    });
    std::swap(x, average);
  }
  return x;
}

/// How the solution bends at each vertex.
struct Bends {
  VertexValues volume;
  VertexValues curvature2, third2;  ///< Squares of the norms of the second and third derivatives.
  VertexValues ratio;               ///< f over its least value, if it could vary as it likes.
};

/// f over its least value, which is kept up to where `first_step` of it would do.
template <int D>
double stepped(double ratio, double first_step) {
  if (ratio < first_step) return 1;
  return kGrowsInSteps<D> ? std::exp2(std::floor(std::log2(ratio / first_step)) + 1) : kJump * ratio / first_step;
}

/// The first step with the least predicted error, if the integral of f^-D shall be `wanted`: a lattice that ends early
/// has smaller cells, but irregular ones where the solution bends.
template <int D>
double choose_first_step(const Bends& bends, double wanted) {
  double best = kFirstStep<D>, least = std::numeric_limits<double>::infinity();
  double first_step = best;
  for (int step = 0; step < kFirstSteps; ++step, first_step *= kStepFactor) {
    double count = 0, lattice = 0, irregular = 0;
    for (const VertexId v : ids(bends.volume)) {
      const double volume = bends.volume[v], ratio = bends.ratio[v];
      count += volume * std::pow(stepped<D>(ratio, first_step), -D);
      (ratio < first_step ? lattice : irregular) +=
          volume * (ratio < first_step ? bends.third2[v] : bends.curvature2[v]);
    }
    const double f2 = std::pow(count / wanted, 2.0 / D);
    const double error2 = f2 * f2 * lattice + kIrregularity * f2 * irregular;
    if (error2 < least) {
      least = error2;
      best = first_step;
    }
  }
  return best;
}

template <int D>
Bends find_bends(const ControlVolumes<D>& volumes, const RecoveredDerivatives<D>& derivatives) {
  const std::size_t n = volumes.cell_vertex.size();
  const Csr<CellId, CellId> neighbors = cell_neighbors(cells_of_faces(volumes), n);
  const auto curvature = smoothed(neighbors, derivatives.curvature), third = smoothed(neighbors, derivatives.third);
  const std::size_t n_vertices = volumes.sites.size();
  Bends bends{.volume = vertex_volumes(volumes),
              .curvature2 = VertexValues(n_vertices, 0.0),
              .third2 = VertexValues(n_vertices, 0.0),
              .ratio = VertexValues(n_vertices, 1.0)};
  VertexValues product(n_vertices, 0.0);
  for (const CellId c : ids(curvature)) {
    const VertexId v = volumes.cell_vertex[c];
    bends.curvature2[v] = std::max(bends.curvature2[v], curvature[c] * curvature[c]);
    bends.third2[v] = std::max(bends.third2[v], third[c] * third[c]);
    product[v] = std::max(product[v], curvature[c] * third[c]);
  }
  const double largest = *std::ranges::max_element(product);
  if (!(largest > 0)) return bends;
  // Beside a layer derivatives decay exponentially: means of their logarithms leave a lattice's end where it is.
  IdVector<CellId, double> log_ratio(n);
  parallel_for(n, [&](std::size_t i) {
    const CellId c(i);
    const double part = product[volumes.cell_vertex[c]] / largest;
    log_ratio[c] = std::log(std::min(std::pow(part, -1.0 / (D + 3)), kLargestRatio));
  });
  log_ratio = smoothed(neighbors, std::move(log_ratio));
  bends.ratio = VertexValues(n_vertices, kLargestRatio);
  for (const CellId c : ids(log_ratio)) {
    double& ratio = bends.ratio[volumes.cell_vertex[c]];
    ratio = std::min(ratio, std::exp(log_ratio[c]));
  }
  return bends;
}

template <int D>
void check_input(const ControlVolumes<D>& volumes, const RecoveredDerivatives<D>& derivatives,
                 const IdVector<VertexId, double>& spacing, const TargetOptions& options) {
  if (!(options.n_vertices > 0 && options.least_factor > 0 && options.least_factor <= options.largest_factor))
    throw OptionError(Fault{.id = "adapt.bad_option",
                            .message = fmt::format("{} vertices are wanted, with factors of the spacing from {} to {}",
                                                   options.n_vertices, options.least_factor, options.largest_factor),
                            .fix = "give positive numbers, the factors in ascending order"});
  if (spacing.empty() || spacing.size() != volumes.sites.size() ||
      derivatives.curvature.size() != volumes.cell_vertex.size())
    throw InputError(Fault{.id = "adapt.wrong_length",
                           .message = fmt::format("{} values of the spacing and {} of the derivatives for {} vertices "
                                                  "with {} cells",
                                                  spacing.size(), derivatives.curvature.size(), volumes.sites.size(),
                                                  volumes.cell_vertex.size()),
                           .fix = "give one spacing for each vertex, and derivatives recovered on the same mesh"});
}

/// `target_spacing` of a solution that bends like that.
template <int D>
VertexValues spacing_for(const Bends& bends, const IdVector<VertexId, double>& spacing, const TargetOptions& options) {
  double first_step = kFirstStep<D>;
  const auto at = [&](VertexId v, double k) {
    return std::clamp(k * stepped<D>(bends.ratio[v], first_step), options.least_factor * spacing[v],
                      options.largest_factor * spacing[v]);
  };
  const auto density = [&](auto&& f) {
    double sum = 0;
    for (const VertexId v : ids(spacing)) sum += bends.volume[v] * std::pow(f(v), -D);
    return sum;
  };
  const double wanted =
      density([&](VertexId v) { return spacing[v]; }) * options.n_vertices / static_cast<double>(spacing.size());
  if (D == 2 && options.is_resolved) first_step = choose_first_step<D>(bends, wanted);
  // The density falls with k.
  double lo = std::log(1e-12 * *std::ranges::min_element(spacing));
  double hi = std::log(1e12 * *std::ranges::max_element(spacing));
  for (int step = 0; step < kBisections; ++step) {
    const double middle = 0.5 * (lo + hi);
    (density([&](VertexId v) { return at(v, std::exp(middle)); }) > wanted ? lo : hi) = middle;
  }
  VertexValues result(spacing.size());
  for (const VertexId v : ids(result)) result[v] = at(v, std::exp(hi));
  return result;
}

}  // namespace

template <int D>
VertexValues target_spacing(const ControlVolumes<D>& volumes, const RecoveredDerivatives<D>& derivatives,
                            const IdVector<VertexId, double>& spacing, const TargetOptions& options) {
  check_input(volumes, derivatives, spacing, options);
  return spacing_for<D>(find_bends(volumes, derivatives), spacing, options);
}

template <int D>
Spacing<D> adapted_spacing(const Mesh<D>& mesh, const Domain<D>& domain, const ControlVolumes<D>& volumes,
                           const RecoveredDerivatives<D>& derivatives, const TargetOptions& options,
                           const SizeWishes<D>& wishes, const SpacingOptions& spacing_options,
                           const PackingOptions& packing, Observer& observer) {
  const IdVector<VertexId, double> before = spacing_at_vertices(mesh, spacing_options.gradation);
  const EdgeGraph edges = build_edge_graph(mesh);
  check_input(volumes, derivatives, before, options);
  const Bends bends = find_bends(volumes, derivatives);
  TargetOptions target = options;
  double last = 0;
  for (int trial = 1;; ++trial) {
    VertexValues f = spacing_for<D>(bends, before, target);
    make_lipschitz(edges, kEdgeSlope * spacing_options.gradation, f);
    Spacing<D> spacing = spacing_through(mesh, domain, std::move(f), wishes, spacing_options, observer);
    const double excess = estimate_sphere_count(domain, spacing, packing) / options.n_vertices;
    // Where the count no longer follows, the domain's features or the user's sizes decide it.
    const bool is_stuck = std::abs(excess - last) <= 0.1 * kCountTolerance * excess;
    if (trial == kCountTrials || std::abs(excess - 1) <= kCountTolerance || is_stuck) return spacing;
    last = excess;
    target.n_vertices /= excess;
  }
}

#define VOROPACK_INSTANTIATE(D)                                                                                   \
  template VertexValues target_spacing(const ControlVolumes<D>&, const RecoveredDerivatives<D>&,                  \
                                       const IdVector<VertexId, double>&, const TargetOptions&);                  \
  template Spacing<D> adapted_spacing(const Mesh<D>&, const Domain<D>&, const ControlVolumes<D>&,                 \
                                      const RecoveredDerivatives<D>&, const TargetOptions&, const SizeWishes<D>&, \
                                      const SpacingOptions&, const PackingOptions&, Observer&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
