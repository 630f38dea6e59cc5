#include "geom/bowyer_watson.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <string>

#include "geom/hilbert.h"
#include "geom/predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Batches with hints up to this size are inserted as they come.
constexpr std::size_t kSmallBatch = 64;

/// Cavities with up to this many vertices are linked by a table of edges.
constexpr std::size_t kTableVertices = 128;

/// Even permutations that move corner i of a tetrahedron to the end, and keep corner 0 where it is unless i == 0.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kMoveToEnd = {
    {{2, 1, 3, 0}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 1, 2, 3}}};

template <int K>
std::vector<double> position(const Vec<K>& p) {
  return {p.coord.begin(), p.coord.end()};
}

template <int K>
std::string text(const Vec<K>& p) {
  return fmt::format("({})", fmt::join(p.coord, ", "));
}

/// Lexicographic order.
template <int K>
bool before(const Vec<K>& a, const Vec<K>& b) {
  for (int k = 0; k < K; ++k)
    if (a[k] != b[k]) return a[k] < b[k];
  return false;
}

/// True if a, b, c lie on a line, which is so if all their projections to coordinate planes do.
bool collinear(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    if (orientation(Vec<2>{a[k], a[l]}, Vec<2>{b[k], b[l]}, Vec<2>{c[k], c[l]}) != 0) return false;
  }
  return true;
}

}  // namespace

// ---------------------------------------------------------------------------------------------------- predicates

/// The orientation of `s` with p in place of a corner; all other corners must be finite.
template <int K>
int BowyerWatson<K>::orientation_with(const Simplex& s, int corner, const Vec<K>& p) const {
  std::array<const Vec<K>*, K + 1> q{};
  for (std::size_t i = 0; i <= K; ++i) q[i] = &points_[s.corner[i]];
  q[static_cast<std::size_t>(corner)] = &p;
  if constexpr (K == 2) return predicates_.orientation(*q[0], *q[1], *q[2]);
  if constexpr (K == 3) return predicates_.orientation(*q[0], *q[1], *q[2], *q[3]);
}

template <int K>
inline int BowyerWatson<K>::in_circumball(const Simplex& s, const Vec<K>& p) const {
  const Vec<K>* const q = points_.data();
  if constexpr (K == 2) return predicates_.in_circumball(q[s.corner[0]], q[s.corner[1]], q[s.corner[2]], p);
  if constexpr (K == 3)
    return predicates_.in_circumball(q[s.corner[0]], q[s.corner[1]], q[s.corner[2]], q[s.corner[3]], p);
}

/// For p on the circumsphere of `s`: whether it is inside once every point is lifted by a perturbation that is the
/// larger, by orders, the later the point comes lexicographically [Devillers, Teillaud, Perturbations and vertex
/// removal in a 3D Delaunay triangulation, SODA 2003]. The same as CGAL's side_of_oriented_sphere(..., perturb).
template <int K>
bool BowyerWatson<K>::in_perturbed_circumball(const Simplex& s, const Vec<K>& p) const {
  const auto point = [&](int i) -> const Vec<K>& { return points_[s.corner[static_cast<std::size_t>(i)]]; };
  int previous = -1;
  for (;;) {
    int latest = -1;
    for (int i = 0; i <= K; ++i) {
      if (i == previous || (previous >= 0 && !before(point(i), point(previous)))) continue;
      if (latest < 0 || before(point(latest), point(i))) latest = i;
    }
    if (latest < 0 || before(point(latest), p)) return false;
    if (const int o = orientation_with(s, latest, p); o != 0) return o > 0;
    previous = latest;
  }
}

/// Whether inserting p destroys `s`. A face of the hull is destroyed if p is strictly beyond its hyperplane, or in the
/// hyperplane and in the circumball of the face; the latter holds exactly if it is in the circumball of the finite
/// simplex at the face, perturbed or not.
template <int K>
inline bool BowyerWatson<K>::in_conflict(const Simplex& s, const Vec<K>& p) const {
  const Simplex* finite = &s;
  if (s.corner[0] == kInfinite) [[unlikely]] {
    if (const int o = orientation_with(s, 0, p); o != 0) return o > 0;
    finite = &simplices_[s.neighbor[0] >> kFaceBits];
  }
  const int side = in_circumball(*finite, p);
  if (side != 0) [[likely]]
    return side > 0;
  return in_perturbed_circumball(*finite, p);
}

// -------------------------------------------------------------------------------------------------- one insertion

/// A simplex in conflict with p: the one that holds p, or a face of the hull that p is strictly beyond. By a visibility
/// walk, which cannot run in a circle in a Delaunay triangulation.
template <int K>
typename BowyerWatson<K>::Slot BowyerWatson<K>::locate(const Vec<K>& p, Slot start) const {
  Slot slot = start;
  if (simplices_[slot].corner[0] == kInfinite) slot = simplices_[slot].neighbor[0] >> kFaceBits;
  int entered_by = -1;
  for (;;) {
    const Simplex& s = simplices_[slot];
    int out = 0;
    while (out <= K && (out == entered_by || orientation_with(s, out, p) >= 0)) ++out;
    if (out > K) return slot;
    const std::uint32_t next = s.neighbor[static_cast<std::size_t>(out)];
    slot = next >> kFaceBits;
    entered_by = static_cast<int>(next & kFaceMask);
    if (simplices_[slot].corner[0] == kInfinite) return slot;
  }
}

/// Throws if a corner of the simplex that holds the new vertex is the same point.
template <int K>
void BowyerWatson<K>::check_new(std::uint32_t vertex, Slot slot) const {
  const Vec<K>& p = points_[vertex];
  for (const std::uint32_t v : simplices_[slot].corner) {
    if (v == kInfinite || points_[v] != p) continue;
    const auto [first, second] = std::minmax(vertex_[v], vertex_[vertex]);
    throw InputError(Fault{
        .id = "delaunay.duplicate_points",
        .message = "points " + std::to_string(first) + " and " + std::to_string(second) + " are identical: " + text(p),
        .fix = "remove one of the two points",
        .position = position(p)});
  }
}

/// Asks for the memory that `find_cavity` will read when it comes to a slot.
template <int K>
inline void BowyerWatson<K>::prefetch_neighbors(Slot slot) const {
  for (const std::uint32_t code : simplices_[slot].neighbor) {
    __builtin_prefetch(&state_[code >> kFaceBits], 1);
    __builtin_prefetch(&simplices_[code >> kFaceBits]);
  }
}

/// Collects the simplices in conflict with p, from one of them, and the faces between them and the others.
///
/// Nothing branches on the outcome of a test, which no processor can predict: it is added to the lengths of the lists.
/// So the arithmetic of several tests overlaps.
template <int K>
void BowyerWatson<K>::find_cavity(const Vec<K> p, Slot start) {
  const std::uint32_t round = round_;
  std::size_t n_conflicts = 1, n_faces = 0;
  conflict_[0] = start << kFaceBits;
  state_[start] = round << kRoundShift | kConflictBit | (state_[start] & kCreatedBit);
  const auto visit = [&](Slot slot, std::uint32_t face) {
    const std::uint32_t beyond = simplices_[slot].neighbor[face];
    std::uint32_t& state = state_[beyond >> kFaceBits];
    std::uint32_t hit = state & kConflictBit;
    if (state >> kRoundShift != round) {
      hit = in_conflict(simplices_[beyond >> kFaceBits], p) ? kConflictBit : 0;
      state = round << kRoundShift | hit | (state & kCreatedBit);
      conflict_[n_conflicts] = beyond;
      n_conflicts += hit / kConflictBit;
    }
    faces_[n_faces] = {slot << kFaceBits | face, beyond};
    n_faces += 1 - hit / kConflictBit;
  };
  visit(start, 0);
  for (std::size_t next = 0; next < n_conflicts; ++next) {
    // The face by which the simplex was entered has been seen; the first one begins as if entered by face 0.
    const Slot slot = conflict_[next] >> kFaceBits;
    std::uint32_t face = conflict_[next] & kFaceMask;
    prefetch_neighbors(conflict_[next + 2] >> kFaceBits);
    for (int i = 0; i < K; ++i) {
      face = face == K ? 0 : face + 1;
      visit(slot, face);
    }
    if (n_conflicts + 2 * K > conflict_.size()) conflict_.resize(2 * conflict_.size());
    if (n_faces + 2 * K > faces_.size()) faces_.resize(2 * faces_.size());
  }
  n_conflicts_ = n_conflicts;
  n_faces_ = n_faces;
}

template <int K>
typename BowyerWatson<K>::Slot BowyerWatson<K>::new_slot() {
  if (!free_slots_.empty()) {
    const Slot slot = free_slots_.back();
    free_slots_.pop_back();
    return slot;
  }
  if (simplices_.size() == kMaxSlots)
    throw LimitError(Fault{.id = "delaunay.too_many_simplices",
                           .message = "more than 2^30 simplices after " + std::to_string(round_) + " insertions",
                           .fix = "triangulate fewer points at once"});
  simplices_.emplace_back();
  state_.push_back(0);
  return static_cast<Slot>(simplices_.size() - 1);
}

/// Lists the new simplices: each face of the cavity joined to the new vertex. They take the slots of the cavity and,
/// where these do not suffice, others.
template <int K>
void BowyerWatson<K>::list_new_simplices(std::uint32_t vertex) {
  if (new_.size() < n_faces_) new_.resize(2 * n_faces_);
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const auto [inside, outside] = faces_[f];
    const Corners& c = simplices_[inside >> kFaceBits].corner;
    const std::uint32_t i = inside & kFaceMask;
    NewSimplex& n = new_[f];
    n.outside = outside;
    n.apex = K == 2 ? i : 3;
    if constexpr (K == 2) {
      n.corner = c;
      n.corner[i] = vertex;
    } else {
      const auto& at = kMoveToEnd[i];
      n.corner = {c[at[0]], c[at[1]], c[at[2]], vertex};
    }
  }
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const Slot slot = f < n_conflicts_ ? conflict_[f] >> kFaceBits : new_slot();
    new_[f].slot = slot;
    if (slot < first_new_slot_ && (state_[slot] & kCreatedBit) == 0) {
      state_[slot] |= kCreatedBit;
      recreated_.push_back(slot);
    }
  }
  for (std::size_t f = n_faces_; f < n_conflicts_; ++f) {
    const Slot slot = conflict_[f] >> kFaceBits;
    simplices_[slot].corner[0] = kEmpty;
    free_slots_.push_back(slot);
  }
}

/// Writes the new simplices and joins them to their neighbors outside of the cavity.
template <int K>
void BowyerWatson<K>::store_new_simplices() {
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const NewSimplex& n = new_[f];
    simplices_[n.slot].corner = n.corner;
    join(n.slot << kFaceBits | n.apex, n.outside);
  }
}

template <int K>
inline void BowyerWatson<K>::join(std::uint32_t code_a, std::uint32_t code_b) {
  simplices_[code_a >> kFaceBits].neighbor[code_a & kFaceMask] = code_b;
  simplices_[code_b >> kFaceBits].neighbor[code_b & kFaceMask] = code_a;
}

/// 2D: the cavity's boundary is a polygon, so the triangle after (u, v, vertex) is the one whose edge starts at v.
template <>
void BowyerWatson<2>::link_new_simplices() {
  const auto edge_start = [](const NewSimplex& n) { return n.corner[(n.apex + 1) % 3]; };
  const auto edge_end = [](const NewSimplex& n) { return n.corner[(n.apex + 2) % 3]; };
  for (std::size_t f = 0; f < n_faces_; ++f) vertex_slot_[edge_start(new_[f])] = static_cast<std::uint32_t>(f);
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const NewSimplex& n = new_[f];
    const NewSimplex& after = new_[vertex_slot_[edge_end(n)]];
    join(n.slot << kFaceBits | (n.apex + 1) % 3, after.slot << kFaceBits | (after.apex + 2) % 3);
  }
  for (std::size_t f = 0; f < n_faces_; ++f) vertex_slot_[edge_start(new_[f])] = new_[f].slot;
}

/// The boundary of the cavity is a closed surface: each edge occurs once in each direction. All entries that are read
/// were written in the same call, so nothing is ever cleared.
template <>
void BowyerWatson<3>::link_by_table() {
  const auto width = static_cast<unsigned>(std::bit_width(local_vertices_.size() - 1));
  if (edge_table_.size() < std::size_t{1} << 2 * width) edge_table_.resize(std::size_t{1} << 2 * width);
  std::uint32_t* const table = edge_table_.data();
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const auto& l = new_[f].local;
    const std::uint32_t code = new_[f].slot << kFaceBits;
    table[l[1] << width | l[2]] = code;
    table[l[2] << width | l[0]] = code | 1U;
    table[l[0] << width | l[1]] = code | 2U;
  }
  for (std::size_t f = 0; f < n_faces_; ++f) {
    const auto& l = new_[f].local;
    Corners& neighbor = simplices_[new_[f].slot].neighbor;
    neighbor[0] = table[l[2] << width | l[1]];
    neighbor[1] = table[l[0] << width | l[2]];
    neighbor[2] = table[l[1] << width | l[0]];
  }
}

template <>
void BowyerWatson<3>::link_by_sorting() {
  edge_list_.clear();
  for (std::size_t f = 0; f < n_faces_; ++f)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t u = new_[f].local[(i + 1) % 3], v = new_[f].local[(i + 2) % 3];
      edge_list_.emplace_back(std::uint64_t{std::min(u, v)} << 32U | std::max(u, v), new_[f].slot << kFaceBits | i);
    }
  std::sort(edge_list_.begin(), edge_list_.end());
  for (std::size_t e = 0; e < edge_list_.size(); e += 2) join(edge_list_[e].second, edge_list_[e + 1].second);
}

/// 3D: two new tetrahedra are neighbors if their faces of the cavity share an edge.
template <>
void BowyerWatson<3>::link_new_simplices() {
  local_vertices_.clear();
  for (std::size_t f = 0; f < n_faces_; ++f) {
    NewSimplex& n = new_[f];
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& entry = vertex_slot_[n.corner[i]];
      if ((entry & kLocalBit) == 0) {
        entry = kLocalBit | static_cast<std::uint32_t>(local_vertices_.size());
        local_vertices_.emplace_back(n.corner[i], n.slot);
      }
      n.local[i] = entry & ~kLocalBit;
    }
  }
  if (local_vertices_.size() <= kTableVertices)
    link_by_table();
  else
    link_by_sorting();
  for (const auto& [vertex, slot] : local_vertices_) vertex_slot_[vertex] = slot;
}

template <int K>
void BowyerWatson<K>::insert_vertex(std::uint32_t vertex, Slot start) {
  ++round_;
  const Slot slot = locate(points_[vertex], start);
  check_new(vertex, slot);
  find_cavity(points_[vertex], slot);
  list_new_simplices(vertex);
  store_new_simplices();
  link_new_simplices();
  last_slot_ = new_[n_faces_ - 1].slot;
  vertex_slot_[vertex] = last_slot_;
}

// ---------------------------------------------------------------------------------------------------------- batches

template <int K>
void BowyerWatson<K>::check_finite(std::span<const Vec<K>> points) const {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!voropack::is_finite(points[i]))
      throw InputError(Fault{.id = "delaunay.not_finite",
                             .message = "point " + std::to_string(n_vertices() + i) +
                                        " has a coordinate that is infinite or not a number: " + text(points[i]),
                             .fix = "give finite coordinates",
                             .position = position(points[i])});
}

/// Numbers the points of a batch by their place in `order`.
template <int K>
void BowyerWatson<K>::append_points(std::span<const Vec<K>> points, const std::vector<std::uint32_t>& order) {
  const std::uint32_t first_vertex = n_vertices();
  number_.resize(first_vertex + points.size());
  for (const std::uint32_t i : order) {
    number_[first_vertex + i] = static_cast<std::uint32_t>(points_.size());
    vertex_.push_back(first_vertex + i);
    points_.push_back(points[i]);
    box_.add(points[i]);
  }
  vertex_slot_.resize(points_.size(), kEmpty);
  predicates_.set_box(box_);
}

/// Moves the first K + 1 points of `order` that do not lie in a hyperplane to its front and makes a simplex of them.
template <int K>
void BowyerWatson<K>::make_first_simplex(std::vector<std::uint32_t>& order) {
  const auto point = [&](std::size_t i) -> const Vec<K>& { return points_[1 + order[i]]; };
  // Whether point i is not in the affine hull of points 0 .. n - 1 of the order.
  const auto independent = [&](std::size_t n, std::size_t i) {
    if (n == 1) return point(i) != point(0);
    if constexpr (K == 2) return orientation(point(0), point(1), point(i)) != 0;
    if constexpr (K == 3)
      return n == 2 ? !collinear(point(0), point(1), point(i))
                    : orientation(point(0), point(1), point(2), point(i)) != 0;
  };
  for (std::size_t n = 1; n <= K; ++n) {
    std::size_t i = n;
    while (i < order.size() && !independent(n, i)) ++i;
    if (i >= order.size())
      throw InputError(
          Fault{.id = "delaunay.degenerate",
                .message = "all " + std::to_string(order.size()) + " points lie in one " + (K == 2 ? "line" : "plane"),
                .fix = std::string("add a point outside of this ") + (K == 2 ? "line" : "plane")});
    std::swap(order[n], order[i]);
  }

  // Slot 0 is the simplex, slot 1 + i the face of the hull opposite to its corner i.
  simplices_.assign(K + 2, {});
  state_.assign(K + 2, 0);
  Corners& corner = simplices_[0].corner;
  for (std::size_t i = 0; i <= K; ++i) corner[i] = order[i] + 1;
  if (orientation_with(simplices_[0], 0, points_[corner[0]]) < 0) std::swap(corner[0], corner[1]);
  for (std::size_t i = 0; i <= K; ++i) {
    // A point beyond face i in place of corner i turns the orientation around; one swap turns it back.
    Corners& face = simplices_[1 + i].corner;
    face = corner;
    face[i] = kInfinite;
    if (i == 0)
      std::swap(face[K - 1], face[K]);
    else
      std::swap(face[0], face[i]);
    vertex_slot_[corner[i]] = 0;
  }
  vertex_slot_[kInfinite] = 1;

  // Together they are the boundary of a simplex of dimension K + 1: each lacks one vertex, and any two are neighbors.
  const auto code = [&](Slot slot, Slot lacked_by) {
    const std::uint32_t vertex = lacked_by == 0 ? kInfinite : corner[lacked_by - 1];
    const Corners& c = simplices_[slot].corner;
    return slot << kFaceBits | static_cast<std::uint32_t>(std::find(c.begin(), c.end(), vertex) - c.begin());
  };
  for (Slot a = 0; a < K + 2; ++a)
    for (Slot b = 0; b < a; ++b) join(code(a, b), code(b, a));
  last_slot_ = 0;
}

/// Saves the copies of a growing array, which would be the peak of memory. Points spread evenly in a volume have 6.77
/// tetrahedra per vertex, and 2 triangles in a plane; sets with more let the arrays grow.
template <int K>
void BowyerWatson<K>::reserve_for(std::size_t n_points) {
  const std::size_t expected = (K == 2 ? 2 * n_points : 69 * n_points / 10) + 64;
  simplices_.reserve(expected);
  state_.reserve(expected);
  points_.reserve(n_points + 1);
  vertex_.reserve(n_points + 1);
}

template <int K>
void BowyerWatson<K>::insert(std::span<const Vec<K>> points, std::span<const std::uint32_t> hints) {
  if (points.empty()) return;
  check_finite(points);
  const std::uint32_t first = n_vertices() + 1;
  const bool from_nothing = simplices_.empty();
  std::vector<std::uint32_t> order(points.size());
  if (!hints.empty() && points.size() <= kSmallBatch)
    std::iota(order.begin(), order.end(), 0U);
  else
    order = hilbert_order<K>(points);
  if (from_nothing) reserve_for(points.size());
  append_points(points, order);
  std::vector<std::uint32_t> schedule(points.size());
  if (hints.empty())
    schedule = insertion_rounds(points.size());
  else
    std::iota(schedule.begin(), schedule.end(), 0U);
  std::size_t next = 0;
  if (from_nothing) {
    try {
      make_first_simplex(schedule);
    } catch (const InputError&) {
      *this = BowyerWatson{};
      throw;
    }
    next = K + 1;
  }
  for (; next < schedule.size(); ++next) {
    const std::uint32_t i = schedule[next];
    const std::uint32_t hint = hints.empty() ? kNoHint : hints[order[i]];
    const Slot hinted = hint == kNoHint ? kEmpty : slot_of_vertex(hint);
    insert_vertex(first + i, hinted == kEmpty ? last_slot_ : hinted);
  }
}

template <int K>
std::vector<typename BowyerWatson<K>::Slot> BowyerWatson<K>::take_created() {
  std::vector<Slot> created;
  std::sort(recreated_.begin(), recreated_.end());
  for (const Slot slot : recreated_) {
    state_[slot] &= ~kCreatedBit;
    if (is_alive(slot)) created.push_back(slot);
  }
  recreated_.clear();
  for (; first_new_slot_ < n_slots(); ++first_new_slot_)
    if (is_alive(first_new_slot_)) created.push_back(first_new_slot_);
  return created;
}

template class BowyerWatson<2>;
template class BowyerWatson<3>;

}  // namespace voropack
