// Our Delaunay kernel beside CGAL's, one thread: processor time and memory per point.
//
// Usage: delaunay_kernels [n = 1000000] [part of a case's name] [repetitions = 1]
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.h"
#include "geom/bowyer_watson.h"
#include "geom/hilbert.h"
#include "process_memory.h"
#include "support/point_sets.h"

namespace voropack {
namespace {

template <int K>
using Points = std::vector<Vec<K>>;

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

using test::random_point;
using test::random_points;

template <int K>
Points<K> sorted_points(std::size_t n) {
  const Points<K> points = random_points<K>(n);
  Points<K> sorted;
  for (const std::uint32_t i : hilbert_order<K>(points)) sorted.push_back(points[i]);
  return sorted;
}

/// The number per axis of a grid of about n points.
template <int K>
int per_axis(double n) {
  return static_cast<int>(std::lround(std::pow(n, 1.0 / K)));
}

/// A thick layer around the unit sphere, as a packing leaves it between a lattice and a boundary.
template <int K>
Points<K> shell(std::size_t n) {
  Random random(2);
  Points<K> points;
  while (points.size() < n) {
    Vec<K> p = 2.2 * random_point<K>(random);
    for (int k = 0; k < K; ++k) p[k] -= 1.1;
    if (norm(p) > 1.0 && norm(p) < 1.03) points.push_back(p);
  }
  return points;
}

/// Density that grows by six orders of magnitude towards the origin.
template <int K>
Points<K> graded(std::size_t n) {
  Random random(3);
  Points<K> points(n);
  for (Vec<K>& p : points) p = std::pow(10.0, -6 * random.unit()) * random_point<K>(random);
  return points;
}

/// Runs `work` in a process of its own; prints its processor time and the memory it adds, per point.
void measure(std::string_view kernel, std::size_t n, int repetitions, const std::function<std::size_t()>& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child != 0) {
    waitpid(child, nullptr, 0);
    return;
  }
  const double bytes = bench::peak_bytes();
  double best = 1e300;
  std::size_t n_simplices = 0;
  double added = 0;
  for (int r = 0; r < repetitions; ++r) {
    const double start = processor_seconds();
    n_simplices = work();
    best = std::min(best, processor_seconds() - start);
    if (r == 0) added = bench::peak_bytes() - bytes;
  }
  fmt::print("  {:<14}{:>8.0f} ns/point{:>8.0f} B/point{:>8.3f} simplices/point\n", kernel,
             1e9 * best / static_cast<double>(n), added / static_cast<double>(n),
             static_cast<double>(n_simplices) / static_cast<double>(n));
  std::fflush(stdout);
  _exit(0);
}

template <int K>
std::size_t run_cgal(const Points<K>& points) {
  using Epick = CGAL::Exact_predicates_inexact_constructions_kernel;
  if constexpr (K == 2) {
    std::vector<Epick::Point_2> input;
    for (const Vec<2>& p : points) input.emplace_back(p[0], p[1]);
    CGAL::Delaunay_triangulation_2<Epick> dt(input.begin(), input.end());
    return dt.number_of_faces();
  } else {
    std::vector<Epick::Point_3> input;
    for (const Vec<3>& p : points) input.emplace_back(p[0], p[1], p[2]);
    CGAL::Delaunay_triangulation_3<Epick> dt(input.begin(), input.end());
    return dt.number_of_finite_cells();
  }
}

template <int K>
std::size_t run_own(const Points<K>& points) {
  BowyerWatson<K> kernel;
  kernel.insert(points);
  std::size_t n_finite = 0;
  for (std::uint32_t s = 0; s < kernel.n_slots(); ++s) n_finite += kernel.is_finite(s) ? 1 : 0;
  return n_finite;
}

template <int K>
void compare(std::string_view name, std::string_view wanted, int repetitions, const Points<K>& points) {
  const std::string full = fmt::format("{}d {}", K, name);
  if (full.find(wanted) == std::string::npos) return;
  fmt::print("{}, {} points\n", full, points.size());
  measure("BowyerWatson", points.size(), repetitions, [&] { return run_own<K>(points); });
  if (std::getenv("ONLY_OWN") == nullptr)
    measure("CGAL", points.size(), repetitions, [&] { return run_cgal<K>(points); });
}

template <int K>
void compare_all(std::size_t n, std::string_view wanted, int repetitions) {
  const double step = 1.0 / std::pow(static_cast<double>(n), 1.0 / K);
  compare<K>("random", wanted, repetitions, random_points<K>(n));
  compare<K>("random, sorted", wanted, repetitions, sorted_points<K>(n));
  const int n_grid = per_axis<K>(static_cast<double>(n)), n_centered = per_axis<K>(static_cast<double>(n) / 2);
  compare<K>("centered lattice of integers", wanted, repetitions, test::centered_points<K>(n_centered, 1.0));
  compare<K>("centered lattice, rounded", wanted, repetitions, test::centered_points<K>(n_centered, step));
  compare<K>("grid of integers", wanted, repetitions, test::grid_points<K>(n_grid, 1.0));
  compare<K>("grid, rounded", wanted, repetitions, test::grid_points<K>(n_grid, step));
  compare<K>("shell", wanted, repetitions, shell<K>(n));
  compare<K>("graded", wanted, repetitions, graded<K>(n));
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000'000;
  const std::string_view wanted = argc > 2 ? argv[2] : "";
  const int repetitions = argc > 3 ? std::atoi(argv[3]) : 1;
  voropack::compare_all<3>(n, wanted, repetitions);
  voropack::compare_all<2>(n, wanted, repetitions);
  return 0;
}
