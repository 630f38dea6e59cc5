#include "domain/merge.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "domain/plane.h"
#include "geom/polytope_distance.h"

namespace voropack::domain_impl {

namespace {

class Merger {
 public:
  Merger(const Complex<3>& complex, const std::vector<Fin>& fins,
         const std::vector<std::array<RegionId, 2>>& side_region, bool merge_coplanar)
      : complex_(complex),
        fins_(fins),
        side_region_(side_region),
        merge_coplanar_(merge_coplanar),
        segment_fins_(complex.segments.size(), {0, 0}),
        piece_segments_(complex.pieces.size()),
        piece_triangles_(complex.pieces.size()) {
    for (std::uint32_t f = 0; f < fins.size(); ++f) {
      auto& range = segment_fins_[fins[f].ridge];
      if (range[0] == range[1]) range = {f, f};
      range[1] = f + 1;
      piece_segments_[fins[f].wall].push_back(fins[f].ridge);
    }
    for (std::uint32_t t = 0; t < complex.triangles.size(); ++t)
      piece_triangles_[complex.triangle_piece[t]].push_back(t);
  }

  MergedFacets run() {
    group_pieces();
    sort_groups();
    drop_segments();
    drop_points();
    return std::move(result_);
  }

 private:
  [[nodiscard]] const WorkFacet& facet_of(Index piece) const { return complex_.facets[complex_.pieces[piece].facet]; }

  // Grows facets from the largest pieces, whose planes are known best. A thin triangle goes with the first neighbor
  // whose plane holds its corners, whatever its own normal says.
  void group_pieces() {
    const std::size_t n = complex_.pieces.size();
    result_.piece_group.assign(n, kNone);
    std::vector<Index> order(n);
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return complex_.pieces[a].area > complex_.pieces[b].area; });
    for (const Index seed : order) {
      if (result_.piece_group[seed] != kNone) continue;
      const auto group = static_cast<Index>(result_.groups.size());
      result_.groups.emplace_back();
      std::vector<Index>& members = result_.groups.back().pieces;
      members = {seed};
      result_.piece_group[seed] = group;
      for (std::size_t i = 0; i < members.size(); ++i)
        for (const Index s : piece_segments_[members[i]])
          for (std::uint32_t f = segment_fins_[s][0]; f < segment_fins_[s][1]; ++f) {
            const Index other = fins_[f].wall;
            if (result_.piece_group[other] != kNone || !joinable(members[i], other, s) || !in_plane(seed, other))
              continue;
            result_.piece_group[other] = group;
            members.push_back(other);
          }
      std::sort(members.begin(), members.end());
    }
  }

  [[nodiscard]] bool joinable(Index a, Index b, Index segment) const {
    const auto& [a0, a1] = side_region_[a];
    const auto& [b0, b1] = side_region_[b];
    if (complex_.pieces[a].facet == complex_.pieces[b].facet) return a0 == b0 && a1 == b1;
    const WorkFacet &fa = facet_of(a), &fb = facet_of(b);
    const auto [begin, end] = segment_fins_[segment];
    if (!merge_coplanar_ || end - begin != 2 || fa.marker != fb.marker) return false;
    // Through the segment, side by side: the turn about it tells how their sides correspond.
    const bool same_way = fins_[begin].ccw_side != fins_[begin + 1].ccw_side;
    return same_way ? a0 == b0 && a1 == b1 : a0 == b1 && a1 == b0;
  }

  [[nodiscard]] bool in_plane(Index seed, Index piece) const {
    if (complex_.pieces[seed].facet == complex_.pieces[piece].facet) return true;
    return deviation(facet_of(seed).frame, piece) <= complex_.tolerance;
  }

  [[nodiscard]] double deviation(const PlaneFrame& frame, Index piece) const {
    double worst = 0;
    for (const Index t : piece_triangles_[piece])
      for (const Index p : complex_.triangles[t]) worst = std::max(worst, std::abs(frame.height(complex_.points[p])));
    return worst;
  }

  void sort_groups() {
    for (FacetGroup& group : result_.groups) {
      group.first_facet = kNone;
      for (const Index piece : group.pieces)
        group.first_facet = std::min(group.first_facet, complex_.pieces[piece].facet);
      group.marker = complex_.facets[group.first_facet].marker;
      group.frame = frame_of(group);
    }
    std::stable_sort(result_.groups.begin(), result_.groups.end(), [](const FacetGroup& a, const FacetGroup& b) {
      return std::pair(a.first_facet, a.pieces.front()) < std::pair(b.first_facet, b.pieces.front());
    });
    for (Index g = 0; g < result_.groups.size(); ++g)
      for (const Index piece : result_.groups[g].pieces) result_.piece_group[piece] = g;
  }

  /// The frame of the only input facet or sheet, or that of all pieces' area; oriented as the first input facet.
  [[nodiscard]] PlaneFrame frame_of(const FacetGroup& group) const {
    const WorkFacet& first = complex_.facets[group.first_facet];
    const Index largest = *std::max_element(group.pieces.begin(), group.pieces.end(), [&](Index a, Index b) {
      return std::pair(complex_.pieces[a].area, b) < std::pair(complex_.pieces[b].area, a);
    });
    const bool single = std::all_of(group.pieces.begin(), group.pieces.end(), [&](Index piece) {
      const Index f = complex_.pieces[piece].facet;
      return f == group.first_facet || (first.sheet && complex_.facets[f].sheet == first.sheet);
    });
    if (single) return first.frame;
    const Vec<3> up = facet_of(largest).frame.normal;
    Vec<3> area, center;
    double total = 0;
    std::vector<Vec<3>> positions;
    for (const Index piece : group.pieces)
      for (const Index t : piece_triangles_[piece]) {
        const auto& [a, b, c] = complex_.triangles[t];
        const Vec<3>&xa = complex_.points[a], &xb = complex_.points[b], &xc = complex_.points[c];
        const Vec<3> twice = cross(xb - xa, xc - xa);
        const double sign = dot(facet_of(piece).frame.normal, up) < 0 ? -1 : 1;
        area += sign * twice;
        center += norm(twice) / 3 *
                  ((xa - facet_of(largest).frame.origin) + (xb - facet_of(largest).frame.origin) +
                   (xc - facet_of(largest).frame.origin));
        total += norm(twice);
        positions.insert(positions.end(), {xa, xb, xc});
      }
    // The first input facet may be a sliver whose normal says nothing: then the largest one decides.
    const double turn = dot(first.frame.normal, area);
    if (turn < 0) area = -area;
    PlaneFrame fitted = plane_frame(area, facet_of(largest).frame.origin + center / total, positions);
    for (const Index piece : group.pieces)
      if (deviation(fitted, piece) > complex_.tolerance) {
        const PlaneFrame& plane = facet_of(largest).frame;
        return plane_frame(turn < 0 ? -plane.normal : plane.normal, plane.origin, positions);
      }
    return fitted;
  }

  [[nodiscard]] bool is_dropped(Index s) const {
    const auto [begin, end] = segment_fins_[s];
    if (end - begin != 2 || complex_.segments[s].listed) return false;
    const Index a = fins_[begin].wall, b = fins_[begin + 1].wall;
    if (result_.piece_group[a] != result_.piece_group[b]) return false;
    return complex_.input->is_surface || complex_.pieces[a].facet != complex_.pieces[b].facet;
  }

  void drop_segments() {
    segment_kept_.resize(complex_.segments.size());
    for (Index s = 0; s < segment_kept_.size(); ++s) segment_kept_[s] = is_dropped(s) ? 0 : 1;
  }

  /// The groups at a segment, as often as they meet it.
  [[nodiscard]] std::vector<Index> groups_at(Index s) const {
    std::vector<Index> groups;
    for (std::uint32_t f = segment_fins_[s][0]; f < segment_fins_[s][1]; ++f)
      groups.push_back(result_.piece_group[fins_[f].wall]);
    std::sort(groups.begin(), groups.end());
    return groups;
  }

  void drop_points() {
    const std::size_t n = complex_.points.size();
    result_.point_kept.assign(n, 1);
    std::vector<std::vector<Index>> at(n);
    for (Index s = 0; s < complex_.segments.size(); ++s)
      if (segment_kept_[s] != 0)
        for (const Index p : complex_.segments[s].ends) at[p].push_back(s);
    std::vector<char> straight(n, 0);
    if (complex_.input->is_surface)
      for (Index p = 0; p < n; ++p) {
        if (complex_.point_listed[p] != 0) continue;
        if (at[p].empty()) result_.point_kept[p] = 0;
        straight[p] = is_straight(p, at[p]) ? 1 : 0;
      }
    std::vector<char> used(complex_.segments.size(), 0);
    for (Index s = 0; s < complex_.segments.size(); ++s) {
      if (segment_kept_[s] == 0 || used[s] != 0) continue;
      // The maximal run of straight points through s, from one end to the other.
      std::vector<Index> corners(complex_.segments[s].ends.begin(), complex_.segments[s].ends.end()), members = {s};
      for (int turn = 0; turn < 2; ++turn) {
        while (straight[corners.back()] != 0 && corners.back() != corners.front()) {
          const auto& two = at[corners.back()];
          const Index next = two[0] == members.back() ? two[1] : two[0];
          const auto& ends = complex_.segments[next].ends;
          corners.push_back(ends[0] == corners.back() ? ends[1] : ends[0]);
          members.push_back(next);
        }
        std::reverse(corners.begin(), corners.end());
        std::reverse(members.begin(), members.end());
      }
      for (const Index member : members) used[member] = 1;
      add_chains(corners, members, 0, members.size());
    }
    std::sort(result_.chains.begin(), result_.chains.end(),
              [](const SegmentChain& a, const SegmentChain& b) { return a.first < b.first; });
  }

  [[nodiscard]] bool is_straight(Index p, const std::vector<Index>& at) const {
    if (at.size() != 2 || complex_.segments[at[0]].listed || complex_.segments[at[1]].listed) return false;
    std::array<Index, 2> others{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& ends = complex_.segments[at[i]].ends;
      others[i] = ends[0] == p ? ends[1] : ends[0];
    }
    const auto& x = complex_.points;
    return groups_at(at[0]) == groups_at(at[1]) &&
           distance_to_segment(x[p], x[others[0]], x[others[1]]) <= complex_.tolerance;
  }

  /// Replaces members [begin, end) by one chain, or cuts them at the point that is farthest from a straight line.
  void add_chains(const std::vector<Index>& corners, const std::vector<Index>& members, std::size_t begin,
                  std::size_t end) {
    const auto& x = complex_.points;
    std::size_t farthest = begin;
    double worst = complex_.tolerance;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double d = distance_to_segment(x[corners[i]], x[corners[begin]], x[corners[end]]);
      if (d > worst) {
        worst = d;
        farthest = i;
      }
    }
    if (farthest != begin) {
      add_chains(corners, members, begin, farthest);
      add_chains(corners, members, farthest, end);
      return;
    }
    for (std::size_t i = begin + 1; i < end; ++i) result_.point_kept[corners[i]] = 0;
    const auto first = std::min_element(members.begin() + static_cast<std::ptrdiff_t>(begin),
                                        members.begin() + static_cast<std::ptrdiff_t>(end));
    const auto i = static_cast<std::size_t>(first - members.begin());
    const bool forward = complex_.segments[*first].ends[0] == corners[i];
    SegmentChain chain{{corners[begin], corners[end]}, *first};
    if (!forward) std::swap(chain.ends[0], chain.ends[1]);
    result_.chains.push_back(chain);
  }

  const Complex<3>& complex_;
  const std::vector<Fin>& fins_;
  const std::vector<std::array<RegionId, 2>>& side_region_;
  bool merge_coplanar_;
  std::vector<std::array<std::uint32_t, 2>> segment_fins_;  ///< A range of fins_.
  std::vector<std::vector<Index>> piece_segments_;
  std::vector<std::vector<Index>> piece_triangles_;
  std::vector<char> segment_kept_;
  MergedFacets result_;
};

}  // namespace

MergedFacets merge_facets(const Complex<3>& complex, const std::vector<Fin>& fins,
                          const std::vector<std::array<RegionId, 2>>& side_region, bool merge_coplanar) {
  return Merger(complex, fins, side_region, merge_coplanar).run();
}

}  // namespace voropack::domain_impl
