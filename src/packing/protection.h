// What keeps protecting balls empty where polytopes meet at small angles: the state of the verify-and-adapt loop. It
// starts empty, and only what fails is protected.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "packing/incidence.h"
#include "packing/kept.h"
#include "packing/traces.h"
#include "spheres/sphere_set.h"
#include "voropack/domain.h"
#include "voropack/spacing.h"

namespace voropack {

/// Disjoint groups of members, one family of groups for each key.
template <class Key, class Member>
class Groups {
 public:
  using Group = std::vector<Member>;  ///< Sorted.

  /// Puts both into one group. False if they were in one already.
  bool join(const Key& key, const Member& a, const Member& b) {
    std::vector<Group>& groups = groups_[key];
    const std::size_t i = find_or_add(groups, a), j = find_or_add(groups, b);
    if (i == j) return false;
    groups[i].insert(groups[i].end(), groups[j].begin(), groups[j].end());
    std::sort(groups[i].begin(), groups[i].end());
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(j));
    return true;
  }
  [[nodiscard]] bool joined(const Key& key, const Member& a, const Member& b) const {
    const auto it = groups_.find(key);
    return it != groups_.end() && std::ranges::any_of(it->second, [&](const Group& g) {
             return std::ranges::binary_search(g, a) && std::ranges::binary_search(g, b);
           });
  }
  [[nodiscard]] const std::map<Key, std::vector<Group>>& all() const { return groups_; }
  [[nodiscard]] const std::vector<Group>* of(const Key& key) const {
    const auto it = groups_.find(key);
    return it == groups_.end() ? nullptr : &it->second;
  }

 private:
  static std::size_t find_or_add(std::vector<Group>& groups, const Member& m) {
    for (std::size_t i = 0; i < groups.size(); ++i)
      if (std::ranges::binary_search(groups[i], m)) return i;
    groups.push_back({m});
    return groups.size() - 1;
  }
  std::map<Key, std::vector<Group>> groups_;
};

/// A center in a protecting ball, or too near to one.
template <int D>
struct Intrusion {
  Vec<D> position;
  PolytopeId carrier;
  Ball<D> ball;
  PolytopeId ball_carrier;
  Vec<D> nearest;                        ///< The corner of the ball's simplex that is nearest to the center.
  std::optional<PointId> center_corner;  ///< The corner on whose sphere the center is.
  std::optional<PointId> ball_corner;    ///< The corner whose fan the ball belongs to.
};

template <int D>
class Protection {
  Domain<D> domain_;
  KeptVertices<D> kept_vertices_;

 public:
  explicit Protection(const Domain<D>& domain, KeptVertices<D> vertices = {})
      : domain_(domain),
        kept_vertices_(std::move(vertices)),
        incidence(domain_),
        kept(domain_, incidence, kept_vertices_) {}
  Protection(const Protection&) = delete;
  Protection& operator=(const Protection&) = delete;

  /// The domain with the traces added to it.
  [[nodiscard]] const Domain<D>& domain() const { return domain_; }
  /// Call before each round of intrusions: what was protected since the last call has had no effect yet.
  void begin_round() { before_ = {fans, books, corners, shaken, short_arcs, tried_sites_}; }
  /// Narrows the spheres of corners that a ball reaches and that are wide for the f there, each once: if f follows, the
  /// angles ask for that ratio at any radius. False if there are none.
  bool narrow_corners(const Vec<D>& center, double radius, const Spacing<D>& spacing);
  /// True if the sphere goes through a corner, up to rounding.
  [[nodiscard]] bool is_at_corner(const Vec<D>& center, double radius) const {
    constexpr double kOnSphere = 1e-6;
    return std::ranges::any_of(corners, [&](const auto& corner) {
      return std::abs(distance(domain_.points[corner.first], center) - radius) < kOnSphere * radius;
    });
  }
  /// Adds the traces that intrusions of the last round asked for.
  void add_traces(const Spacing<D>& spacing);
  /// Answers to an intrusion: with a new fan, book, trace or corner, else with a cap on f, which is returned.
  std::optional<SpacingCap<D>> adapt(const Intrusion<D>& intrusion, const Spacing<D>& spacing);

  [[nodiscard]] double corner_radius(PointId p) const {
    const auto it = corners.find(p);
    return it == corners.end() ? 0.0 : it->second;
  }
  /// True if the facet's pages at the segment are in a book.
  [[nodiscard]] bool is_spine(SegmentId s, FacetId facet) const {
    const auto* groups = books.of(s);
    return groups != nullptr && std::ranges::any_of(*groups, [&](const auto& pages) {
             return std::ranges::any_of(pages, [&](const Page& page) { return page.facet == facet; });
           });
  }
  /// The smallest angle between two pages of a book, or segments of a fan. Radians.
  [[nodiscard]] double least_angle(SegmentId spine, const std::vector<Page>& pages) const;
  [[nodiscard]] double least_angle(PointId tip, const std::vector<SegmentId>& segments) const;

  Incidence<D> incidence;             ///< Of domain().
  KeptCenters<D> kept;                ///< On the polytopes of domain().
  Groups<PointId, SegmentId> fans;    ///< Segments with centers at common distances from their common point.
  Groups<SegmentId, Page> books;      ///< Pages with the same centers, turned about their common segment, near to it.
  std::map<PointId, double> corners;  ///< Points with a sphere of this radius which carries the first centers around.
  /// Facets whose arcs around a corner need to be as short as f, since something came near to one of them.
  std::set<std::pair<PointId, FacetId>> short_arcs;
  std::set<SegmentId> shaken;  ///< Segments whose centers move a little, because they were cocircular.

 private:
  using Cap = std::optional<SpacingCap<D>>;
  Cap between_segments(const Intrusion<D>& it, const Spacing<D>& spacing);
  Cap between_pages(const Intrusion<D>& it, SegmentId spine, const Spacing<D>& spacing);
  Cap at_point(const Intrusion<D>& it, const Spacing<D>& spacing);
  /// Asks for traces of segments of either polytope at a common point over the other one. False if there are no new
  /// ones.
  bool ask_for_traces(PointId tip, PolytopeId a, PolytopeId b);
  /// f must shrink so that the ball's radius becomes `wanted`.
  Cap shrink(const Intrusion<D>& it, double wanted, const Spacing<D>& spacing);
  /// The same for the ball of a corner's triangle.
  Cap shorten_arc(const Intrusion<D>& it);
  bool open_corner(PointId p, const Spacing<D>& spacing);
  /// The radius that a corner's sphere gets if nothing is in its way but what is kept.
  [[nodiscard]] double free_radius(PointId p, const Spacing<D>& spacing) const;
  bool shrink_corner(const Intrusion<D>& it);
  [[nodiscard]] double height(const Intrusion<D>& it) const;
  [[nodiscard]] double clear_radius(const Intrusion<D>& it) const;

  struct State {
    Groups<PointId, SegmentId> fans;
    Groups<SegmentId, Page> books;
    std::map<PointId, double> corners;
    std::set<SegmentId> shaken;
    std::set<std::pair<PointId, FacetId>> short_arcs;
    std::set<TraceSite> tried_sites;
  };
  std::set<TraceSite> tried_sites_;    ///< Of traces that were asked for.
  std::set<PointId> narrowed_;         ///< Corners that were too wide once.
  std::vector<TraceSite> new_sites_;   ///< Not added yet.
  std::vector<FacetId> trace_facets_;  ///< By trace.
  State before_;
};

}  // namespace voropack
