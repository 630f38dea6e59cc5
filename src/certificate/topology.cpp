#include "certificate/topology.h"

#include <algorithm>
#include <atomic>

#include "base/parallel.h"

namespace voropack::judge {

namespace {

constexpr std::size_t kBlock = 8192;

template <class Array>
Array sorted(Array a) {
  std::sort(a.begin(), a.end());
  return a;
}

template <class Array>
bool all_distinct(const Array& a) {
  for (std::size_t i = 1; i < a.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (a[i] == a[j]) return false;
  return true;
}

}  // namespace

template <int D>
Topology<D>::Topology(const Mesh<D>& mesh, Tally& faults, const Observer& observer) : mesh_(mesh) {
  const std::size_t n = mesh.simplex_vertices.size();
  if (mesh.simplex_region.size() == n) regions_ = &mesh.simplex_region;
  if (n == 0) faults.fault(kNoSimplices, kNoFigure);
  read_vertices();
  read_simplices(faults);
  observer.check_cancelled();
  read_listed();
  neighbors_ = &mesh.simplex_neighbors;
  const bool given = mesh.simplex_neighbors.size() == n;
  if (!given || !check_neighbors(faults)) rebuild_neighbors(faults);
  observer.check_cancelled();
  // Two simplices that share a face without knowing each other: the neighbors were wrong after all.
  if (!match_boundary(faults)) {
    rebuild_neighbors(faults);
    match_boundary(faults);
  }
}

template <int D>
void Topology<D>::read_vertices() {
  vertex_state_.assign(mesh_.points.size(), 0);
  double largest = 0;
  for (std::size_t v = 0; v < vertex_state_.size(); ++v) {
    const Vec<D>& p = mesh_.points[VertexId(v)];
    if (!is_finite(p)) continue;
    vertex_state_[v] = kFinite;
    box_.add(p);
    for (int k = 0; k < D; ++k) largest = std::max(largest, std::abs(p[k]));
  }
  resolution_ = 16 * std::numeric_limits<double>::epsilon() * largest;
}

template <int D>
void Topology<D>::read_simplices(Tally& faults) {
  const std::size_t n = mesh_.simplex_vertices.size();
  state_.assign(n, 0);
  // Atomic also to read: other threads mark vertices as used meanwhile.
  const auto flags_of = [&](VertexId v) { return std::atomic_ref<std::uint8_t>(vertex_state_[v.value()]); };
  faults += parallel_reduce_ordered(
      n, kBlock, Tally{},
      [&](std::size_t begin, std::size_t end) {
        Tally tally;
        for (std::size_t s = begin; s < end; ++s) {
          const auto& v = mesh_.simplex_vertices[SimplexId(s)];
          bool good = true;
          for (const VertexId corner : v) {
            if (corner.is_none() || corner.value() >= vertex_state_.size() ||
                (flags_of(corner).load(std::memory_order_relaxed) & kFinite) == 0) {
              tally.fault(kInvalidCorner, kNoFigure, static_cast<std::uint32_t>(s));
              good = false;
              break;
            }
          }
          if (good && !all_distinct(v)) {
            tally.fault(kRepeatedCorner, kNoFigure, static_cast<std::uint32_t>(s));
            good = false;
          }
          if (!good) {
            state_[s] = kInvalid;
            continue;
          }
          for (const VertexId corner : v) {
            const auto flags = flags_of(corner);
            if ((flags.load(std::memory_order_relaxed) & kUsed) == 0) flags.fetch_or(kUsed, std::memory_order_relaxed);
          }
        }
        return tally;
      },
      [](Tally a, const Tally& b) { return a += b; });
}

template <int D>
void Topology<D>::read_listed() {
  n_listed_ = mesh_.boundary_vertices.size();
  const bool marked = mesh_.boundary_marker.size() == n_listed_;
  boundary_.resize(n_listed_);
  for (std::size_t b = 0; b < n_listed_; ++b) {
    BoundaryFace<D>& face = boundary_[b];
    face.listed = true;
    face.marker = marked ? mesh_.boundary_marker[BoundaryId(b)] : 0;
    for (std::size_t i = 0; i < D; ++i) {
      const VertexId v = mesh_.boundary_vertices[BoundaryId(b)][i];
      face.vertices[i] = v.value();
      if (v.is_none() || v.value() >= vertex_state_.size() || !finite(v.value())) face.valid = false;
    }
    face.valid = face.valid && all_distinct(face.vertices);
    if (!face.valid) continue;
    for (const std::uint32_t v : face.vertices) vertex_state_[v] |= kListed;
  }
}

template <int D>
std::array<std::uint32_t, D> Topology<D>::face_key(std::size_t s, int corner) const {
  std::array<std::uint32_t, D> key;
  std::size_t k = 0;
  const auto& v = mesh_.simplex_vertices[SimplexId(s)];
  for (int i = 0; i <= D; ++i)
    if (i != corner) key[k++] = v[static_cast<std::size_t>(i)].value();
  std::sort(key.begin(), key.end());
  return key;
}

template <int D>
void Topology<D>::check_simplex_neighbors(std::size_t s, Tally& tally) const {
  const auto& v = mesh_.simplex_vertices[SimplexId(s)];
  const auto& around = (*neighbors_)[SimplexId(s)];
  for (std::size_t i = 0; i <= D; ++i) {
    if (around[i].is_none()) continue;
    const std::uint32_t n = around[i].value();
    bool good = n < state_.size() && n != s && valid(n);
    for (std::size_t j = 0; good && j < i; ++j) good = around[j] != around[i];
    const int back = good ? corner_towards(n, s) : -1;
    good = back >= 0;
    // Once per pair is enough, because the neighbors of a simplex are distinct.
    if (good && s < n) {
      // The face of n opposite to corner `back` has D distinct corners; each must be a corner of s other than i.
      const auto& w = mesh_.simplex_vertices[SimplexId(n)];
      for (std::size_t j = 0; good && j <= D; ++j) {
        if (static_cast<int>(j) == back) continue;
        bool found = false;
        for (std::size_t k = 0; k <= D; ++k) found = found || (k != i && v[k] == w[j]);
        good = found;
      }
    }
    if (!good) tally.fault(kWrongNeighbor, kNoFigure, static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(i));
  }
}

template <int D>
bool Topology<D>::check_neighbors(Tally& faults) const {
  const Tally tally = parallel_reduce_ordered(
      state_.size(), kBlock, Tally{},
      [&](std::size_t begin, std::size_t end) {
        Tally block;
        for (std::size_t s = begin; s < end; ++s)
          if (valid(s)) check_simplex_neighbors(s, block);
        return block;
      },
      [](Tally a, const Tally& b) { return a += b; });
  faults += tally;
  return tally.violations == 0;
}

template <int D>
void Topology<D>::rebuild_neighbors(Tally& faults) {
  std::vector<FaceRef> refs;
  for (std::size_t s = 0; s < state_.size(); ++s)
    for (int i = 0; valid(s) && i <= D; ++i)
      refs.push_back({face_key(s, i), static_cast<std::uint32_t>(s), static_cast<std::uint8_t>(i)});
  parallel_sort(refs.begin(), refs.end());
  std::array<SimplexId, D + 1> nobody;
  nobody.fill(SimplexId::none());
  own_neighbors_ = Neighbors(state_.size(), nobody);
  for (std::size_t i = 0; i < refs.size();) {
    std::size_t j = i + 1;
    while (j < refs.size() && refs[j].key == refs[i].key) ++j;
    if (j - i >= 2) {
      own_neighbors_[SimplexId(refs[i].simplex)][refs[i].corner] = SimplexId(refs[i + 1].simplex);
      own_neighbors_[SimplexId(refs[i + 1].simplex)][refs[i + 1].corner] = SimplexId(refs[i].simplex);
    }
    for (std::size_t k = i + 2; k < j; ++k) faults.fault(kSharedFace, kNoFigure, refs[i].simplex, refs[k].simplex);
    i = j;
  }
  neighbors_ = &own_neighbors_;
}

template <int D>
std::vector<typename Topology<D>::FaceRef> Topology<D>::boundary_candidates() const {
  const std::size_t n_blocks = (state_.size() + kBlock - 1) / kBlock;
  std::vector<std::vector<FaceRef>> found(n_blocks);
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        for (std::size_t s = block * kBlock; s < std::min(state_.size(), (block + 1) * kBlock); ++s) {
          if (!valid(s)) continue;
          const auto& v = mesh_.simplex_vertices[SimplexId(s)];
          int n_inside = 0;
          int inside = -1;
          for (int i = 0; i <= D; ++i) {
            if ((vertex_state_[v[static_cast<std::size_t>(i)].value()] & kListed) != 0) continue;
            ++n_inside;
            inside = i;
          }
          for (int i = 0; i <= D; ++i) {
            const std::uint32_t n = neighbor(s, i);
            const bool may_be_listed = n_inside == 0 || (n_inside == 1 && inside == i);
            if (may_be_listed || n == kNone || region(n) != region(s))
              found[block].push_back({face_key(s, i), static_cast<std::uint32_t>(s), static_cast<std::uint8_t>(i)});
          }
        }
      },
      1);
  std::vector<FaceRef> refs;
  for (const auto& block : found) refs.insert(refs.end(), block.begin(), block.end());
  parallel_sort(refs.begin(), refs.end());
  return refs;
}

template <int D>
bool Topology<D>::linked(const FaceRef& a, const FaceRef& b) const {
  return neighbor(a.simplex, a.corner) == b.simplex && neighbor(b.simplex, b.corner) == a.simplex;
}

template <int D>
bool Topology<D>::match_boundary(Tally& faults) {
  for (std::uint8_t& state : state_) state &= kInvalid;
  boundary_.resize(n_listed_);
  std::vector<std::pair<std::array<std::uint32_t, D>, std::uint32_t>> listed;
  for (std::size_t b = 0; b < n_listed_; ++b) {
    boundary_[b].simplex = {kNone, kNone};
    if (boundary_[b].valid) listed.emplace_back(sorted(boundary_[b].vertices), static_cast<std::uint32_t>(b));
  }
  std::sort(listed.begin(), listed.end());
  for (std::size_t k = 1; k < listed.size(); ++k)
    if (listed[k].first == listed[k - 1].first) boundary_[listed[k].second].repeated = true;

  bool consistent = true;
  const std::vector<FaceRef> refs = boundary_candidates();
  std::size_t next = 0;
  for (std::size_t i = 0; i < refs.size();) {
    std::size_t j = i + 1;
    while (j < refs.size() && refs[j].key == refs[i].key) ++j;
    for (std::size_t k = i + 1; k < j; ++k) {
      if (j - i == 2 && linked(refs[i], refs[k])) continue;
      if (neighbors_ == &own_neighbors_) continue;  // Reported by rebuild_neighbors.
      consistent = false;
      faults.fault(kSharedFace, kNoFigure, refs[i].simplex, refs[k].simplex);
    }
    while (next < listed.size() && listed[next].first < refs[i].key) ++next;
    const bool is_listed = next < listed.size() && listed[next].first == refs[i].key;
    const std::uint32_t n = neighbor(refs[i].simplex, refs[i].corner);
    if (is_listed || n == kNone || region(n) != region(refs[i].simplex)) {
      if (!is_listed) boundary_.push_back({.vertices = refs[i].key});
      BoundaryFace<D>& face = is_listed ? boundary_[listed[next].second] : boundary_.back();
      for (std::size_t k = i; k < std::min(j, i + 2); ++k) {
        face.simplex[k - i] = refs[k].simplex;
        face.corner[k - i] = refs[k].corner;
      }
      for (std::size_t k = i; k < j; ++k) state_[refs[k].simplex] |= static_cast<std::uint8_t>(1U << refs[k].corner);
    }
    i = j;
  }
  return consistent;
}

template class Topology<2>;
template class Topology<3>;

}  // namespace voropack::judge
