#include "voropack/dual.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "base/unset_array.h"
#include "dual/face_weight.h"
#include "mesh/faces.h"
#include "mesh/incidence.h"

namespace voropack {

namespace {

constexpr std::size_t kBlock = 1024;  // Vertices or simplices per task.

/// [simplex][i] the share of the simplex in the weight q of the face opposite to corner i (face_weight.h): one half of
/// an interior face's q, so that both its simplices add up to q; all of q where the region ends.
template <int D>
using Shares = UnsetArray<SimplexId, std::array<double, D + 1>>;

struct ShareStatistics {
  std::uint64_t n_beyond_double = 0;
  bool conforming = true;  ///< No weight is negative.

  friend ShareStatistics operator+(ShareStatistics a, const ShareStatistics& b) {
    return {a.n_beyond_double + b.n_beyond_double, a.conforming && b.conforming};
  }
};

[[noreturn]] void throw_degenerate(SimplexId s, SimplexId t, std::vector<double> position) {
  std::string which = "simplex " + std::to_string(s.value());
  if (!t.is_none()) which += " or its neighbor " + std::to_string(t.value());
  throw InputError(Fault{.id = "mesh.degenerate_simplex",
                         .message = which + " is flat or not positively oriented, so that it has no circumcenter",
                         .fix = "orient all simplices positively and remove flat ones",
                         .position = std::move(position)});
}

template <int D>
std::array<Vec<D>, D> positions(const Mesh<D>& mesh, const std::array<VertexId, D>& vertices) {
  if constexpr (D == 2)
    return {mesh.points[vertices[0]], mesh.points[vertices[1]]};
  else
    return {mesh.points[vertices[0]], mesh.points[vertices[1]], mesh.points[vertices[2]]};
}

/// Writes the share of the face opposite to corner I of s if s answers for it: if it leads to no simplex, to another
/// region, or to a later simplex.
template <int D, std::size_t I>
void compute_share(const Mesh<D>& mesh, SimplexId s, Shares<D>& shares, ShareStatistics& statistics) {
  const SimplexId t = neighbor_in_region(mesh, s, I);
  if (!t.is_none() && t < s) return;
  const auto& vertices = mesh.simplex_vertices[s];
  const std::array<Vec<D>, D> face = positions<D>(mesh, face_vertices<D, I>(vertices));
  const Vec<D>& above = mesh.points[vertices[I]];
  FaceWeight weight;
  if (t.is_none()) {
    weight = boundary_weight<D>(face, above);
    shares[s][I] = weight.value;
  } else {
    const auto mirror = static_cast<std::size_t>(mirror_corner(mesh, s, t, I));
    weight = interior_weight<D>(face, above, mesh.points[mesh.simplex_vertices[t][mirror]]);
    shares[s][I] = 0.5 * weight.value;
    shares[t][mirror] = 0.5 * weight.value;
  }
  if (std::isnan(weight.value)) throw_degenerate(s, t, {above.coord.begin(), above.coord.end()});
  statistics.n_beyond_double += weight.beyond_double ? 1U : 0U;
  statistics.conforming &= weight.value >= 0;
}

template <int D>
void compute_shares_of(const Mesh<D>& mesh, SimplexId s, Shares<D>& shares, ShareStatistics& statistics) {
  [&]<std::size_t... I>(std::index_sequence<I...>) { (compute_share<D, I>(mesh, s, shares, statistics), ...); }
  (std::make_index_sequence<D + 1>{});
}

template <int D>
ShareStatistics compute_shares(const Mesh<D>& mesh, Observer& observer, Shares<D>& shares) {
  return parallel_reduce_ordered(
      mesh.simplex_vertices.size(), kBlock, ShareStatistics{},
      [&](std::size_t begin, std::size_t end) {
        observer.check_cancelled();
        ShareStatistics statistics;
        for (std::size_t s = begin; s != end; ++s) compute_shares_of(mesh, SimplexId(s), shares, statistics);
        return statistics;
      },
      [](const ShareStatistics& a, const ShareStatistics& b) { return a + b; });
}

/// One edge (i, j) in one region while the simplices around i are visited.
struct EdgeSum {
  double sum = 0;     ///< 4 A / h in 3D, A / h in 2D.
  double shares = 0;  ///< Sum of the magnitudes of the shares in it.
  VertexId other;
  int region = 0;
  std::uint32_t next = 0;  ///< The next entry with the same `other`, or kNoEntry.
  std::uint32_t n_terms = 0;
};

constexpr std::uint32_t kNoEntry = static_cast<std::uint32_t>(-1);

/// The edges of one vertex, found by their other end in constant time. One per thread, reused for each vertex.
class EdgeTable {
 public:
  explicit EdgeTable(std::size_t n_vertices) : first_(n_vertices, kNoEntry) {}

  EdgeSum& at(VertexId other, int region) {
    std::uint32_t& first = first_[other];
    for (std::uint32_t e = first; e != kNoEntry; e = entries_[e].next)
      if (entries_[e].region == region) return entries_[e];
    entries_.push_back({.other = other, .region = region, .next = first});
    first = static_cast<std::uint32_t>(entries_.size() - 1);
    return entries_.back();
  }

  /// The entries in ascending order of other end and region, which are then forgotten.
  std::vector<EdgeSum>& take_sorted() {
    for (const EdgeSum& e : entries_) first_[e.other] = kNoEntry;
    taken_.clear();
    std::swap(taken_, entries_);
    std::sort(taken_.begin(), taken_.end(), [](const EdgeSum& a, const EdgeSum& b) {
      return a.other != b.other ? a.other < b.other : a.region < b.region;
    });
    return taken_;
  }

 private:
  IdVector<VertexId, std::uint32_t> first_;
  std::vector<EdgeSum> entries_, taken_;
};

/// Adds what simplex s contributes to its edges from vertex i to later vertices. Returns the longest squared distance
/// from i to a corner.
double add_simplex(const Mesh<3>& mesh, const Shares<3>& shares, SimplexId s, VertexId i, EdgeTable& table) {
  const auto& vertices = mesh.simplex_vertices[s];
  const auto& share = shares[s];
  const int region = mesh.simplex_region[s];
  const std::size_t own = vertices[0] == i ? 0 : vertices[1] == i ? 1 : vertices[2] == i ? 2 : 3;
  const std::array<std::size_t, 3> corner = {(own + 1) & 3U, (own + 2) & 3U, (own + 3) & 3U};
  const Vec<3>& origin = mesh.points[i];
  const Vec<3>&p0 = mesh.points[vertices[corner[0]]], &p1 = mesh.points[vertices[corner[1]]],
        &p2 = mesh.points[vertices[corner[2]]];
  const Vec<3> from0 = origin - p0, from1 = origin - p1, from2 = origin - p2;
  const Vec<3> edge01 = p1 - p0, edge12 = p2 - p1, edge20 = p0 - p2;
  // The face (i, j, k) is opposite to the third of the other corners, l; its product is that of i - k and j - k.
  const auto add = [&](std::size_t j, std::size_t k, std::size_t l, const Vec<3>& from_k, const Vec<3>& edge_jk,
                       const Vec<3>& from_l, const Vec<3>& edge_lj) {
    if (vertices[corner[j]] < i) return;
    const double dot_k = -dot(from_k, edge_jk), dot_l = dot(from_l, edge_lj);
    EdgeSum& edge = table.at(vertices[corner[j]], region);
    const double share_k = share[corner[l]], share_l = share[corner[k]];
    edge.sum += dot_k * share_k + dot_l * share_l;
    edge.shares += std::abs(share_k) + std::abs(share_l);
    edge.n_terms += 2;
  };
  add(0, 1, 2, from1, edge01, from2, edge20);
  add(1, 2, 0, from2, edge12, from0, edge01);
  add(2, 0, 1, from0, edge20, from1, edge12);
  return std::max({norm_sq(from0), norm_sq(from1), norm_sq(from2)});
}

double add_simplex(const Mesh<2>& mesh, const Shares<2>& shares, SimplexId s, VertexId i, EdgeTable& table) {
  const auto& vertices = mesh.simplex_vertices[s];
  std::size_t own = 0;
  while (vertices[own] != i) ++own;
  for (std::size_t j = 0; j < 3; ++j) {
    if (j == own || vertices[j] < i) continue;
    EdgeSum& edge = table.at(vertices[j], mesh.simplex_region[s]);
    const double share = shares[s][3 - own - j];
    edge.sum += share;
    edge.shares += std::abs(share);
    ++edge.n_terms;
  }
  return 0;
}

/// 4 A / h (A / h in 2D) of one edge and region. If it is 0: what it was before that, and the certified error.
struct ResolvedSum {
  double value = 0;
  double dropped = 0, error = 0;
};

/// The area of edge (i, j) in a region to about 30 digits, over h/4: for the rare edges of a mesh that is not
/// conforming whose sign double precision leaves open.
ResolvedSum exact_sum(const Mesh<3>& mesh, std::span<const SimplexId> simplices, VertexId i, const EdgeSum& edge) {
  const VertexId j = edge.other;
  Dd sum;
  double magnitude = 0;
  for (const SimplexId s : simplices) {
    const auto& vertices = mesh.simplex_vertices[s];
    if (mesh.simplex_region[s] != edge.region || std::find(vertices.begin(), vertices.end(), j) == vertices.end())
      continue;
    for (int f = 0; f < 4; ++f) {
      const VertexId above = vertices[static_cast<std::size_t>(f)];
      if (above == i || above == j) continue;
      const std::array<VertexId, 3> corners = face_vertices(mesh, s, f);
      const std::array<Vec<3>, 3> face = positions<3>(mesh, corners);
      const VertexId k = *std::find_if(corners.begin(), corners.end(), [&](VertexId v) { return v != i && v != j; });
      const SimplexId t = neighbor_in_region(mesh, s, f);
      Dd share;
      if (t.is_none()) {
        share = exact_boundary_weight<3>(face, mesh.points[above]);
      } else {
        const auto mirror = static_cast<std::size_t>(mirror_corner(mesh, s, t, f));
        const VertexId below = mesh.simplex_vertices[t][mirror];
        share = Dd(0.5) * exact_interior_weight<3>(face, mesh.points[above], mesh.points[below]);
      }
      for (int axis = 0; axis < 3; ++axis) {
        const double x = mesh.points[k][axis];
        const Dd term = two_diff(mesh.points[i][axis], x) * two_diff(mesh.points[j][axis], x) * share;
        sum = sum + term;
        magnitude += std::abs(term.hi);
      }
    }
  }
  const double value = to_double(sum), error = 64 * kDdUnit * magnitude;
  if (std::abs(value) <= error) return {.dropped = std::abs(value), .error = error};
  return {.value = value};
}

/// 4 A / h, with the sign of the exact value. `reach` bounds the distances from i to the corners around it.
ResolvedSum resolve_sum(const Mesh<3>& mesh, std::span<const SimplexId> simplices, VertexId i, const EdgeSum& edge,
                        double reach, bool conforming) {
  // Per term: the share errs by at most kFaceWeightError / L and |dot_k| <= 4 reach L; the product of |i - k| <= reach
  // and |j - k| <= 2 reach errs by at most 10u reach^2; and the sum by n u of its terms.
  const double rounding = 0x1.0p-53 * (10 + 2 * edge.n_terms) * reach * reach * edge.shares;
  const double error = 4 * kFaceWeightError * reach * edge.n_terms + rounding;
  if (std::abs(edge.sum) > error || edge.shares == 0 || (conforming && edge.sum > 0)) return {.value = edge.sum};
  // Areas of a conforming mesh are not negative, and this one is below the accuracy that is promised.
  if (conforming) return {.dropped = -edge.sum, .error = error};
  return exact_sum(mesh, simplices, i, edge);
}

/// A / h: in 2D the sum of two equal halves is the weight itself, whose sign is exact.
ResolvedSum resolve_sum(const Mesh<2>&, std::span<const SimplexId>, VertexId, const EdgeSum& edge, double, bool) {
  return {.value = edge.sum};
}

/// What one block of vertices contributes to the result, in order.
struct BlockResult {
  struct Face {
    VertexId i, j;
    int region = 0;
    double area = 0, edge_length = 0;
  };
  struct Cell {
    VertexId vertex;
    int region = 0;
  };
  std::vector<Face> faces;
  std::vector<Cell> cells;
  std::uint64_t n_zero_areas = 0;
  double zeroed_area = 0, zeroed_area_bound = 0;
};

/// The passes over the mesh that make the control volumes.
template <int D>
class DualBuilder {
 public:
  DualBuilder(const Mesh<D>& mesh, Observer& observer) : mesh_(mesh), observer_(observer) {}

  ControlVolumes<D> build() {
    ControlVolumes<D> out;
    out.sites = mesh_.points;
    const std::vector<BlockResult> blocks = sum_blocks(out);
    assemble(blocks, out);
    add_volumes(out);
    return out;
  }

 private:
  static constexpr double kSumToArea = D == 3 ? 0.25 : 1.0;
  static constexpr std::size_t kEdgesPerVertex = D == 3 ? 8 : 3;  // Slightly more than there are on average.

  std::vector<BlockResult> sum_blocks(ControlVolumes<D>& out) {
    Shares<D> shares(mesh_.simplex_vertices.size());
    ShareStatistics statistics;
    Csr<VertexId, SimplexId> incidence;
    parallel_invoke([&] { statistics = compute_shares(mesh_, observer_, shares); },
                    [&] { incidence = invert_incidence<VertexId>(mesh_.simplex_vertices, mesh_.points.size()); });
    const Csr<VertexId, SimplexId>& vertex_simplices = incidence;
    out.n_exact_evaluations = statistics.n_beyond_double;
    observer_.progress(1, 3);

    const std::size_t n = mesh_.points.size();
    std::vector<BlockResult> blocks((n + kBlock - 1) / kBlock);
    tbb::enumerable_thread_specific<EdgeTable> tables([&] { return EdgeTable(n); });
    parallel_for(
        blocks.size(),
        [&](std::size_t b) {
          observer_.check_cancelled();
          EdgeTable& table = tables.local();
          blocks[b].faces.reserve(kEdgesPerVertex * kBlock);
          blocks[b].cells.reserve(kBlock);
          for (std::size_t v = b * kBlock; v < std::min(n, (b + 1) * kBlock); ++v)
            sum_vertex(VertexId(v), shares, vertex_simplices[VertexId(v)], statistics.conforming, table, blocks[b]);
        },
        1);
    observer_.progress(2, 3);
    return blocks;
  }

  void sum_vertex(VertexId i, const Shares<D>& shares, std::span<const SimplexId> simplices, bool conforming,
                  EdgeTable& table, BlockResult& block) const {
    double reach_sq = 0;
    const std::size_t first_cell = block.cells.size();
    for (const SimplexId s : simplices) {
      reach_sq = std::max(reach_sq, add_simplex(mesh_, shares, s, i, table));
      const int region = mesh_.simplex_region[s];
      const auto begin = block.cells.begin() + static_cast<std::ptrdiff_t>(first_cell);
      const auto place = std::lower_bound(begin, block.cells.end(), region,
                                          [](const BlockResult::Cell& c, int r) { return c.region < r; });
      if (place == block.cells.end() || place->region != region) block.cells.insert(place, {i, region});
    }
    const double reach = std::sqrt(reach_sq);
    for (const EdgeSum& edge : table.take_sorted()) {
      const ResolvedSum sum = resolve_sum(mesh_, simplices, i, edge, reach, conforming);
      const double length = distance(mesh_.points[i], mesh_.points[edge.other]);
      const double area = kSumToArea * length * sum.value;
      if (area == 0) {
        ++block.n_zero_areas;
        block.zeroed_area += kSumToArea * length * sum.dropped;
        block.zeroed_area_bound += kSumToArea * length * sum.error;
      } else {
        block.faces.push_back({i, edge.other, edge.region, area, length});
      }
    }
  }

  /// Concatenates the blocks.
  void assemble(const std::vector<BlockResult>& blocks, ControlVolumes<D>& out) const {
    std::vector<std::size_t> first_face(blocks.size() + 1, 0), first_cell(blocks.size() + 1, 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      first_face[b + 1] = first_face[b] + blocks[b].faces.size();
      first_cell[b + 1] = first_cell[b] + blocks[b].cells.size();
      out.n_zero_areas += blocks[b].n_zero_areas;
      out.zeroed_area += blocks[b].zeroed_area;
      out.zeroed_area_bound += blocks[b].zeroed_area_bound;
    }
    check_id_range(first_face.back());
    out.face_vertices.resize(first_face.back());
    out.face_region.resize(first_face.back());
    out.face_area.resize(first_face.back());
    out.face_edge_length.resize(first_face.back());
    out.cell_vertex.resize(first_cell.back());
    out.cell_region.resize(first_cell.back());
    out.cell_volume.resize(first_cell.back());
    parallel_for(
        blocks.size(),
        [&](std::size_t b) {
          DualFaceId f(first_face[b]);
          for (const BlockResult::Face& face : blocks[b].faces) {
            out.face_vertices[f] = {face.i, face.j};
            out.face_region[f] = face.region;
            out.face_area[f] = face.area;
            out.face_edge_length[f] = face.edge_length;
            ++f;
          }
          CellId c(first_cell[b]);
          for (const BlockResult::Cell& cell : blocks[b].cells) {
            out.cell_vertex[c] = cell.vertex;
            out.cell_region[c] = cell.region;
            ++c;
          }
        },
        1);
  }

  static void check_id_range(std::size_t n_faces) {
    if (n_faces < DualFaceId::none().value()) return;
    throw LimitError(Fault{.id = "dual.too_many_faces",
                           .message = std::to_string(n_faces) + " dual faces exceed 32-bit ids",
                           .fix = "mesh the domain in parts"});
  }

  /// |V_i| = 1/(2D) sum_j A_ij h_ij, region by region: every plane that clips a cell passes through its site.
  void add_volumes(ControlVolumes<D>& out) const {
    IdVector<VertexId, CellId> first_cell(mesh_.points.size());
    for (std::size_t c = out.cell_vertex.size(); c-- > 0;) first_cell[out.cell_vertex[CellId(c)]] = CellId(c);
    const auto cell = [&](VertexId v, int region) {
      CellId c = first_cell[v];
      while (out.cell_region[c] != region) ++c;
      return c;
    };
    for (const DualFaceId f : ids(out.face_area)) {
      const double share = out.face_area[f] * out.face_edge_length[f] / (2.0 * D);
      for (const VertexId v : out.face_vertices[f]) out.cell_volume[cell(v, out.face_region[f])] += share;
    }
  }

  const Mesh<D>& mesh_;
  Observer& observer_;
};

}  // namespace

template <int D>
ControlVolumes<D> build_control_volumes(const Mesh<D>& mesh, Observer& observer) {
  observer.begin_stage("dual");
  ControlVolumes<D> volumes = DualBuilder<D>(mesh, observer).build();
  observer.progress(3, 3);
  return volumes;
}

template ControlVolumes<2> build_control_volumes(const Mesh<2>&, Observer&);
template ControlVolumes<3> build_control_volumes(const Mesh<3>&, Observer&);

}  // namespace voropack
