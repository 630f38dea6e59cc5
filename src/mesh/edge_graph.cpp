#include "mesh/edge_graph.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/parallel.h"
#include "mesh/parallel_rows.h"

namespace voropack {

namespace {

/// x >= 0.
float rounded_down(double x) {
  // The float below a positive one is that of the integer below; a call of std::nextafter would take longer than the
  // length itself.
  const auto y = static_cast<float>(x);
  const std::uint32_t above = static_cast<double>(y) > x ? 1 : 0;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(y) - above);
}

/// Values that fall until they are Lipschitz. Every vertex is changed by the sweep of its own block only; other blocks
/// may read it at the same time. What they read is at or above its last value, and who has more than that allows is
/// marked after each change, so that nothing is missed.
class Descent {
 public:
  Descent(const EdgeGraph& graph, double lipschitz, std::size_t n)
      : graph_(graph), lipschitz_(lipschitz), is_stale_(n, 0), is_block_stale_((n + kBlock - 1) / kBlock, 0) {}

  /// Threads may mark at a time.
  void mark(VertexId v) {
    flag(is_stale_[v.value()]).store(1, std::memory_order_release);
    flag(is_block_stale_[v.value() / kBlock]).store(1, std::memory_order_release);
  }
  void mark_all() {
    std::ranges::fill(is_stale_, std::uint8_t{1});
    std::ranges::fill(is_block_stale_, std::uint8_t{1});
  }

  /// Those that have more than their neighbors allow must be marked; no mark is left. fallen(v) is called for each
  /// vertex whose value falls, by the thread that has its block.
  template <class Fallen>
  void run(IdVector<VertexId, double>& f, const Fallen& fallen) {
    while (std::ranges::count(is_block_stale_, 1) > 0)
      parallel_for(
          is_block_stale_.size(),
          [&](std::size_t block) {
            if (flag(is_block_stale_[block]).exchange(0, std::memory_order_acq_rel) != 0) sweep(block, f, fallen);
          },
          1);
  }

 private:
  static constexpr std::size_t kBlock = 4096;
  using Flag = std::atomic_ref<std::uint8_t>;

  static Flag flag(std::uint8_t& of) { return Flag(of); }
  static double load(double& value) { return std::atomic_ref(value).load(std::memory_order_relaxed); }

  /// Forward and backward until no vertex of the block is stale.
  template <class Fallen>
  void sweep(std::size_t block, IdVector<VertexId, double>& f, const Fallen& fallen) {
    const std::size_t begin = block * kBlock, end = std::min(f.size(), begin + kBlock);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = begin; v < end; ++v) changed |= visit(VertexId(v), f, fallen);
      if (!changed) break;
      changed = false;
      for (std::size_t v = end; v-- > begin;) changed |= visit(VertexId(v), f, fallen);
    }
  }

  template <class Fallen>
  bool visit(VertexId v, IdVector<VertexId, double>& f, const Fallen& fallen) {
    const Flag stale = flag(is_stale_[v.value()]);
    if (stale.load(std::memory_order_relaxed) == 0) return false;
    // Values are read after the mark is gone, which takes a processor long to make sure of for others.
    if (is_alone_)
      stale.store(0, std::memory_order_relaxed);
    else
      stale.exchange(0, std::memory_order_acq_rel);
    const auto row = graph_.neighbors[v];
    const auto lengths = graph_.lengths(v);
    const double before = load(f[v]);
    double least = before;
    for (std::size_t i = 0; i < row.size(); ++i)
      least = std::min(least, load(f[row[i]]) + lipschitz_ * static_cast<double>(lengths[i]));
    if (least >= before) return false;
    std::atomic_ref(f[v]).store(least, std::memory_order_relaxed);
    fallen(v);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (load(f[row[i]]) <= least + lipschitz_ * static_cast<double>(lengths[i])) continue;
      flag(is_stale_[row[i].value()]).store(1, std::memory_order_release);
      const std::size_t block = row[i].value() / kBlock;
      if (block != v.value() / kBlock) flag(is_block_stale_[block]).store(1, std::memory_order_release);
    }
    return true;
  }

  const EdgeGraph& graph_;
  double lipschitz_;
  bool is_alone_ = is_single_threaded();
  std::vector<std::uint8_t> is_stale_;  ///< Whether a neighbor has become too small since the vertex was looked at.
  std::vector<std::uint8_t> is_block_stale_;  ///< Whether another block has marked one of its vertices.
};

}  // namespace

template <int D>
EdgeGraph build_edge_graph(const Mesh<D>& mesh) {
  EdgeGraph graph;
  const std::size_t n = mesh.simplex_vertices.size();
  if constexpr (D == 2)
    graph.neighbors = adjacent_in_plane<VertexId>(
        mesh.points.size(), n,
        [&](std::size_t s) {
          const auto& [a, b, c] = mesh.simplex_vertices[SimplexId(s)];
          return std::array{a.value(), b.value(), c.value()};
        },
        [&](std::size_t s) {
          const auto& [a, b, c] = mesh.simplex_neighbors[SimplexId(s)];
          return std::array{a.value(), b.value(), c.value()};
        },
        [&](std::size_t s) { return s < n; });
  else
    graph.neighbors = adjacent_values<VertexId>(
        mesh.points.size(), n,
        [&](std::size_t s) -> const std::array<VertexId, D + 1>& { return mesh.simplex_vertices[SimplexId(s)]; },
        [](std::size_t) { return true; });
  graph.length.resize(graph.neighbors.values.size());
  parallel_for(mesh.points.size(), [&](std::size_t i) {
    const VertexId v(i);
    std::uint64_t k = graph.neighbors.offsets[i];
    for (const VertexId w : graph.neighbors[v])
      graph.length[k++] = rounded_down(distance(mesh.points[v], mesh.points[w]));
  });
  return graph;
}

void make_lipschitz(const EdgeGraph& graph, double lipschitz, IdVector<VertexId, double>& f) {
  Descent descent(graph, lipschitz, f.size());
  descent.mark_all();
  descent.run(f, [](VertexId) {});
}

std::vector<IdVector<VertexId, double>> grown_lipschitz(const EdgeGraph& graph, double lipschitz,
                                                        const IdVector<VertexId, double>& f, double growth,
                                                        std::size_t n_levels) {
  // For rounding, of the growth on all levels as well: it does no harm to look at a vertex in vain.
  constexpr double kSlack = 1e-12;
  constexpr std::size_t kMostLevels = 250;
  const std::size_t n = f.size();
  // How much of the slope that is allowed f may have on a level, after so much growth.
  std::vector<double> allowed(std::min(n_levels, kMostLevels));
  for (std::size_t level = 0; level < allowed.size(); ++level)
    allowed[level] = (1 - kSlack) * lipschitz / std::pow(growth, static_cast<double>(level + 1));
  // The level on which a vertex has too much beside a neighbor for the first time, if nothing falls before.
  std::vector<std::uint8_t> first(n);
  parallel_for(n, [&](std::size_t i) {
    const VertexId v(i);
    const auto row = graph.neighbors[v];
    const auto lengths = graph.lengths(v);
    const double mine = (1 + kSlack) * f[v];
    std::size_t level = allowed.size();
    for (std::size_t k = 0; k < row.size(); ++k)
      while (level > 0 && mine - f[row[k]] > allowed[level - 1] * static_cast<double>(lengths[k])) --level;
    first[i] = static_cast<std::uint8_t>(level);
  });
  Descent descent(graph, lipschitz, n);
  std::vector<std::uint8_t> has_fallen(n, 0);
  std::vector<IdVector<VertexId, double>> levels;
  IdVector<VertexId, double> grown = f;
  for (std::size_t level = 0; level < n_levels; ++level) {
    // What has fallen once does so on all levels after that, and its neighbors may.
    parallel_for(n, [&](std::size_t i) {
      grown[VertexId(i)] *= growth;
      if (first[i] <= level || has_fallen[i] != 0) descent.mark(VertexId(i));
      if (has_fallen[i] != 0)
        for (const VertexId w : graph.neighbors[VertexId(i)]) descent.mark(w);
    });
    descent.run(grown, [&](VertexId v) { has_fallen[v.value()] = 1; });
    levels.push_back(grown);
  }
  return levels;
}

template EdgeGraph build_edge_graph(const Mesh<2>&);
template EdgeGraph build_edge_graph(const Mesh<3>&);

}  // namespace voropack
