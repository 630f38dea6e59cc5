// Books: pages that meet at a small angle along a segment, the spine. Near to the spine all of them carry the same
// centers, turned about it; then no center encroaches upon another page, whatever the angle (docs/theory/sharp.md,
// T4).
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "packing/protection.h"
#include "spheres/packing_problem.h"
#include "voropack/packing.h"

namespace voropack {

/// Pages of a book that carry the same centers, in a zone as high as the angle between parts of them needs.
struct BookLevel {
  std::vector<Page> pages;
  double angle = 0;  ///< The least between pages of different parts; a further level follows within a part. Radians.
  std::size_t depth = 0;
  std::optional<std::size_t> parent = std::nullopt;  ///< In the order of the levels.
};

/// A book's levels: all of its pages, then the parts of them that are nearer to each other, and so on, parents first.
/// Gaps within a part are at most half of the widest gap between parts.
std::vector<BookLevel> levels_of_book(const Protection<3>& protection, SegmentId spine, std::vector<Page> pages);

/// Where pages of a level are equal, in coordinates (s, y) of a page: s along the spine, y >= 0 away from it.
///
/// There y is at most a fixed part of the distance to other spines and to corners in any of the pages: whatever is in
/// the zone of one spine is in no other's. It keeps 2 f away from the other segments of the pages, except from shared
/// walls: segments that leave an end of the spine at one angle in all pages, and are no spines. Up to these everything
/// is equal. What a zone `below` holds, the one of the level's parent, is not in it.
class BookZone {
 public:
  BookZone(const Domain<3>& domain, const Protection<3>& protection, const Spacing<3>& spacing, SegmentId spine,
           BookLevel level, const BookZone* below = nullptr);

  [[nodiscard]] SegmentId spine() const { return spine_; }
  [[nodiscard]] const std::vector<Page>& pages() const { return pages_; }
  [[nodiscard]] double length() const { return length_; }
  [[nodiscard]] double largest_height() const { return largest_; }
  [[nodiscard]] bool holds(const Vec<2>& x) const;
  /// True if the box holds no point of the zone. False is no answer.
  [[nodiscard]] bool misses(const Box<2>& box) const;
  /// The spine and the shared walls, in (s, y).
  [[nodiscard]] const std::vector<std::array<Vec<2>, 2>>& walls() const { return walls_; }
  /// True if the segment is the spine, or a shared wall in this page.
  [[nodiscard]] bool is_wall(std::size_t page, SegmentId s) const {
    return s == spine_ || std::ranges::count(wall_segments_[page], s) > 0;
  }

  /// f at x, the least of all pages.
  [[nodiscard]] double least_spacing(const Spacing<3>& spacing, const Vec<2>& x) const;
  [[nodiscard]] Vec<2> to_page(std::size_t page, const Vec<3>& x) const;
  [[nodiscard]] Vec<3> from_page(std::size_t page, const Vec<2>& x) const;

 private:
  struct PageObstacles;
  [[nodiscard]] PageObstacles find_obstacles(const Domain<3>& domain, const Protection<3>& protection,
                                             std::size_t page) const;
  void find_positions(const std::vector<PageObstacles>& obstacles);
  [[nodiscard]] double shared_length(const Vec<2>& tip) const;
  void find_shared_walls(const Domain<3>& domain, const Protection<3>& protection);
  [[nodiscard]] double height_below_walls(double s) const;
  [[nodiscard]] double height_needed(const Spacing<3>& spacing, double angle, double s, double most) const;
  [[nodiscard]] double height_at(double s) const;
  /// The least and the largest height between two positions.
  [[nodiscard]] std::array<double, 2> heights_between(double s, double t) const;
  /// True if the zone or one below it holds x.
  [[nodiscard]] bool reaches(const Vec<2>& x) const;

  SegmentId spine_;
  std::vector<Page> pages_;
  const BookZone* below_;
  Vec<3> start_, along_;
  std::vector<Vec<3>> inward_;  ///< By page.
  double length_;
  std::vector<std::array<Vec<2>, 2>> walls_;
  std::vector<std::vector<SegmentId>> wall_segments_;  ///< Shared walls, by page.
  std::vector<double> positions_;                      ///< Ascending values of s.
  std::vector<double> heights_;                        ///< There.
  double largest_ = 0;
  std::array<double, 2> corner_;  ///< Radii of the corners at the ends, or 0.
};

/// The part of a facet that books and corners have filled.
class ReservedArea : public Area<2> {
 public:
  /// The zone in its page of that number. The zone must outlive the area.
  void add(const Domain<3>& domain, const BookZone& zone, std::size_t page);
  void add_disc(const Ball<2>& disc) { discs_.push_back(disc); }
  [[nodiscard]] bool empty() const { return zones_.empty() && discs_.empty(); }

  [[nodiscard]] bool holds(const Vec<2>& x) const override;
  [[nodiscard]] bool touches(const Box<2>& box) const override;
  [[nodiscard]] bool covers(const Box<2>& box) const override;

 private:
  struct Placed {
    const BookZone* zone;
    Vec<2> start, along, inward;  ///< In the facet's frame.
    [[nodiscard]] Vec<2> local(const Vec<2>& x) const { return {dot(x - start, along), dot(x - start, inward)}; }
  };
  std::vector<Placed> zones_;
  std::vector<Ball<2>> discs_;
};

/// Centers of a book's zone, in the coordinates of a page. `obstacles`: spheres on the pages, `balls`: protecting balls
/// there, in the same coordinates.
std::vector<Ball<2>> pack_book(const BookZone& zone, std::vector<Ball<2>> obstacles, std::vector<Ball<2>> balls,
                               const Spacing<3>& spacing, const PackingOptions& options, const Observer& observer);

}  // namespace voropack
