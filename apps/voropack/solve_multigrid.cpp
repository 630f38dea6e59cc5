#include "solve_multigrid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "voropack/error.h"
#include "voropack/io.h"
#include "voropack/mesh_domain.h"
#include "voropack/refinement.h"

namespace voropack::app {

namespace {

/// Unknowns from which on coarsening pays for itself, in one solution and in the many of a case in time:
/// docs/theory/multigrid.md has the measurements.
template <int D>
constexpr std::uint64_t kLargeSystem = D == 2 ? 10'000 : 300'000;
template <int D>
constexpr std::uint64_t kLargeInTime = D == 2 ? 10'000 : 100'000;

/// From level to level: smaller factors save iterations, and cost more than that in levels.
constexpr double kGrowth = 2.5;

/// Vertices of the coarsest level, about: few enough to be solved for directly in no time.
constexpr double kCoarsest = 2000;

/// Passes on whether to stop, and nothing else: the stages of coarsening are not those of a solution.
class StopObserver final : public Observer {
 public:
  explicit StopObserver(const Observer& outer) : outer_(outer) {}
  [[nodiscard]] bool cancelled() const override { return outer_.cancelled(); }

 private:
  const Observer& outer_;
};

template <int D>
CoarseningOptions coarsening_options(std::size_t n_vertices) {
  CoarseningOptions options;
  options.growth = kGrowth;
  const double factor = D * std::log(options.growth);  // Between levels, as a logarithm.
  options.levels =
      std::max(1, static_cast<int>(std::lround(std::log(static_cast<double>(n_vertices) / kCoarsest) / factor)));
  return options;
}

}  // namespace

template <int D>
bool MultigridMaker<D>::is_wanted(const LinearSystem& system) const {
  if (given_.preconditioner != CasePreconditioner::kAutomatic)
    return given_.preconditioner == CasePreconditioner::kMultigrid;
  const auto n_unknowns = std::count(system.is_fixed.begin(), system.is_fixed.end(), 0);
  return static_cast<std::uint64_t>(n_unknowns) >= (given_.time ? kLargeInTime<D> : kLargeSystem<D>);
}

template <int D>
MultigridMaker<D>::MultigridMaker(const Mesh<D>& mesh, const std::optional<Domain<D>>& domain, const Case& given,
                                  Observer& observer)
    : mesh_(mesh), domain_(domain), given_(given), observer_(observer) {
  if (!given_.levels.empty()) read_levels();
}

template <int D>
void MultigridMaker<D>::keep(std::vector<CoarseLevel<D>> levels) {
  for (CoarseLevel<D>& level : levels)
    levels_.push_back({std::move(level.prolongation), std::move(level.finest_vertex)});
}

template <int D>
void MultigridMaker<D>::read_levels() {
  has_levels_ = true;
  observer_.begin_stage("read");
  StopObserver stop(observer_);
  std::vector<Mesh<D>> meshes;
  for (const std::filesystem::path& file : given_.levels) {
    AnyMesh any = read_mesh(file, stop);
    auto* const mesh = std::get_if<Mesh<D>>(&any);
    if (mesh == nullptr)
      throw InputError(Fault{.id = "case.contradiction",
                             .message = fmt::format("a level for multigrid has to be a {}D mesh, as the case's is", D),
                             .fix = "name meshes with some of the vertices of the case's mesh.",
                             .file = file.string()});
    meshes.push_back(std::move(*mesh));
  }
  keep(nested_levels(mesh_, std::move(meshes)));
}

template <int D>
void MultigridMaker<D>::make_levels() {
  has_levels_ = true;
  observer_.begin_stage("coarsen");
  StopObserver stop(observer_);
  MeshDomain<D> place = domain_ ? place_in_domain(mesh_, *domain_, 0, stop) : domain_of(mesh_, stop);
  CoarseningHierarchy<D> hierarchy =
      coarsen(mesh_, std::move(place), {}, coarsening_options<D>(mesh_.points.size()), stop);
  keep(std::move(hierarchy.levels));
  if (levels_.empty())
    throw InputError(Fault{.id = "case.no_coarser_mesh",
                           .message = "the boundary of the mesh allows no coarser one",
                           .fix = "choose another preconditioner."});
}

template <int D>
std::shared_ptr<const Preconditioner> MultigridMaker<D>::operator()(const LinearSystem& system) {
  if (!is_wanted(system)) return nullptr;
  if (!system.is_symmetric) {
    figures_.refused = "the matrix is not symmetric";
    return nullptr;
  }
  const auto refuse = [&](const Error& error) {
    figures_.refused = error.faults().front().message;
    observer_.begin_stage("solve");
    return nullptr;
  };
  try {
    if (!has_levels_) make_levels();
    if (levels_.empty()) return nullptr;
    observer_.begin_stage("multigrid");
    std::vector<MultigridLevel> views;
    for (const Level& level : levels_)
      views.push_back({.prolongation = &level.prolongation, .finest_vertex = level.finest_vertex.raw()});
    auto multigrid = make_multigrid(system, views);
    figures_.made = multigrid->report();
    observer_.begin_stage("solve");
    return multigrid;
  } catch (const InputError& error) {
    return refuse(error);
  } catch (const NumericalError& error) {
    return refuse(error);
  } catch (const LimitError& error) {
    return refuse(error);
  }
}

template class MultigridMaker<2>;
template class MultigridMaker<3>;

}  // namespace voropack::app
