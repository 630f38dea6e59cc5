#include "support/nested_hierarchy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "support/delaunay_mesh.h"
#include "support/grid_mesh.h"
#include "voropack/boundary_areas.h"
#include "voropack/dual.h"

namespace voropack::test {

namespace {

using Row = std::vector<std::pair<std::uint32_t, double>>;

void append_row(SparseMatrix& matrix, Row row) {
  std::sort(row.begin(), row.end());
  for (const auto& [column, value] : row) {
    matrix.columns.push_back(column);
    matrix.values.push_back(value);
  }
  matrix.offsets.push_back(matrix.columns.size());
}

template <int D>
LinearSystem system_of(const Mesh<D>& mesh, const BoxProblem& box) {
  const BoundaryAreas<D> boundary = build_boundary_areas(mesh);
  DiffusionProblem<D> problem;
  problem.conductivity = RegionFunction<D>([&](const Vec<D>&, int region) { return region == 2 ? box.right : 1.0; });
  problem.reaction = box.reaction;
  problem.source = 1.0;
  if (box.is_dirichlet)
    for (const int marker : boundary.patch_marker) problem.conditions[marker] = Dirichlet<D>{0.0};
  LinearSystem system = assemble(build_control_volumes(mesh), boundary, problem);
  if (!box.is_dirichlet && box.reaction == 0) {
    // The load of a solvable Neumann problem: as much goes in as out.
    double sum = 0;
    for (const VertexId v : ids(system.load)) sum += system.load[v] *= mesh.points[v][0] < 0.3 ? 2.0 : 1.0;
    for (double& load : system.load) load -= sum / static_cast<double>(system.load.size());
    system.is_fixed[VertexId(0)] = 1;
  }
  return system;
}

/// Buckets of a grid over the unit cube.
template <int D>
class Buckets {
 public:
  explicit Buckets(double width) : n_(std::max(1, static_cast<int>(1 / width))) {}

  void add(std::uint32_t item, const Vec<D>& low, const Vec<D>& high) {
    for_each(low, high, [&](std::size_t bucket) { items_[bucket].push_back(item); });
  }
  /// fn(items) for every bucket that the box meets.
  template <class Fn>
  void visit(const Vec<D>& low, const Vec<D>& high, Fn&& fn) const {
    for_each(low, high, [&](std::size_t bucket) {
      if (const auto at = items_.find(bucket); at != items_.end()) fn(at->second);
    });
  }

 private:
  template <class Fn>
  void for_each(const Vec<D>& low, const Vec<D>& high, Fn&& fn) const {
    std::array<int, 3> a{}, b{};
    for (int k = 0; k < D; ++k) {
      a[static_cast<std::size_t>(k)] = std::clamp(static_cast<int>(std::floor(low[k] * n_)), 0, n_ - 1);
      b[static_cast<std::size_t>(k)] = std::clamp(static_cast<int>(std::floor(high[k] * n_)), 0, n_ - 1);
    }
    for (int x = a[0]; x <= b[0]; ++x)
      for (int y = a[1]; y <= b[1]; ++y)
        for (int z = a[2]; z <= b[2]; ++z)
          fn((static_cast<std::size_t>(z) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(y)) *
                 static_cast<std::size_t>(n_) +
             static_cast<std::size_t>(x));
  }

  int n_;
  std::map<std::size_t, std::vector<std::uint32_t>> items_;
};

/// How many coordinates are 0 or 1: vertices, edges and faces of the cube first.
template <int D>
int n_walls(const Vec<D>& x) {
  int n = 0;
  for (int k = 0; k < D; ++k) n += x[k] == 0 || x[k] == 1;
  return n;
}

/// Whether a point is on a wall or far enough from it that the triangles there keep their protecting balls empty.
template <int D>
bool respects_walls(const Vec<D>& x, double distance) {
  for (int k = 0; k < D; ++k)
    if (const double gap = std::min(x[k], 1 - x[k]); gap > 0 && gap < 0.7 * distance) return false;
  return true;
}

/// The vertices in descending number of walls that keep the distance from all before.
template <int D>
std::vector<std::uint32_t> greedy_subset(const std::vector<Vec<D>>& points, double distance) {
  Buckets<D> buckets(distance);
  std::vector<std::uint32_t> chosen;
  for (int walls = D; walls >= 0; --walls)
    for (std::uint32_t p = 0; p < points.size(); ++p) {
      if (n_walls(points[p]) != walls || !respects_walls(points[p], distance)) continue;
      Vec<D> low = points[p], high = points[p];
      for (int k = 0; k < D; ++k) low[k] -= distance, high[k] += distance;
      bool is_free = true;
      buckets.visit(low, high, [&](const std::vector<std::uint32_t>& items) {
        for (const std::uint32_t q : items) is_free &= norm(points[p] - points[q]) >= distance;
      });
      if (!is_free) continue;
      chosen.push_back(p);
      buckets.add(p, points[p], points[p]);
    }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// Barycentric coordinates by Cramer's rule.
template <int D>
std::array<double, D + 1> barycentric(const std::array<Vec<D>, D + 1>& corners, const Vec<D>& x) {
  const auto volume = [](const std::array<Vec<D>, D + 1>& p) {
    if constexpr (D == 2) {
      const Vec<2> a = p[1] - p[0], b = p[2] - p[0];
      return a[0] * b[1] - a[1] * b[0];
    } else {
      const Vec<3> a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
      return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
             a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
  };
  std::array<double, D + 1> weights;
  for (std::size_t i = 0; i <= D; ++i) {
    std::array<Vec<D>, D + 1> moved = corners;
    moved[i] = x;
    weights[i] = volume(moved) / volume(corners);
  }
  return weights;
}

/// Rows of barycentric coordinates in the simplex of `coarse` that holds a point best.
template <int D>
SparseMatrix interpolation(const std::vector<Vec<D>>& points, const Mesh<D>& coarse, double width) {
  Buckets<D> buckets(width);
  const auto corners_of = [&](std::uint32_t s) {
    std::array<Vec<D>, D + 1> corners;
    for (std::size_t i = 0; i <= D; ++i) corners[i] = coarse.points[coarse.simplex_vertices[SimplexId(s)][i]];
    return corners;
  };
  for (std::uint32_t s = 0; s < coarse.simplex_vertices.size(); ++s) {
    const auto corners = corners_of(s);
    Vec<D> low = corners[0], high = corners[0];
    for (const Vec<D>& x : corners)
      for (int k = 0; k < D; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
    buckets.add(s, low, high);
  }
  SparseMatrix matrix;
  for (const Vec<D>& x : points) {
    double best = -1e300;
    Row row;
    buckets.visit(x, x, [&](const std::vector<std::uint32_t>& items) {
      for (const std::uint32_t s : items) {
        const auto weights = barycentric<D>(corners_of(s), x);
        const double least = *std::min_element(weights.begin(), weights.end());
        if (least <= best) continue;
        best = least;
        row.clear();
        double sum = 0;
        for (const double w : weights) sum += w > 1e-9 ? w : 0;
        for (std::size_t i = 0; i <= D; ++i)
          if (weights[i] > 1e-9) row.emplace_back(coarse.simplex_vertices[SimplexId(s)][i].value(), weights[i] / sum);
      }
    });
    append_row(matrix, row);
  }
  return matrix;
}

}  // namespace

std::vector<MultigridLevel> NestedHierarchy::views(bool with_matrices) const {
  std::vector<MultigridLevel> out;
  for (const NestedLevel& level : levels)
    out.push_back({.prolongation = &level.prolongation,
                   .finest_vertex = level.finest_vertex,
                   .matrix = with_matrices && level.matrix ? &*level.matrix : nullptr});
  return out;
}

template <int D>
NestedHierarchy grid_hierarchy(std::size_t n, const BoxProblem& problem) {
  NestedHierarchy hierarchy;
  hierarchy.system = system_of(grid_mesh<D>(n), problem);
  for (std::size_t stride = 2; n % stride == 0 && n / stride >= 2; stride *= 2) {
    const std::size_t m = n / stride;
    const std::size_t fine_side = 2 * m + 1, side = m + 1;
    NestedLevel level;
    const std::size_t n_fine = D == 2 ? fine_side * fine_side : fine_side * fine_side * fine_side;
    for (std::size_t p = 0; p < n_fine; ++p) {
      // A fine point is a coarse one, or the middle of the edge between those below and above it.
      const std::array<std::size_t, 3> at = {p % fine_side, p / fine_side % fine_side, p / fine_side / fine_side};
      std::size_t below = 0, above = 0, step = 1;
      for (std::size_t k = 0; k < D; ++k, step *= side) {
        below += step * (at[k] / 2);
        above += step * ((at[k] + 1) / 2);
      }
      const auto a = static_cast<std::uint32_t>(below), b = static_cast<std::uint32_t>(above);
      append_row(level.prolongation, a == b ? Row{{a, 1.0}} : Row{{a, 0.5}, {b, 0.5}});
    }
    const std::size_t n_coarse = D == 2 ? side * side : side * side * side;
    for (std::size_t p = 0; p < n_coarse; ++p) {
      const std::size_t x = p % side, y = p / side % side, z = p / side / side;
      level.finest_vertex.emplace_back(stride * (x + (n + 1) * (y + (n + 1) * z)));
    }
    level.matrix = system_of(grid_mesh<D>(m), problem).matrix;
    hierarchy.levels.push_back(std::move(level));
  }
  return hierarchy;
}

template <int D>
NestedHierarchy greedy_hierarchy(const Mesh<D>& mesh, double growth, const BoxProblem& problem) {
  NestedHierarchy hierarchy;
  hierarchy.system = system_of(mesh, problem);
  std::vector<Vec<D>> points = mesh.points.raw();
  std::vector<VertexId> finest_vertex;
  for (const VertexId v : ids(mesh.points)) finest_vertex.push_back(v);
  double distance = 0.9 * std::pow(static_cast<double>(points.size()), -1.0 / D);
  while (points.size() > 100) {
    distance *= growth;
    const std::vector<std::uint32_t> chosen = greedy_subset<D>(points, distance);
    NestedLevel level;
    std::vector<Vec<D>> coarse_points;
    for (const std::uint32_t p : chosen) {
      coarse_points.push_back(points[p]);
      level.finest_vertex.push_back(finest_vertex[p]);
    }
    const Mesh<D> coarse = delaunay_mesh<D>(coarse_points);
    level.prolongation = interpolation(points, coarse, 2 * distance);
    level.matrix = system_of(coarse, problem).matrix;
    points = std::move(coarse_points);
    finest_vertex = level.finest_vertex;
    hierarchy.levels.push_back(std::move(level));
  }
  return hierarchy;
}

template NestedHierarchy grid_hierarchy<2>(std::size_t, const BoxProblem&);
template NestedHierarchy grid_hierarchy<3>(std::size_t, const BoxProblem&);
template NestedHierarchy greedy_hierarchy(const Mesh<2>&, double, const BoxProblem&);
template NestedHierarchy greedy_hierarchy(const Mesh<3>&, double, const BoxProblem&);

}  // namespace voropack::test
