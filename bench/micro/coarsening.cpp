// Coarsening of a packed square or cube, beside one Delaunay triangulation of the same vertices by the same kernel and
// as many threads. Both begin with what is in memory: a mesh, and its vertices in the mesh's order.
//
// Usage: coarsening DIMENSION [n_vertices = 100000] [levels = 5] [growth = 2] [threads = 0] [runs = 3] [random = 0]
// With random = 1 the fine mesh is a random packing, with 0 one with a lattice inside, as `voropack mesh` makes it.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "base/parallel.h"
#include "clock.h"
#include "process_memory.h"
#include "support/domains.h"
#include "voropack/coarsening.h"
#include "voropack/delaunay.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

struct Settings {
  double n_vertices = 1e5;
  CoarseningOptions coarsening;
  int n_runs = 3;
  bool is_random = false;
};

/// Prints when its stages begin.
class StageClock final : public Observer {
 public:
  void begin_stage(std::string_view name) override {
    finish();
    name_ = name;
    clock_ = bench::Clock();
  }
  void finish() {
    if (!name_.empty()) fmt::print("  {}: {}\n", name_, clock_.text());
    name_.clear();
  }

 private:
  std::string name_;
  bench::Clock clock_;
};

template <int D>
void run(const Settings& settings) {
  MeshingOptions<D> options;
  options.wishes.size = std::pow(1.2 / settings.n_vertices, 1.0 / D);
  if (settings.is_random) options.packing.interior = Interior::kRandom;
  const Mesh<D> mesh = make_mesh(domains::unit_box<D>(), options).mesh;
  fmt::print("{} vertices, {} simplices\n", mesh.points.size(), mesh.simplex_vertices.size());
  for (int run = 0; run < settings.n_runs; ++run) {
    const bench::Clock delaunay_clock;
    const std::size_t n = delaunay_triangulation<D>(mesh.points.raw()).simplices.size();
    const bench::Seconds delaunay = delaunay_clock.passed();
    StageClock stages;
    const bench::Clock clock;
    const CoarseningHierarchy<D> hierarchy = coarsen(mesh, settings.coarsening, stages);
    const bench::Seconds all = clock.passed();
    stages.finish();
    fmt::print("Delaunay triangulation {:.2f} s, {:.2f} s of processor time, {} simplices\n", delaunay.wall,
               delaunay.processor, n);
    fmt::print("coarsening {:.2f} s, {:.2f} s of processor time: {:.2f} and {:.2f} of it; vertices", all.wall,
               all.processor, all.wall / delaunay.wall, all.processor / delaunay.processor);
    for (const CoarseLevel<D>& level : hierarchy.levels) fmt::print(" {}", level.mesh.points.size());
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  voropack::bench::keep_freed_memory();
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  voropack::Settings settings;
  settings.n_vertices = number(2, 1e5);
  settings.coarsening.levels = static_cast<int>(number(3, 5));
  settings.coarsening.growth = number(4, 2);
  settings.n_runs = static_cast<int>(number(6, 3));
  settings.is_random = number(7, 0) != 0;
  voropack::run_with_threads(static_cast<int>(number(5, 0)),
                             [&] { number(1, 3) == 2 ? voropack::run<2>(settings) : voropack::run<3>(settings); });
}
