// Books: pages that meet at a small angle along a segment, the spine. Near to the spine all of them carry the same
// centers, turned about it; then no center encroaches upon another page, whatever the angle (docs/theory/sharp.md,
// T4).
#pragma once

#include <span>
#include <vector>

#include "packing/protection.h"
#include "spheres/packing_problem.h"
#include "voropack/packing.h"

namespace voropack {

/// Where a book's pages are equal, in coordinates (s, y) of a page: s along the spine, y >= 0 away from it.
///
/// There y is at most a fixed part of the distance to anything else in any of the pages: whatever is in the zone of
/// one spine is in no other's.
class BookZone {
 public:
  BookZone(const Domain<3>& domain, const Protection<3>& protection, SegmentId spine, std::vector<Page> pages);

  [[nodiscard]] SegmentId spine() const { return spine_; }
  [[nodiscard]] const std::vector<Page>& pages() const { return pages_; }
  [[nodiscard]] double length() const { return length_; }
  [[nodiscard]] double largest_height() const { return largest_; }
  [[nodiscard]] bool holds(const Vec<2>& x) const;

  [[nodiscard]] Vec<2> to_page(std::size_t page, const Vec<3>& x) const;
  [[nodiscard]] Vec<3> from_page(std::size_t page, const Vec<2>& x) const;

 private:
  [[nodiscard]] double height_at(double s) const;

  SegmentId spine_;
  std::vector<Page> pages_;
  Vec<3> start_, along_;
  std::vector<Vec<3>> inward_;  ///< By page.
  double length_;
  std::vector<double> heights_;  ///< At equal steps of s.
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
