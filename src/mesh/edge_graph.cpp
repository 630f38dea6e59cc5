#include "mesh/edge_graph.h"

#include <algorithm>
#include <atomic>
#include <bit>
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
  Descent(const EdgeGraph& graph, double lipschitz, IdVector<VertexId, double>& f)
      : graph_(graph), lipschitz_(lipschitz), f_(f), is_stale_(f.size(), 1), is_block_stale_(n_blocks(), 1) {}

  void run() {
    while (std::ranges::count(is_block_stale_, 1) > 0)
      parallel_for(
          n_blocks(),
          [&](std::size_t block) {
            if (flag(is_block_stale_[block]).exchange(0, std::memory_order_acq_rel) != 0) sweep(block);
          },
          1);
  }

 private:
  static constexpr std::size_t kBlock = 4096;
  using Flag = std::atomic_ref<std::uint8_t>;

  [[nodiscard]] std::size_t n_blocks() const { return (f_.size() + kBlock - 1) / kBlock; }
  static Flag flag(std::uint8_t& of) { return Flag(of); }
  [[nodiscard]] double value(VertexId v) const {
    return std::atomic_ref<double>(f_[v]).load(std::memory_order_relaxed);
  }

  /// Forward and backward until no vertex of the block is stale.
  void sweep(std::size_t block) {
    const std::size_t begin = block * kBlock, end = std::min(f_.size(), begin + kBlock);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = begin; v < end; ++v) changed |= visit(VertexId(v));
      if (!changed) break;
      changed = false;
      for (std::size_t v = end; v-- > begin;) changed |= visit(VertexId(v));
    }
  }

  bool visit(VertexId v) {
    const Flag stale = flag(is_stale_[v.value()]);
    if (stale.load(std::memory_order_relaxed) == 0) return false;
    // Values are read after the mark is gone, which takes a processor long to make sure of for others.
    if (is_alone_)
      stale.store(0, std::memory_order_relaxed);
    else
      stale.exchange(0, std::memory_order_acq_rel);
    const auto row = graph_.neighbors[v];
    const auto lengths = graph_.lengths(v);
    const double before = value(v);
    double least = before;
    for (std::size_t i = 0; i < row.size(); ++i)
      least = std::min(least, value(row[i]) + lipschitz_ * static_cast<double>(lengths[i]));
    if (least >= before) return false;
    std::atomic_ref(f_[v]).store(least, std::memory_order_relaxed);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (value(row[i]) <= least + lipschitz_ * static_cast<double>(lengths[i])) continue;
      flag(is_stale_[row[i].value()]).store(1, std::memory_order_release);
      const std::size_t block = row[i].value() / kBlock;
      if (block != v.value() / kBlock) flag(is_block_stale_[block]).store(1, std::memory_order_release);
    }
    return true;
  }

  const EdgeGraph& graph_;
  double lipschitz_;
  IdVector<VertexId, double>& f_;
  bool is_alone_ = is_single_threaded();
  std::vector<std::uint8_t> is_stale_;  ///< Whether a neighbor has become too small since the vertex was looked at.
  std::vector<std::uint8_t> is_block_stale_;  ///< Whether another block has marked one of its vertices.
};

}  // namespace

template <int D>
EdgeGraph build_edge_graph(const Mesh<D>& mesh) {
  EdgeGraph graph;
  graph.neighbors = adjacent_values<VertexId>(
      mesh.points.size(), mesh.simplex_vertices.size(),
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
  Descent(graph, lipschitz, f).run();
}

template EdgeGraph build_edge_graph(const Mesh<2>&);
template EdgeGraph build_edge_graph(const Mesh<3>&);

}  // namespace voropack
