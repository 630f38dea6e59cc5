#include "coarsening/conforming_level.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "geom/predicates.h"

namespace voropack {

namespace {

constexpr int kUnset = -2;
constexpr double kLeastDeviation = 1e-3;  // Below, relative to its length, an edge is as good as the boundary.

double area_of(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) { return 0.5 * cross(b - a, c - a); }

}  // namespace

double triangle_quality(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const std::array<Vec<2>, 3> x = {a, b, c};
  double least = 180, largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec<2> u = x[(i + 1) % 3] - x[i], v = x[(i + 2) % 3] - x[i];
    const double angle = kDegrees * std::atan2(std::abs(cross(u, v)), dot(u, v));
    least = std::min(least, angle);
    largest = std::max(largest, angle);
  }
  return std::min(least, kLargeAngleWeight * (180 - largest));
}

double boundary_quality(double deviation, double length) {
  return 25 - 15 * std::log2(std::max(deviation / length, kLeastDeviation) / 0.25);
}

double ConformingLevel::edge_cost(std::uint32_t chain, std::uint32_t from, std::uint32_t to) const {
  const auto& vertices = fine_->chains[chain].vertices;
  const double length = distance(fine_->points[vertices[from]], fine_->points[vertices[to]]);
  const double quality = boundary_quality(chain_deviation(*fine_, fine_->chains[chain], from, to), length);
  return cost_of(quality);
}

ConformingLevel::ConformingLevel(const ChainedMesh& fine)
    : fine_(&fine), triangulation_(fine.points), n_chosen_(fine.chains.size(), 0), area_(fine.region_id.size(), 0) {
  for (const VertexChain& chain : fine.chains) {
    next_.emplace_back(chain.vertices.size(), 0);
    previous_.emplace_back(chain.vertices.size(), 0);
  }
  take_changes();
}

void ConformingLevel::link(std::uint32_t vertex) {
  for (const auto& [c, k] : fine_->places[VertexId(std::size_t{vertex})]) {
    const VertexChain& chain = fine_->chains[c];
    const std::size_t n = chain.vertices.size();
    ++n_chosen_[c];
    // An open chain ends at anchors, which have themselves as neighbors beyond the end.
    std::uint32_t after = k, before = k;
    const auto is_chosen = [&](std::uint32_t at) { return at == k || has(chain.vertices[at]); };
    if (chain.is_closed || k + 1 < n) do
        after = static_cast<std::uint32_t>((after + 1) % n);
      while (!is_chosen(after) && (chain.is_closed || after + 1 < n));
    if (chain.is_closed || k > 0) do
        before = static_cast<std::uint32_t>((before + n - 1) % n);
      while (!is_chosen(before) && (chain.is_closed || before > 0));
    next_[c][k] = after;
    previous_[c][k] = before;
    if (after != k) previous_[c][after] = k;
    if (before != k) next_[c][before] = k;
    if (after != k && before != k)
      cost_change_ += edge_cost(c, before, k) + edge_cost(c, k, after) - edge_cost(c, before, after);
    changed_edges_.push_back({chain.vertices[before], chain.vertices[after]});
  }
}

void ConformingLevel::unlink(std::uint32_t vertex) {
  for (const auto& [c, k] : fine_->places[VertexId(std::size_t{vertex})]) {
    const VertexChain& chain = fine_->chains[c];
    --n_chosen_[c];
    const std::uint32_t after = next_[c][k], before = previous_[c][k];
    cost_change_ -= edge_cost(c, before, k) + edge_cost(c, k, after) - edge_cost(c, before, after);
    previous_[c][after] = before;
    next_[c][before] = after;
    changed_edges_.push_back({chain.vertices[before], chain.vertices[after]});
  }
}

void ConformingLevel::insert(std::uint32_t vertex) {
  link(vertex);
  triangulation_.insert(vertex, recent_, destroyed_, created_);
  ++n_vertices_;
  if (fine_->on_boundary(vertex)) ++n_boundary_edges_;
  take_changes();
}

void ConformingLevel::remove(std::uint32_t vertex) {
  unlink(vertex);
  triangulation_.remove(vertex, destroyed_, created_);
  --n_vertices_;
  if (fine_->on_boundary(vertex)) --n_boundary_edges_;
  take_changes();
}

void ConformingLevel::take_changes() {
  for (const Slot slot : destroyed_) {
    SlotState& s = state_[slot];
    if (!s.is_fresh) {
      cost_change_ -= s.cost;
      if (region_[slot] >= 0) area_[static_cast<std::size_t>(region_[slot])] -= s.area;
      n_sides_ -= static_cast<std::size_t>(std::popcount(s.boundary_sides));
    }
    s = {};
  }
  region_.resize(triangulation_.n_slots(), kOutside);
  state_.resize(triangulation_.n_slots());
  for (const Slot slot : created_) {
    state_[slot].is_fresh = true;
    fresh_.push_back(slot);
    recent_ = slot;
  }
  destroyed_.clear();
  created_.clear();
}

void ConformingLevel::choose(std::uint32_t vertex) { insert(vertex); }

void ConformingLevel::drop(std::uint32_t vertex) { remove(vertex); }

bool ConformingLevel::may_drop(std::uint32_t vertex) const {
  if (fine_->is_anchor[vertex] != 0) return false;
  for (const auto& [c, k] : fine_->places[VertexId(std::size_t{vertex})])
    if (n_chosen_[c] <= fine_->chains[c].min_vertices()) return false;
  return true;
}

std::optional<int> ConformingLevel::boundary_region(std::uint32_t a, std::uint32_t b) const {
  if (triangulation_.is_box(a) || triangulation_.is_box(b)) return std::nullopt;
  for (const ChainPlace& place : fine_->places[VertexId(std::size_t{a})]) {
    const VertexChain& chain = fine_->chains[place.chain];
    const std::uint32_t after = next(place), before = previous(place);
    if (after != place.position && chain.vertices[after] == b) return chain.regions[0];
    if (before != place.position && chain.vertices[before] == b) return chain.regions[1];
  }
  return std::nullopt;
}

void ConformingLevel::mark_sides(Slot slot) {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [a, b] = side(slot, i);
    if (boundary_region(a, b)) bits = static_cast<std::uint8_t>(bits | (1U << i));
  }
  n_sides_ += static_cast<std::size_t>(std::popcount(bits));
  n_sides_ -= static_cast<std::size_t>(std::popcount(state_[slot].boundary_sides));
  state_[slot].boundary_sides = bits;
}

void ConformingLevel::refresh_edge(std::uint32_t a, std::uint32_t b) {
  if (a == b || !has(a) || !has(b)) return;
  for (const Slot slot : {triangulation_.left_of(a, b), triangulation_.left_of(b, a)}) {
    if (slot == EditableTriangulation::kNoSlot || state_[slot].is_fresh) continue;
    mark_sides(slot);
    refreshed_.push_back(slot);
  }
}

bool ConformingLevel::spread_regions(const std::vector<Slot>& fresh) {
  std::vector<Slot> queue;
  for (const Slot slot : fresh) {
    region_[slot] = kUnset;
    for (std::size_t i = 0; i < 3 && region_[slot] == kUnset; ++i) {
      const Slot neighbor = triangulation_.triangle(slot).neighbors[i];
      if ((state_[slot].boundary_sides >> i & 1U) != 0) {
        const auto [a, b] = side(slot, i);
        region_[slot] = *boundary_region(a, b);
      } else if (neighbor == EditableTriangulation::kNoSlot) {
        region_[slot] = kOutside;
      } else if (!state_[neighbor].is_fresh) {
        region_[slot] = region_[neighbor];
      }
    }
    if (region_[slot] != kUnset) queue.push_back(slot);
  }
  for (std::size_t k = 0; k < queue.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i) {
      const Slot neighbor = triangulation_.triangle(queue[k]).neighbors[i];
      if (neighbor == EditableTriangulation::kNoSlot || (state_[queue[k]].boundary_sides >> i & 1U) != 0) continue;
      if (region_[neighbor] != kUnset) continue;
      region_[neighbor] = region_[queue[k]];
      queue.push_back(neighbor);
    }
  return queue.size() == fresh.size();
}

bool ConformingLevel::is_sound(Slot slot) const {
  const auto& t = triangulation_.triangle(slot);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = t.corners[i];
    if (triangulation_.is_box(v) ? region_[slot] != kOutside
                                 : !fine_->on_boundary(v) && region_[slot] != fine_->vertex_region[v])
      return false;
    const auto [a, b] = side(slot, i);
    if ((state_[slot].boundary_sides >> i & 1U) != 0) {
      if (*boundary_region(a, b) != region_[slot]) return false;
      if (in_diametral_ball(triangulation_.point(a), triangulation_.point(b), triangulation_.point(v)) > 0)
        return false;
    } else {
      const Slot neighbor = t.neighbors[i];
      if ((neighbor == EditableTriangulation::kNoSlot ? kOutside : region_[neighbor]) != region_[slot]) return false;
    }
  }
  return true;
}

double ConformingLevel::cost_of(double quality) const { return std::exp((cost_.goal_deg - quality) / cost_.scale_deg); }

void ConformingLevel::measure(Slot slot) {
  SlotState& s = state_[slot];
  s.is_fresh = false;
  if (region_[slot] < 0) return;
  const auto& corners = triangulation_.triangle(slot).corners;
  const Vec<2>&a = triangulation_.point(corners[0]), &b = triangulation_.point(corners[1]),
        &c = triangulation_.point(corners[2]);
  s.area = area_of(a, b, c);
  s.quality = triangle_quality(a, b, c);
  s.cost = cost_of(s.quality);
  area_[static_cast<std::size_t>(region_[slot])] += s.area;
  cost_change_ += s.cost;
}

double ConformingLevel::area_change() const {
  double largest = 0;
  for (std::size_t r = 0; r < area_.size(); ++r)
    largest = std::max(largest, std::abs(area_[r] / fine_->region_area[r] - 1));
  return largest;
}

void ConformingLevel::apply(std::optional<std::uint32_t> out, std::optional<std::uint32_t> in) {
  cost_change_ = 0;
  area_change_before_ = area_change();
  if (out) remove(*out);
  if (in) insert(*in);
}

bool ConformingLevel::settle() {
  std::erase_if(fresh_, [&](Slot slot) { return !triangulation_.is_alive(slot) || !state_[slot].is_fresh; });
  refreshed_.clear();
  for (const Slot slot : fresh_) mark_sides(slot);
  for (const auto& [a, b] : changed_edges_) refresh_edge(a, b);
  bool is_sound_all = spread_regions(fresh_) && n_sides_ == 2 * n_boundary_edges_;
  for (const Slot slot : fresh_) measure(slot);
  for (const Slot slot : fresh_) is_sound_all = is_sound_all && is_sound(slot);
  for (const Slot slot : refreshed_) is_sound_all = is_sound_all && is_sound(slot);
  fresh_.clear();
  changed_edges_.clear();
  return is_sound_all && area_change() <= std::max(max_area_change, area_change_before_);
}

bool ConformingLevel::settle_boundary() {
  n_boundary_edges_ = 0;
  for_each_edge([&](ChainPlace) { ++n_boundary_edges_; });
  n_sides_ = 0;
  area_.assign(area_.size(), 0);
  fresh_.clear();
  for (Slot slot = 0; slot < triangulation_.n_slots(); ++slot) {
    state_[slot] = {};
    if (!triangulation_.is_alive(slot)) continue;
    state_[slot].is_fresh = true;
    fresh_.push_back(slot);
  }
  changed_edges_.clear();
  area_change_before_ = std::numeric_limits<double>::infinity();
  return settle();
}

std::vector<std::uint32_t> ConformingLevel::misplaced_vertices() const {
  std::vector<std::uint32_t> misplaced;
  for (std::uint32_t v = 0; v < fine_->points.size(); ++v) {
    if (!has(v) || fine_->on_boundary(v)) continue;
    bool is_misplaced = false;
    triangulation_.around(
        v, [&](Slot slot, std::size_t) { is_misplaced = is_misplaced || region_[slot] != fine_->vertex_region[v]; });
    if (is_misplaced) misplaced.push_back(v);
  }
  return misplaced;
}

void ConformingLevel::set_cost(const ShapeCost& cost) {
  cost_ = cost;
  for (Slot slot = 0; slot < triangulation_.n_slots(); ++slot)
    if (triangulation_.is_alive(slot) && region_[slot] >= 0) state_[slot].cost = cost_of(state_[slot].quality);
}

std::vector<ConformingLevel::Fault> ConformingLevel::boundary_faults() const {
  std::vector<Fault> faults;
  for_each_edge([&](ChainPlace place) {
    const std::uint32_t a = fine_->chains[place.chain].vertices[place.position];
    const std::uint32_t b = fine_->chains[place.chain].vertices[next(place)];
    // Shrink the ball of ab towards a until it is empty: an inner vertex that it touches last is joined to a.
    std::optional<std::uint32_t> culprit;
    double deepest = 0;
    triangulation_.around(a, [&](Slot slot, std::size_t i) {
      const std::uint32_t v = triangulation_.triangle(slot).corners[(i + 1) % 3];
      if (v == b || triangulation_.is_box(v)) return;
      const Vec<2>&x = triangulation_.point(a), &y = triangulation_.point(b), &z = triangulation_.point(v);
      if (in_diametral_ball(x, y, z) <= 0) return;
      const double depth = -dot(x - z, y - z);
      if (culprit && depth <= deepest) return;
      culprit = v;
      deepest = depth;
    });
    if (culprit || triangulation_.left_of(a, b) == EditableTriangulation::kNoSlot)
      faults.push_back({place, next(place), culprit});
  });
  return faults;
}

double ConformingLevel::boundary_distance() const {
  double farthest = 0;
  for_each_edge([&](ChainPlace place) {
    farthest = std::max(farthest, chain_deviation(*fine_, fine_->chains[place.chain], place.position, next(place)));
  });
  return farthest;
}

}  // namespace voropack
