#include "domain/outline.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "domain/plane.h"

namespace voropack::domain_impl {

namespace {

using DirectedEdge = std::array<Index, 2>;

template <class Fn>
void for_each_edge(const WorkFacet& facet, Fn&& fn) {
  for (const auto& corners : facet.polygons)
    for (std::size_t i = 0; i < corners.size(); ++i) fn(corners[i], corners[(i + 1) % corners.size()]);
}

/// Closed walks over edges of which as many end as begin at every point.
std::vector<std::vector<Index>> closed_walks(const std::vector<DirectedEdge>& edges) {
  std::map<Index, std::vector<Index>> leaving;
  for (Index e = 0; e < edges.size(); ++e) leaving[edges[e][0]].push_back(e);
  std::vector<char> used(edges.size(), 0);
  std::vector<std::vector<Index>> walks;
  for (Index first = 0; first < edges.size(); ++first) {
    if (used[first] != 0) continue;
    std::vector<Index> walk;
    for (Index e = first; e != kNone;) {
      used[e] = 1;
      walk.push_back(edges[e][0]);
      const Index end = edges[e][1];
      const auto& next = leaving[end];
      const auto free = std::find_if(next.begin(), next.end(), [&](Index n) { return used[n] == 0; });
      e = end == walk.front() || free == next.end() ? kNone : *free;
    }
    walks.push_back(std::move(walk));
  }
  return walks;
}

class OutlineJoiner {
 public:
  OutlineJoiner(Complex<3>& complex, const Sheet& sheet, const EdgeCounts& counts, double thickness)
      : complex_(complex), sheet_(sheet), counts_(counts), thickness_(thickness) {
    for (const Index f : sheet.facets)
      for_each_edge(complex.facets[f], [&](Index a, Index b) { uses_[Complex<3>::key(a, b)].push_back({f, a, b}); });
  }

  void run() {
    for (const Index seed : sheet_.facets) {
      if (turned_.count(seed) > 0) continue;
      const std::vector<Index> members = oriented_group(seed);
      if (members.size() > 1 && !is_folded(members)) join(members);
    }
  }

 private:
  struct Use {
    Index facet, from, to;
  };

  /// The facets around `seed` that can be joined with it; notes which are turned against it.
  std::vector<Index> oriented_group(Index seed) {
    std::vector<Index> members = {seed};
    turned_[seed] = false;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Index f = members[i];
      for_each_edge(complex_.facets[f], [&](Index a, Index b) {
        const std::uint64_t key = Complex<3>::key(a, b);
        const auto& uses = uses_.at(key);
        if (uses.size() != 2 || counts_.at(key) != 2) return;
        const Use& other = uses[0].facet == f ? uses[1] : uses[0];
        if (complex_.facets[other.facet].marker != complex_.facets[f].marker) return;
        const auto [it, added] = turned_.try_emplace(other.facet, turned_[f] != (other.from == a));
        if (added) members.push_back(other.facet);
      });
    }
    std::sort(members.begin(), members.end());
    return members;
  }

  /// Areas in the sheet's plane, all of the same sign but for facets that are thin.
  [[nodiscard]] bool is_folded(const std::vector<Index>& members) const {
    std::vector<double> areas;
    double total = 0;
    for (const Index f : members) {
      double area = 0;
      for (const auto& corners : complex_.facets[f].polygons)
        area += dot(area_vector(complex_.points, corners), sheet_.frame.normal);
      areas.push_back(turned_.at(f) ? -area : area);
      total += areas.back();
    }
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (areas[i] * total >= 0) continue;
      Box<3> box;
      for (const Index p : complex_.facets[members[i]].points) box.add(complex_.points[p]);
      if (std::abs(areas[i]) > 0.5 * thickness_ * box.diagonal()) return true;
    }
    return false;
  }

  void join(const std::vector<Index>& members) {
    std::map<std::uint64_t, std::vector<DirectedEdge>> found;
    for (const Index f : members)
      for_each_edge(complex_.facets[f], [&, turn = turned_.at(f)](Index a, Index b) {
        found[Complex<3>::key(a, b)].push_back(turn ? DirectedEdge{b, a} : DirectedEdge{a, b});
      });
    std::vector<DirectedEdge> outline;
    for (const auto& [key, uses] : found) {
      const bool closed = uses.size() == 2 && counts_.at(key) == 2;
      // Joined along a strip that is turned over, the facets have no outline.
      if (closed && uses[0] == uses[1]) return;
      if (!closed) outline.insert(outline.end(), uses.begin(), uses.end());
    }
    for (const Index f : members) complex_.facets[f].points.clear();
    WorkFacet& facet = complex_.facets[members.front()];
    facet.polygons = closed_walks(outline);
    for (const auto& walk : facet.polygons) facet.points.insert(facet.points.end(), walk.begin(), walk.end());
    std::sort(facet.points.begin(), facet.points.end());
    facet.points.erase(std::unique(facet.points.begin(), facet.points.end()), facet.points.end());
  }

  Complex<3>& complex_;
  const Sheet& sheet_;
  const EdgeCounts& counts_;
  double thickness_;
  std::unordered_map<std::uint64_t, std::vector<Use>> uses_;
  std::unordered_map<Index, bool> turned_;
};

}  // namespace

EdgeCounts count_edges(const Complex<3>& complex) {
  EdgeCounts counts;
  for (const WorkFacet& facet : complex.facets)
    for_each_edge(facet, [&](Index a, Index b) { ++counts[Complex<3>::key(a, b)]; });
  return counts;
}

void join_outlines(Complex<3>& complex, const Sheet& sheet, const EdgeCounts& counts, double thickness) {
  OutlineJoiner(complex, sheet, counts, thickness).run();
}

}  // namespace voropack::domain_impl
