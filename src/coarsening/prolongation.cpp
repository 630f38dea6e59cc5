#include "coarsening/prolongation.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <mutex>

#include "base/parallel.h"
#include "geom/box_tree.h"

namespace voropack {

namespace {

/// Coordinates below this are those of a vertex on a face, up to rounding.
constexpr double kOnFace = 1e-10;
constexpr std::size_t kBlock = 2048;

template <int D>
using Weights = std::array<double, D + 1>;

template <int D>
class Interpolator {
 public:
  explicit Interpolator(const Mesh<D>& coarse) : mesh_(coarse) {}

  /// Walks from simplex `at` to the one that holds x, and returns the coordinates of x in it. Where the hull is in the
  /// way, all simplices are searched.
  Weights<D> locate(const Vec<D>& x, SimplexId& at) const {
    const std::size_t most_steps = 64 + mesh_.simplex_vertices.size() / 16;
    for (std::size_t step = 0; step < most_steps; ++step) {
      const Weights<D> w = coordinates(at, x);
      std::size_t next = D + 1;
      double least = -kOnFace;
      for (std::size_t i = 0; i <= D; ++i)
        if (w[i] < least && !mesh_.simplex_neighbors[at][i].is_none()) least = w[i], next = i;
      if (next <= D) {
        at = mesh_.simplex_neighbors[at][next];
        continue;
      }
      if (*std::min_element(w.begin(), w.end()) >= -kOnFace) return w;
      break;
    }
    return search(x, at);
  }

 private:
  /// Barycentric coordinates by ratios of volumes.
  [[nodiscard]] Weights<D> coordinates(SimplexId s, const Vec<D>& x) const {
    const auto& v = mesh_.simplex_vertices[s];
    const Vec<D> o = mesh_.points[v[D]];
    Weights<D> w;
    if constexpr (D == 2) {
      const Vec<2> a = mesh_.points[v[0]] - o, b = mesh_.points[v[1]] - o, p = x - o;
      const double whole = cross(a, b);
      w[0] = cross(p, b) / whole;
      w[1] = cross(a, p) / whole;
    } else {
      const Vec<3> a = mesh_.points[v[0]] - o, b = mesh_.points[v[1]] - o, c = mesh_.points[v[2]] - o, p = x - o;
      const double whole = dot(a, cross(b, c));
      w[0] = dot(p, cross(b, c)) / whole;
      w[1] = dot(a, cross(p, c)) / whole;
      w[2] = dot(a, cross(b, p)) / whole;
    }
    w[D] = 1;
    for (std::size_t i = 0; i < D; ++i) w[D] -= w[i];
    return w;
  }

  /// The simplex in which the least coordinate of x is largest, among those whose box is near x; if none is near, among
  /// all.
  Weights<D> search(const Vec<D>& x, SimplexId& at) const {
    std::call_once(tree_once_, [&] {
      std::vector<Box<D>> boxes(mesh_.simplex_vertices.size());
      for (const SimplexId s : ids(mesh_.simplex_vertices))
        for (const VertexId v : mesh_.simplex_vertices[s]) boxes[s.value()].add(mesh_.points[v]);
      tree_ = std::make_unique<BoxTree<D>>(boxes);
      size_ = tree_->nodes().front().box.diagonal();
    });
    double best = -std::numeric_limits<double>::infinity();
    Weights<D> result{};
    for (double reach = 1e-9 * size_; best == -std::numeric_limits<double>::infinity(); reach *= 32)
      tree_->for_each([&](const Box<D>& box) { return box.distance_sq(x) <= reach * reach; },
                      [&](std::uint32_t i) {
                        const Weights<D> w = coordinates(SimplexId(i), x);
                        const double least = *std::min_element(w.begin(), w.end());
                        if (least <= best) return;
                        best = least;
                        result = w;
                        at = SimplexId(i);
                      });
    return result;
  }

  const Mesh<D>& mesh_;
  mutable std::once_flag tree_once_;
  mutable std::unique_ptr<BoxTree<D>> tree_;
  mutable double size_ = 0;
};

struct Entry {
  std::uint32_t column;
  double value;
};

/// The coordinates that are not zero, by column; they add up to one.
template <int D>
void append_row(const std::array<VertexId, D + 1>& corners, const Weights<D>& weights, std::vector<Entry>& out) {
  std::array<Entry, D + 1> row;
  std::size_t n = 0;
  double sum = 0;
  for (std::size_t i = 0; i <= D; ++i)
    if (weights[i] > kOnFace) {
      row[n++] = {corners[i].value(), weights[i]};
      sum += weights[i];
    }
  std::sort(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n),
            [](const Entry& a, const Entry& b) { return a.column < b.column; });
  for (std::size_t i = 0; i < n; ++i) out.push_back({row[i].column, row[i].value / sum});
}

}  // namespace

template <int D>
SparseMatrix barycentric_prolongation(const Mesh<D>& coarse, const Mesh<D>& fine,
                                      const std::vector<VertexId>& coarse_of) {
  const Interpolator<D> interpolator(coarse);
  const std::size_t n = fine.points.size();
  struct Part {
    std::vector<Entry> entries;
    std::vector<std::uint32_t> counts;
  };
  std::vector<SimplexId> simplex_of(coarse.points.size());
  for (const SimplexId s : ids(coarse.simplex_vertices))
    for (const VertexId v : coarse.simplex_vertices[s]) simplex_of[v.value()] = s;
  std::vector<Part> parts((n + kBlock - 1) / kBlock);
  parallel_for(
      parts.size(),
      [&](std::size_t block) {
        SimplexId at(0);
        const std::size_t begin = block * kBlock, end = std::min(n, begin + kBlock);
        parts[block].entries.reserve((D + 1) * kBlock);
        parts[block].counts.reserve(kBlock);
        for (std::size_t v = begin; v < end; ++v)  // A coarse vertex that is near the first one.
          if (!coarse_of[v].is_none()) {
            at = simplex_of[coarse_of[v].value()];
            break;
          }
        for (std::size_t v = begin; v < end; ++v) {
          const std::size_t before = parts[block].entries.size();
          if (!coarse_of[v].is_none()) {
            at = simplex_of[coarse_of[v].value()];
            parts[block].entries.push_back({coarse_of[v].value(), 1.0});
          } else {
            const Weights<D> weights = interpolator.locate(fine.points[VertexId(v)], at);
            append_row<D>(coarse.simplex_vertices[at], weights, parts[block].entries);
          }
          parts[block].counts.push_back(static_cast<std::uint32_t>(parts[block].entries.size() - before));
        }
      },
      1);
  SparseMatrix result;
  std::size_t n_entries = 0;
  for (const Part& part : parts) n_entries += part.entries.size();
  result.offsets.reserve(n + 1);
  result.columns.reserve(n_entries);
  result.values.reserve(n_entries);
  for (const Part& part : parts) {
    for (const std::uint32_t count : part.counts) result.offsets.push_back(result.offsets.back() + count);
    for (const Entry& entry : part.entries) {
      result.columns.push_back(entry.column);
      result.values.push_back(entry.value);
    }
  }
  return result;
}

template <int D>
void link_level(const Mesh<D>& finest, const CoarseLevel<D>* finer, CoarseLevel<D>& level) {
  level.finer_vertex = level.finest_vertex;
  if (finer != nullptr) {
    std::vector<VertexId> in_finer(finest.points.size());
    for (const VertexId v : ids(finer->finest_vertex)) in_finer[finer->finest_vertex[v].value()] = v;
    for (VertexId& v : level.finer_vertex) v = in_finer[v.value()];
  }
  const Mesh<D>& mesh = finer == nullptr ? finest : finer->mesh;
  std::vector<VertexId> coarse_of(mesh.points.size());
  for (const VertexId v : ids(level.finer_vertex)) coarse_of[level.finer_vertex[v].value()] = v;
  level.prolongation = barycentric_prolongation(level.mesh, mesh, coarse_of);
}

template SparseMatrix barycentric_prolongation(const Mesh<2>&, const Mesh<2>&, const std::vector<VertexId>&);
template SparseMatrix barycentric_prolongation(const Mesh<3>&, const Mesh<3>&, const std::vector<VertexId>&);
template void link_level(const Mesh<2>&, const CoarseLevel<2>*, CoarseLevel<2>&);
template void link_level(const Mesh<3>&, const CoarseLevel<3>*, CoarseLevel<3>&);

}  // namespace voropack
