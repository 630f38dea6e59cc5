#include "geom/vertex_inserter.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string>

#include "voropack/error.h"

namespace voropack {

namespace {

/// Cavities with up to this many vertices are linked by a table of edges.
constexpr std::size_t kTableVertices = 128;

/// Even permutations that move corner i of a tetrahedron to the end, and keep corner 0 where it is unless i == 0.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kMoveToEnd = {
    {{2, 1, 3, 0}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 1, 2, 3}}};

/// Lexicographic order.
template <int K>
bool before(const Vec<K>& a, const Vec<K>& b) {
  for (int k = 0; k < K; ++k)
    if (a[k] != b[k]) return a[k] < b[k];
  return false;
}

}  // namespace

// ---------------------------------------------------------------------------------------------------- territory

/// Whether the simplex may be changed. Only corner 0 can be infinite.
template <int K, class Territory>
inline bool VertexInserter<K, Territory>::owns([[maybe_unused]] const Simplex& s) const {
  if constexpr (kWhole) {
    return true;
  } else {
    const auto is_own = [this](std::uint32_t v) { return territory_.part[v] == territory_.own; };
    bool all = s.corner[0] == kInfinite || is_own(s.corner[0]);
    for (std::size_t i = 1; i <= K; ++i) all = all & is_own(s.corner[i]);
    return all;
  }
}

/// vertex_slot of the vertex. That of the infinite vertex, which all parts have, is only used while a cavity is filled.
template <int K, class Territory>
inline std::uint32_t& VertexInserter<K, Territory>::slot_entry(std::uint32_t vertex) {
  return !kWhole && vertex == kInfinite ? s_.infinite_entry : a_.vertex_slot[vertex];
}

// ---------------------------------------------------------------------------------------------------- predicates

/// The orientation of `s` with p in place of a corner; all other corners must be finite.
template <int K, class Territory>
int VertexInserter<K, Territory>::orientation_with(const Simplex& s, int corner, const Vec<K>& p) const {
  std::array<const Vec<K>*, K + 1> q{};
  for (std::size_t i = 0; i <= K; ++i) q[i] = &a_.points[s.corner[i]];
  q[static_cast<std::size_t>(corner)] = &p;
  if constexpr (K == 2) return a_.predicates.orientation(*q[0], *q[1], *q[2]);
  if constexpr (K == 3) return a_.predicates.orientation(*q[0], *q[1], *q[2], *q[3]);
}

template <int K, class Territory>
[[gnu::always_inline]] inline int VertexInserter<K, Territory>::in_circumball(const Simplex& s, const Vec<K>& p) const {
  const Vec<K>* const q = a_.points.data();
  if constexpr (K == 2) return a_.predicates.in_circumball(q[s.corner[0]], q[s.corner[1]], q[s.corner[2]], p);
  if constexpr (K == 3)
    return a_.predicates.in_circumball(q[s.corner[0]], q[s.corner[1]], q[s.corner[2]], q[s.corner[3]], p);
}

/// For p on the circumsphere of `s`: whether it is inside once every point is lifted by a perturbation that is the
/// larger, by orders, the later the point comes lexicographically [Devillers, Teillaud, Perturbations and vertex
/// removal in a 3D Delaunay triangulation, SODA 2003]. The same as CGAL's side_of_oriented_sphere(..., perturb).
template <int K, class Territory>
bool VertexInserter<K, Territory>::in_perturbed_circumball(const Simplex& s, const Vec<K>& p) const {
  const auto point = [&](int i) -> const Vec<K>& { return a_.points[s.corner[static_cast<std::size_t>(i)]]; };
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
template <int K, class Territory>
[[gnu::always_inline]] inline bool VertexInserter<K, Territory>::in_conflict(const Simplex& s, const Vec<K>& p) const {
  const Simplex* finite = &s;
  if (s.corner[0] == kInfinite) [[unlikely]] {
    if (const int o = orientation_with(s, 0, p); o != 0) return o > 0;
    finite = &a_.simplices[s.neighbor[0] >> kFaceBits];
  }
  const int side = in_circumball(*finite, p);
  if (side != 0) [[likely]]
    return side > 0;
  return in_perturbed_circumball(*finite, p);
}

// -------------------------------------------------------------------------------------------------- one insertion

/// A simplex in conflict with p: the one that holds p, or a face of the hull that p is strictly beyond. By a visibility
/// walk, which cannot run in a circle in a Delaunay triangulation. kEmpty if the walk leaves the territory.
template <int K, class Territory>
typename VertexInserter<K, Territory>::Slot VertexInserter<K, Territory>::locate(const Vec<K>& p, Slot start) const {
  Slot slot = start;
  if (!owns(a_.simplices[slot])) return kEmpty;
  if (a_.simplices[slot].corner[0] == kInfinite) slot = a_.simplices[slot].neighbor[0] >> kFaceBits;
  int entered_by = -1;
  for (;;) {
    const Simplex& s = a_.simplices[slot];
    if (!owns(s)) return kEmpty;
    if (s.corner[0] == kInfinite) return slot;
    int out = 0;
    while (out <= K && (out == entered_by || orientation_with(s, out, p) >= 0)) ++out;
    if (out > K) return slot;
    const std::uint32_t next = s.neighbor[static_cast<std::size_t>(out)];
    slot = next >> kFaceBits;
    entered_by = static_cast<int>(next & Arrays::kFaceMask);
  }
}

/// A corner of the simplex that holds the new vertex which is the same point, or kInfinite.
template <int K, class Territory>
std::uint32_t VertexInserter<K, Territory>::find_equal(std::uint32_t vertex, Slot slot) const {
  for (const std::uint32_t v : a_.simplices[slot].corner)
    if (v != kInfinite && a_.points[v] == a_.points[vertex]) return v;
  return kInfinite;
}

template <int K, class Territory>
void VertexInserter<K, Territory>::throw_duplicate(std::uint32_t a, std::uint32_t b) const {
  const Vec<K>& p = a_.points[a];
  const auto [first, second] = std::minmax(a_.vertex[a], a_.vertex[b]);
  throw InputError(Fault{.id = "delaunay.duplicate_points",
                         .message = fmt::format("points {} and {} (counted from 0) are identical: ({})", first, second,
                                                fmt::join(p.coord, ", ")),
                         .fix = "remove one of the two points",
                         .position = {p.coord.begin(), p.coord.end()}});
}

/// in_conflict, for simplices that are not in the territory: rare, so kept out of the loop of find_cavity.
template <int K, class Territory>
[[gnu::noinline]] bool VertexInserter<K, Territory>::in_conflict_beyond(const Simplex& s, const Vec<K>& p) const {
  return in_conflict(s, p);
}

/// Asks for the memory that `find_cavity` will read when it comes to a slot.
template <int K, class Territory>
inline void VertexInserter<K, Territory>::prefetch_neighbors(Slot slot) const {
  for (const std::uint32_t code : a_.simplices[slot].neighbor) {
    __builtin_prefetch(&a_.state[code >> kFaceBits], 1);
    __builtin_prefetch(&a_.simplices[code >> kFaceBits]);
  }
}

/// Collects the simplices in conflict with p, from one of them, and the faces between them and the others. False if one
/// of them is not in the territory.
///
/// Nothing branches on the outcome of a test, which no processor can predict: it is added to the lengths of the lists.
/// So the arithmetic of several tests overlaps.
template <int K, class Territory>
bool VertexInserter<K, Territory>::find_cavity(const Vec<K> p, Slot start) {
  const std::uint32_t round = s_.round;
  std::size_t n_conflicts = 1, n_faces = 0;
  bool inside = true;
  const Simplex* const simplices = a_.simplices.data();
  std::uint32_t* const states = a_.state.data();
  s_.conflict[0] = start << kFaceBits;
  states[start] = round << Arrays::kRoundShift | Arrays::kConflictBit | (states[start] & Arrays::kCreatedBit);
  const auto visit = [&](Slot slot, std::uint32_t face) __attribute__((always_inline)) {
    const std::uint32_t beyond = simplices[slot].neighbor[face];
    const Simplex& s = simplices[beyond >> kFaceBits];
    std::uint32_t& state = states[beyond >> kFaceBits];
    std::uint32_t hit = state & Arrays::kConflictBit;
    if (state >> Arrays::kRoundShift != round) {
      if (owns(s)) [[likely]] {
        hit = in_conflict(s, p) ? Arrays::kConflictBit : 0;
        state = round << Arrays::kRoundShift | hit | (state & Arrays::kCreatedBit);
        s_.conflict[n_conflicts] = beyond;
        n_conflicts += hit / Arrays::kConflictBit;
      } else {
        // Not marked as visited: its mark is not ours either.
        hit = 0;
        inside = inside && !in_conflict_beyond(s, p);
      }
    }
    s_.faces[n_faces] = {slot << kFaceBits | face, beyond};
    n_faces += 1 - hit / Arrays::kConflictBit;
  };
  visit(start, 0);
  for (std::size_t next = 0; next < n_conflicts && inside; ++next) {
    // The face by which the simplex was entered has been seen; the first one begins as if entered by face 0.
    const Slot slot = s_.conflict[next] >> kFaceBits;
    std::uint32_t face = s_.conflict[next] & Arrays::kFaceMask;
    prefetch_neighbors(s_.conflict[std::min(next + 2, n_conflicts - 1)] >> kFaceBits);
    for (int i = 0; i < K; ++i) {
      face = face == K ? 0 : face + 1;
      visit(slot, face);
    }
    if (n_conflicts + 2 * K > s_.conflict.size()) s_.conflict.resize(2 * s_.conflict.size());
    if (n_faces + 2 * K > s_.faces.size()) s_.faces.resize(2 * s_.faces.size());
  }
  s_.n_conflicts = n_conflicts;
  s_.n_faces = n_faces;
  return inside;
}

/// In a part of the triangulation there must be a free one.
template <int K, class Territory>
typename VertexInserter<K, Territory>::Slot VertexInserter<K, Territory>::new_slot() {
  if (!kWhole || s_.free_slots.size() > 0) return s_.free_slots.take();
  if (a_.simplices.size() == Arrays::kMaxSlots)
    throw LimitError(
        Fault{.id = "delaunay.too_many_simplices",
              .message = fmt::format("more than 2^30 simplices while inserting {} points", a_.points.size() - 1),
              .fix = "triangulate fewer points at once"});
  a_.simplices.emplace_back();
  a_.state.push_back(0);
  return static_cast<Slot>(a_.simplices.size() - 1);
}

/// Lists the new simplices: each face of the cavity joined to the new vertex. They take the slots of the cavity and,
/// where these do not suffice, others.
template <int K, class Territory>
void VertexInserter<K, Territory>::list_new_simplices(std::uint32_t vertex) {
  if (s_.created.size() < s_.n_faces) s_.created.resize(2 * s_.n_faces);
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const auto [inside, outside] = s_.faces[f];
    const Corners& c = a_.simplices[inside >> kFaceBits].corner;
    const std::uint32_t i = inside & Arrays::kFaceMask;
    NewSimplex& n = s_.created[f];
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
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const Slot slot = f < s_.n_conflicts ? s_.conflict[f] >> kFaceBits : new_slot();
    s_.created[f].slot = slot;
    if (slot < a_.first_new_slot && (a_.state[slot] & Arrays::kCreatedBit) == 0) {
      a_.state[slot] |= Arrays::kCreatedBit;
      s_.recreated.push_back(slot);
    }
  }
  for (std::size_t f = s_.n_faces; f < s_.n_conflicts; ++f) {
    const Slot slot = s_.conflict[f] >> kFaceBits;
    a_.simplices[slot].corner[0] = kEmpty;
    s_.free_slots.give(slot, slot + 1);
  }
}

/// Writes the new simplices and joins them to their neighbors outside of the cavity.
template <int K, class Territory>
void VertexInserter<K, Territory>::store_new_simplices() {
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const NewSimplex& n = s_.created[f];
    a_.simplices[n.slot].corner = n.corner;
    a_.join(n.slot << kFaceBits | n.apex, n.outside);
  }
}

/// 2D: the cavity's boundary is a polygon, so the triangle after (u, v, vertex) is the one whose edge starts at v.
template <int K, class Territory>
void VertexInserter<K, Territory>::link_triangles() requires(K == 2) {
  const auto edge_start = [](const NewSimplex& n) { return n.corner[(n.apex + 1) % 3]; };
  const auto edge_end = [](const NewSimplex& n) { return n.corner[(n.apex + 2) % 3]; };
  for (std::size_t f = 0; f < s_.n_faces; ++f) slot_entry(edge_start(s_.created[f])) = static_cast<std::uint32_t>(f);
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const NewSimplex& n = s_.created[f];
    const NewSimplex& after = s_.created[slot_entry(edge_end(n))];
    a_.join(n.slot << kFaceBits | (n.apex + 1) % 3, after.slot << kFaceBits | (after.apex + 2) % 3);
  }
  for (std::size_t f = 0; f < s_.n_faces; ++f) slot_entry(edge_start(s_.created[f])) = s_.created[f].slot;
}

/// The boundary of the cavity is a closed surface: each edge occurs once in each direction. All entries that are read
/// were written in the same call, so nothing is ever cleared.
template <int K, class Territory>
void VertexInserter<K, Territory>::link_by_table() requires(K == 3) {
  const auto width = static_cast<unsigned>(std::bit_width(s_.local_vertices.size() - 1));
  if (s_.edge_table.size() < std::size_t{1} << 2 * width) s_.edge_table.resize(std::size_t{1} << 2 * width);
  std::uint32_t* const table = s_.edge_table.data();
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const auto& l = s_.created[f].local;
    const std::uint32_t code = s_.created[f].slot << kFaceBits;
    table[l[1] << width | l[2]] = code;
    table[l[2] << width | l[0]] = code | 1U;
    table[l[0] << width | l[1]] = code | 2U;
  }
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    const auto& l = s_.created[f].local;
    Corners& neighbor = a_.simplices[s_.created[f].slot].neighbor;
    neighbor[0] = table[l[2] << width | l[1]];
    neighbor[1] = table[l[0] << width | l[2]];
    neighbor[2] = table[l[1] << width | l[0]];
  }
}

template <int K, class Territory>
void VertexInserter<K, Territory>::link_by_sorting() requires(K == 3) {
  s_.edge_list.clear();
  for (std::size_t f = 0; f < s_.n_faces; ++f)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t u = s_.created[f].local[(i + 1) % 3], v = s_.created[f].local[(i + 2) % 3];
      s_.edge_list.emplace_back(std::uint64_t{std::min(u, v)} << 32U | std::max(u, v),
                                s_.created[f].slot << kFaceBits | i);
    }
  std::sort(s_.edge_list.begin(), s_.edge_list.end());
  for (std::size_t e = 0; e < s_.edge_list.size(); e += 2) a_.join(s_.edge_list[e].second, s_.edge_list[e + 1].second);
}

/// 3D: two new tetrahedra are neighbors if their faces of the cavity share an edge.
template <int K, class Territory>
void VertexInserter<K, Territory>::link_tetrahedra() requires(K == 3) {
  s_.local_vertices.clear();
  for (std::size_t f = 0; f < s_.n_faces; ++f) {
    NewSimplex& n = s_.created[f];
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& entry = slot_entry(n.corner[i]);
      if ((entry & kLocalBit) == 0) {
        entry = kLocalBit | static_cast<std::uint32_t>(s_.local_vertices.size());
        s_.local_vertices.emplace_back(n.corner[i], n.slot);
      }
      n.local[i] = entry & ~kLocalBit;
    }
  }
  if (s_.local_vertices.size() <= kTableVertices)
    link_by_table();
  else
    link_by_sorting();
  for (const auto& [vertex, slot] : s_.local_vertices) slot_entry(vertex) = slot;
}

template <int K, class Territory>
bool VertexInserter<K, Territory>::insert(std::uint32_t vertex, Slot start) {
  ++s_.round;
  const Vec<K>& p = a_.points[vertex];
  const Slot slot = locate(p, start);
  if (slot == kEmpty) return false;
  if (const std::uint32_t equal = find_equal(vertex, slot); equal != kInfinite) {
    if constexpr (kWhole) throw_duplicate(equal, vertex);
    return false;
  }
  if (!find_cavity(p, slot)) return false;
  if (!kWhole && s_.n_faces > s_.n_conflicts + s_.free_slots.size()) return false;
  list_new_simplices(vertex);
  store_new_simplices();
  if constexpr (K == 2)
    link_triangles();
  else
    link_tetrahedra();
  s_.last_slot = s_.created[s_.n_faces - 1].slot;
  a_.vertex_slot[vertex] = s_.last_slot;
  return true;
}

template class VertexInserter<2, WholeTriangulation>;
template class VertexInserter<3, WholeTriangulation>;
template class VertexInserter<2, PartOfTriangulation>;
template class VertexInserter<3, PartOfTriangulation>;

}  // namespace voropack
