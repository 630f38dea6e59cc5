#include "spheres/movable_mesh.h"

#include <algorithm>
#include <map>

#include "geom/kernel.h"
#include "geom/predicates.h"

namespace voropack {

namespace {

/// Steps of a walk to the simplex that holds a point; it begins near.
constexpr int kMostSteps = 200;

int orientation_of(const std::array<Vec<2>, 3>& s) { return orientation(s[0], s[1], s[2]); }
int orientation_of(const std::array<Vec<3>, 4>& s) { return orientation(s[0], s[1], s[2], s[3]); }
bool ball_holds(const std::array<Vec<2>, 3>& s, const Vec<2>& x) { return in_circumball(s[0], s[1], s[2], x) > 0; }
bool ball_holds(const std::array<Vec<3>, 4>& s, const Vec<3>& x) {
  return in_circumball(s[0], s[1], s[2], s[3], x) > 0;
}

template <std::size_t N>
std::array<std::uint32_t, N - 1> face_of(const std::array<std::uint32_t, N>& corner, std::size_t without) {
  std::array<std::uint32_t, N - 1> face;
  for (std::size_t i = 0, k = 0; i < N; ++i)
    if (i != without) face[k++] = corner[i];
  std::sort(face.begin(), face.end());
  return face;
}

}  // namespace

template <int K>
MovableMesh<K>::MovableMesh(std::vector<Vec<K>> points, const Triangulation<K>& triangulation)
    : points_(std::move(points)) {
  simplices_.reserve(triangulation.simplices.size());
  for (std::size_t i = 0; i < triangulation.simplices.size(); ++i)
    simplices_.push_back({triangulation.simplices[i], triangulation.neighbors[i],
                          triangulation.regions.empty() ? 0 : triangulation.regions[i]});
}

template <int K>
std::array<Vec<K>, K + 1> MovableMesh<K>::corners(std::uint32_t s) const {
  std::array<Vec<K>, K + 1> x;
  for (std::size_t i = 0; i <= K; ++i) x[i] = points_[simplices_[s].corner[i]];
  return x;
}

template <int K>
bool MovableMesh<K>::holds(std::uint32_t s, const Vec<K>& x) const {
  return ball_holds(corners(s), x);
}

/// A walk through faces that have x on their other side.
template <int K>
std::optional<std::uint32_t> MovableMesh<K>::locate(const Vec<K>& x, std::uint32_t near) const {
  std::uint32_t here = near, before = kNone;
  for (int step = 0; step < kMostSteps; ++step) {
    const auto corner = corners(here);
    bool moves = false;
    for (std::size_t k = 0; k <= K && !moves; ++k) {
      // Not always the same face first, or a walk may go in circles.
      const std::size_t i = (k + static_cast<std::size_t>(step)) % (K + 1);
      const std::uint32_t next = simplices_[here].neighbor[i];
      if (next == before && next != kNone) continue;
      auto replaced = corner;
      replaced[i] = x;
      if (orientation_of(replaced) >= 0) continue;
      if (next == kNone) return std::nullopt;
      before = here;
      here = next;
      moves = true;
    }
    if (!moves) return here;
  }
  return std::nullopt;
}

template <int K>
auto MovableMesh<K>::rim_of(const std::vector<std::uint32_t>& part) const -> std::vector<Rim> {
  std::vector<Rim> rim;
  for (const std::uint32_t s : part)
    for (std::size_t i = 0; i <= K; ++i) {
      const std::uint32_t next = simplices_[s].neighbor[i];
      if (next == kNone || std::ranges::find(part, next) == part.end())
        rim.push_back({face_of(simplices_[s].corner, i), s, static_cast<std::uint32_t>(i)});
    }
  return rim;
}

template <int K>
bool MovableMesh<K>::replace(const std::vector<std::uint32_t>& part, const std::vector<Corners>& by) {
  using Face = std::array<std::uint32_t, K>;
  struct Side {
    std::uint32_t simplex, face;
  };
  std::map<Face, Side> open;  // The faces that have found no partner yet.
  const auto first = static_cast<std::uint32_t>(simplices_.size());
  std::vector<Simplex> added;
  for (const Corners& corner : by) {
    Simplex simplex{corner, {}, simplices_[part[0]].region};
    simplex.neighbor.fill(kNone);
    const auto own = first + static_cast<std::uint32_t>(added.size());
    added.push_back(simplex);
    for (std::size_t i = 0; i <= K; ++i) {
      const Face face = face_of(corner, i);
      const auto [it, is_new] = open.try_emplace(face, Side{own, static_cast<std::uint32_t>(i)});
      if (is_new) continue;
      const Side other = it->second;
      added.back().neighbor[i] = other.simplex;
      added[other.simplex - first].neighbor[other.face] = own;
      open.erase(it);
    }
  }
  const std::vector<Rim> rim = rim_of(part);
  if (rim.size() != open.size()) return false;
  for (const Rim& r : rim)
    if (!open.contains(r.corner)) return false;
  for (const Rim& r : rim) {
    const Side inside = open.at(r.corner);
    const std::uint32_t outside = simplices_[r.simplex].neighbor[r.face];
    added[inside.simplex - first].neighbor[inside.face] = outside;
    if (outside == kNone) continue;
    auto& links = simplices_[outside].neighbor;
    const auto back = static_cast<std::uint32_t>(std::ranges::find(links, r.simplex) - links.begin());
    links_.push_back({outside, back, r.simplex});
    links[back] = inside.simplex;
  }
  for (const std::uint32_t s : part) {
    simplices_[s].is_alive = false;
    killed_.push_back(s);
  }
  simplices_.insert(simplices_.end(), added.begin(), added.end());
  return true;
}

template <int K>
bool MovableMesh<K>::insert(const Vec<K>& x, std::uint32_t near) {
  const std::optional<std::uint32_t> start = locate(x, near);
  if (!start || !holds(*start, x)) return false;
  std::vector<std::uint32_t> cavity = {*start};
  for (std::size_t k = 0; k < cavity.size(); ++k)
    for (const std::uint32_t next : simplices_[cavity[k]].neighbor)
      if (next != kNone && std::ranges::find(cavity, next) == cavity.end() && holds(next, x)) cavity.push_back(next);
  const auto own = static_cast<std::uint32_t>(points_.size());
  points_.push_back(x);
  std::vector<Corners> by;
  bool is_well =
      std::ranges::all_of(cavity, [&](std::uint32_t s) { return simplices_[s].region == simplices_[*start].region; });
  for (const Rim& r : rim_of(cavity)) {
    Corners corner = simplices_[r.simplex].corner;
    corner[r.face] = own;
    by.push_back(corner);
    std::array<Vec<K>, K + 1> at;
    for (std::size_t i = 0; i <= K; ++i) at[i] = points_[corner[i]];
    is_well = is_well && orientation_of(at) > 0;
  }
  if (is_well && replace(cavity, by)) return true;
  points_.pop_back();
  return false;
}

// The star of a vertex is filled by the Delaunay triangulation of its link: by those simplices whose balls held it.
template <int K>
bool MovableMesh<K>::remove(std::uint32_t vertex, std::uint32_t at) {
  const auto corner_of = [&](std::uint32_t s) { return std::ranges::find(simplices_[s].corner, vertex); };
  std::vector<std::uint32_t> star = {at}, link;
  for (std::size_t k = 0; k < star.size(); ++k) {
    const Simplex& s = simplices_[star[k]];
    for (std::size_t i = 0; i <= K; ++i) {
      if (s.corner[i] != vertex && std::ranges::find(link, s.corner[i]) == link.end()) link.push_back(s.corner[i]);
      if (s.corner[i] == vertex) continue;
      if (s.neighbor[i] == kNone) return false;
      if (std::ranges::find(star, s.neighbor[i]) == star.end()) star.push_back(s.neighbor[i]);
    }
  }
  if (corner_of(at) == simplices_[at].corner.end()) return false;
  std::vector<Vec<K>> around;
  for (const std::uint32_t v : link) around.push_back(points_[v]);
  DelaunayKernel<K> kernel;
  kernel.insert(around);
  std::vector<Corners> by;
  for (std::uint32_t slot = 0; slot < kernel.n_slots(); ++slot) {
    if (!kernel.is_alive(slot) || !kernel.is_finite(slot)) continue;
    Corners corner = kernel.corners(slot);
    std::array<Vec<K>, K + 1> x;
    for (std::size_t i = 0; i <= K; ++i) {
      corner[i] = link[corner[i]];
      x[i] = points_[corner[i]];
    }
    if (ball_holds(x, points_[vertex])) by.push_back(corner);
  }
  return !by.empty() && replace(star, by);
}

template <int K>
void MovableMesh<K>::undo(const Mark& mark) {
  while (links_.size() > mark.n_links) {
    const Link& link = links_.back();
    simplices_[link.simplex].neighbor[link.face] = link.before;
    links_.pop_back();
  }
  for (; killed_.size() > mark.n_killed; killed_.pop_back()) simplices_[killed_.back()].is_alive = true;
  simplices_.resize(mark.n_simplices);
  points_.resize(mark.n_points);
}

template <int K>
Triangulation<K> MovableMesh<K>::to_triangulation() const {
  std::vector<std::uint32_t> number(simplices_.size(), kNone);
  std::uint32_t n = 0;
  for (std::size_t s = 0; s < simplices_.size(); ++s)
    if (simplices_[s].is_alive) number[s] = n++;
  Triangulation<K> result;
  for (const Simplex& s : simplices_) {
    if (!s.is_alive) continue;
    Corners neighbor = s.neighbor;
    for (std::uint32_t& t : neighbor)
      if (t != kNone) t = number[t];
    result.simplices.push_back(s.corner);
    result.neighbors.push_back(neighbor);
    result.regions.push_back(s.region);
  }
  return result;
}

template class MovableMesh<2>;
template class MovableMesh<3>;

}  // namespace voropack
