// The kernels of each stage on the unit cube, by Google Benchmark: time per vertex.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "base/random.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

DomainInput<3> cube() {
  DomainInput<3> input;
  for (int i = 0; i < 8; ++i) input.points.push_back({i & 1, (i >> 1) & 1, (i >> 2) & 1});
  for (const auto& [a, b, c, d] : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                                   {4, 5, 7, 6},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}}) {
    DomainInput<3>::Facet facet;
    facet.polygons = {{a, b, c, d}};
    input.facets.push_back(facet);
  }
  return input;
}

/// Every stage's product for one mesh, made once.
struct Stages {
  Domain<3> domain = build_domain(cube());
  Spacing<3> spacing;
  Packing<3> packing;
  Mesh<3> mesh;
  ControlVolumes<3> volumes;

  static SizeWishes<3> wishes_of(double size) {
    SizeWishes<3> wishes;
    wishes.size = size;
    return wishes;
  }

  explicit Stages(double size)
      : spacing(build_spacing(domain, wishes_of(size))),
        packing(pack(domain, spacing)),
        mesh(triangulate(domain, Packing<3>(packing))),
        volumes(build_control_volumes(mesh)) {}
};

const Stages& stages() {
  static const Stages made(0.05);
  return made;
}

void count_vertices(benchmark::State& state) {
  state.counters["vertices"] = static_cast<double>(stages().mesh.points.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(stages().mesh.points.size()));
}

void spacing_evaluation(benchmark::State& state) {
  const Spacing<3>& f = stages().spacing;
  Random random(1);
  for (auto _ : state) benchmark::DoNotOptimize(f({random.unit(), random.unit(), random.unit()}));
  state.SetItemsProcessed(state.iterations());
}

void packing(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(pack(stages().domain, stages().spacing));
  count_vertices(state);
}

void delaunay(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(delaunay_triangulation<3>(stages().mesh.points.raw()));
  count_vertices(state);
}

void dual(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(build_control_volumes(stages().mesh));
  count_vertices(state);
}

void quality(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(measure_quality(stages().mesh, stages().volumes));
  count_vertices(state);
}

void certificate(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(certify(stages().mesh, stages().volumes, &stages().domain));
  count_vertices(state);
}

BENCHMARK(spacing_evaluation);
BENCHMARK(packing)->Unit(benchmark::kMillisecond);
BENCHMARK(delaunay)->Unit(benchmark::kMillisecond);
BENCHMARK(dual)->Unit(benchmark::kMillisecond);
BENCHMARK(quality)->Unit(benchmark::kMillisecond);
BENCHMARK(certificate)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace voropack

BENCHMARK_MAIN();
