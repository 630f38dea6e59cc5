#include "coarsening/editable_triangulation.h"

#include "geom/predicates.h"

namespace voropack {

namespace {

constexpr double kBoxSize = 10;  // Half the width of the box, relative to the diagonal of the points' box.

}  // namespace

EditableTriangulation::EditableTriangulation(std::span<const Vec<2>> points)
    : points_(points), slot_of_(points.size() + 4, kNoSlot) {
  Box<2> box;
  for (const Vec<2>& p : points) box.add(p);
  const Vec<2> c = box.empty() ? Vec<2>{} : box.center();
  const double h = kBoxSize * std::max(box.diagonal(), std::numeric_limits<double>::min());
  box_ = {Vec<2>{c[0] - h, c[1] - h}, Vec<2>{c[0] + h, c[1] - h}, Vec<2>{c[0] + h, c[1] + h},
          Vec<2>{c[0] - h, c[1] + h}};
  const auto n = static_cast<std::uint32_t>(points.size());
  triangles_ = {{{n, n + 1, n + 2}, {kNoSlot, 1, kNoSlot}}, {{n, n + 2, n + 3}, {kNoSlot, kNoSlot, 0}}};
  slot_of_[n] = slot_of_[n + 1] = slot_of_[n + 2] = 0;
  slot_of_[n + 3] = 1;
  mark_.assign(2, 0);
}

EditableTriangulation::Slot EditableTriangulation::left_of(std::uint32_t a, std::uint32_t b) const {
  Slot found = kNoSlot;
  around(a, [&](Slot slot, std::size_t i) {
    if (triangles_[slot].corners[(i + 1) % 3] == b) found = slot;
  });
  return found;
}

EditableTriangulation::Slot EditableTriangulation::locate(const Vec<2>& x, Slot from) const {
  // On a Delaunay triangulation a walk across any edge that x lies beyond ends [Edelsbrunner1990].
  Slot slot = from, before = kNoSlot;
  for (;;) {
    const Triangle& t = triangles_[slot];
    Slot next = kNoSlot;
    for (std::size_t i = 0; i < 3 && next == kNoSlot; ++i) {
      if (t.neighbors[i] == kNoSlot || t.neighbors[i] == before) continue;
      if (orientation(point(t.corners[(i + 1) % 3]), point(t.corners[(i + 2) % 3]), x) < 0) next = t.neighbors[i];
    }
    if (next == kNoSlot) return slot;
    before = slot;
    slot = next;
  }
}

void EditableTriangulation::find_cavity(const Vec<2>& x, Slot start, std::vector<Slot>& cavity) const {
  cavity.assign(1, start);
  mark_[start] = ++stamp_;
  for (std::size_t k = 0; k < cavity.size(); ++k)
    for (const Slot next : triangles_[cavity[k]].neighbors) {
      if (next == kNoSlot || mark_[next] == stamp_) continue;
      const auto& c = triangles_[next].corners;
      if (in_circumball(point(c[0]), point(c[1]), point(c[2]), x) <= 0) continue;
      mark_[next] = stamp_;
      cavity.push_back(next);
    }
}

EditableTriangulation::Slot EditableTriangulation::make(const std::array<std::uint32_t, 3>& corners,
                                                        std::vector<Slot>& created) {
  Slot slot;
  if (free_.empty()) {
    slot = n_slots();
    triangles_.emplace_back();
    mark_.push_back(0);
  } else {
    slot = free_.back();
    free_.pop_back();
  }
  triangles_[slot] = {corners, {kNoSlot, kNoSlot, kNoSlot}};
  for (const std::uint32_t v : corners) slot_of_[v] = slot;
  created.push_back(slot);
  return slot;
}

void EditableTriangulation::empty_slot(Slot slot, std::vector<Slot>& destroyed) {
  triangles_[slot].corners[0] = kEmpty;
  free_.push_back(slot);
  destroyed.push_back(slot);
}

void EditableTriangulation::glue(Slot slot, std::size_t i, Slot other, std::uint32_t from, std::uint32_t to) {
  triangles_[slot].neighbors[i] = other;
  if (other == kNoSlot) return;
  Triangle& t = triangles_[other];
  for (std::size_t k = 0; k < 3; ++k)
    if (t.corners[(k + 1) % 3] == to && t.corners[(k + 2) % 3] == from) t.neighbors[k] = slot;
}

void EditableTriangulation::insert(std::uint32_t vertex, Slot near, std::vector<Slot>& destroyed,
                                   std::vector<Slot>& created) {
  const Vec<2>& x = point(vertex);
  find_cavity(x, locate(x, near), cavity_);
  rim_.clear();
  for (const Slot slot : cavity_) {
    const Triangle& t = triangles_[slot];
    for (std::size_t i = 0; i < 3; ++i)
      if (t.neighbors[i] == kNoSlot || mark_[t.neighbors[i]] != stamp_)
        rim_.push_back({t.corners[(i + 1) % 3], t.corners[(i + 2) % 3], t.neighbors[i]});
  }
  const std::size_t first = created.size();
  for (const Rim& edge : rim_) {
    const Slot slot = make({vertex, edge.from, edge.to}, created);
    glue(slot, 0, edge.outside, edge.from, edge.to);
  }
  // The fan around the new vertex: each triangle begins where another one ends.
  for (std::size_t a = first; a < created.size(); ++a)
    for (std::size_t b = first; b < created.size(); ++b)
      if (triangles_[created[a]].corners[2] == triangles_[created[b]].corners[1]) {
        triangles_[created[a]].neighbors[1] = created[b];
        triangles_[created[b]].neighbors[2] = created[a];
      }
  for (const Slot slot : cavity_) empty_slot(slot, destroyed);
}

bool EditableTriangulation::is_ear(const std::vector<Rim>& rim, std::size_t i) const {
  const Vec<2>&a = point(rim[i].from), &b = point(rim[i].to);
  const std::size_t next = (i + 1) % rim.size();
  const Vec<2>& c = point(rim[next].to);
  if (orientation(a, b, c) <= 0) return false;
  for (std::size_t k = 0; k < rim.size(); ++k)
    if (k != i && k != next && rim[k].to != rim[i].from && in_circumball(a, b, c, point(rim[k].to)) > 0) return false;
  return true;
}

void EditableTriangulation::remove(std::uint32_t vertex, std::vector<Slot>& destroyed, std::vector<Slot>& created) {
  rim_.clear();
  cavity_.clear();
  around(vertex, [&](Slot slot, std::size_t i) {
    const Triangle& t = triangles_[slot];
    rim_.push_back({t.corners[(i + 1) % 3], t.corners[(i + 2) % 3], t.neighbors[i]});
    cavity_.push_back(slot);
  });
  // Ears of the hole whose circumcircle is empty are Delaunay triangles; there is always one.
  while (rim_.size() > 3) {
    std::size_t i = 0;
    while (!is_ear(rim_, i)) ++i;
    const std::size_t next = (i + 1) % rim_.size();
    const Rim first = rim_[i], second = rim_[next];
    const Slot slot = make({first.from, first.to, second.to}, created);
    glue(slot, 2, first.outside, first.from, first.to);
    glue(slot, 0, second.outside, second.from, second.to);
    rim_[i] = {first.from, second.to, slot};
    rim_.erase(rim_.begin() + static_cast<std::ptrdiff_t>(next));
  }
  const Slot slot = make({rim_[0].from, rim_[0].to, rim_[1].to}, created);
  for (std::size_t k = 0; k < 3; ++k) glue(slot, (k + 2) % 3, rim_[k].outside, rim_[k].from, rim_[k].to);
  for (const Slot old : cavity_) empty_slot(old, destroyed);
  slot_of_[vertex] = kNoSlot;
}

}  // namespace voropack
