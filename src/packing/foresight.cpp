// Where two polytopes P and Q meet at a small angle and nothing is copied from one to the other, repairs shrink f on P
// until protecting balls are as small as the distance to Q. In the zone of a book and within a corner's sphere centers
// are copied, and f stays as it is.
#include "packing/foresight.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "packing/book.h"
#include "packing/incidence.h"
#include "packing/places.h"

namespace voropack {

namespace {

/// f over the distance to Q, fitted to the counts of wedges, cracks and heaps of tetrahedra (docs/theory/sharp.md).
constexpr double kShare = 0.6;
/// Polytopes that meet at more than this rarely need a repair.
constexpr double kSmallAngle = std::numbers::pi / 6;
/// A corner's sphere in f at its point, as long as its segments are long.
constexpr double kCornerRadius = 2.7;
/// A piece of P is at most this part of its distance from Q's common points as large.
constexpr double kPieceSize = 0.4;
/// No more pieces of one polytope, and of all, are looked at.
constexpr std::size_t kMaxPieces = 4'000, kMaxAllPieces = 100'000;

class Foresight {
 public:
  Foresight(const Domain<3>& domain, const Spacing<3>& spacing)
      : domain_(domain), spacing_(spacing), protection_(domain), incidence_(protection_.incidence) {}

  std::vector<SpacingCap<3>> run() {
    std::vector<Meeting> meetings = small_angles();
    std::sort(meetings.begin(), meetings.end());
    for (const Meeting& meeting : meetings)
      if (n_pieces_ < kMaxAllPieces) foresee(meeting.a, meeting.b);
    return std::move(caps_);
  }

 private:
  struct Meeting {
    double angle;
    PolytopeId a, b;
    friend auto operator<=>(const Meeting&, const Meeting&) = default;
  };
  struct Piece {
    std::array<Vec<3>, 3> corner;
    std::size_t n_corners;
  };

  [[nodiscard]] std::vector<Meeting> small_angles() const {
    std::vector<Meeting> meetings;
    std::set<std::array<PolytopeId, 2>> seen;
    for (const PointId p : ids(domain_.points)) {
      std::vector<PolytopeId> around;
      for (const SegmentId s : incidence_.segments_at(p)) around.emplace_back(s);
      for (const FacetId f : incidence_.facets_at(p)) around.emplace_back(f);
      for (const PolytopeId a : around)
        for (const PolytopeId b : around) {
          // Segments carry the same distances from a common point, whatever their angle.
          if (!(a < b) || b.dimension == 1 || !seen.insert({a, b}).second) continue;
          const std::optional<double> angle = incidence_.meeting_angle(a, b);
          if (angle && *angle < kSmallAngle) meetings.push_back({*angle, a, b});
        }
    }
    return meetings;
  }

  void foresee(PolytopeId a, PolytopeId b) {
    std::optional<BookZone> zone;
    if (a.dimension == 2)
      for (const SegmentId s : incidence_.common_segments(FacetId(a.index), FacetId(b.index)))
        for (const Page& p : incidence_.pages_of(s))
          for (const Page& q : incidence_.pages_of(s))
            if (p.facet == FacetId(a.index) && q.facet == FacetId(b.index) &&
                angle_between(incidence_.inward(p, s), incidence_.inward(q, s)) < kSmallAngle)
              zone.emplace(domain_, protection_, s, std::vector<Page>{p, q});
    cover(a, b, zone ? &*zone : nullptr, 0);
    cover(b, a, zone ? &*zone : nullptr, 1);
  }

  /// Caps on p where it is near to q. `page` is that of p in the zone.
  void cover(PolytopeId p, PolytopeId q, const BookZone* zone, std::size_t page) {
    std::vector<Piece> pieces = pieces_of(p);
    for (std::size_t i = 0; i < pieces.size() && i < kMaxPieces; ++i, ++n_pieces_) {
      const Piece piece = pieces[i];
      Vec<3> center;
      for (std::size_t k = 0; k < piece.n_corners; ++k)
        center += piece.corner[k] / static_cast<double>(piece.n_corners);
      const auto [a, b] = longest_edge(piece);
      const double length = distance(piece.corner[a], piece.corner[b]);
      const Vec<3> opposite = nearest_point_of(domain_, q, center);
      const double gap = distance(center, opposite), f = spacing_(center);
      if (kShare * (gap - length) > f) continue;
      const Vec<3> common = nearest_common_point(domain_, incidence_, p, q, center);
      const double away = distance(center, common);
      if (away + length < kCornerRadius * f) continue;
      if (length > kPieceSize * away) {
        Piece half = piece;
        half.corner[a] = 0.5 * (piece.corner[a] + piece.corner[b]);
        pieces.push_back(half);
        half = piece;
        half.corner[b] = 0.5 * (piece.corner[a] + piece.corner[b]);
        pieces.push_back(half);
      } else {
        const double value = kShare * gap;
        const bool is_copied = zone != nullptr && zone->holds(zone->to_page(page, center));
        if (value < f && !is_copied && has_room(p, center, value) && has_room(q, opposite, value))
          caps_.push_back({center, 0.5 * length, value, std::array{p, q}});
      }
    }
  }

  /// Facets keep their centers 2 f away from their segments: where they are narrower, they have none.
  [[nodiscard]] bool has_room(PolytopeId p, const Vec<3>& x, double f) const {
    if (p.dimension == 1) return true;
    return std::ranges::none_of(domain_.facet_segments[FacetId(p.index)], [&](SegmentId s) {
      return distance_to_segment(x, domain_.points[domain_.segments[s][0]], domain_.points[domain_.segments[s][1]]) <
             2 * f;
    });
  }

  [[nodiscard]] std::vector<Piece> pieces_of(PolytopeId p) const {
    const auto at = [&](PointId i) { return domain_.points[i]; };
    if (p.dimension == 1) {
      const auto [a, b] = domain_.segments[SegmentId(p.index)];
      return {{{at(a), at(b), {}}, 2}};
    }
    std::vector<Piece> pieces;
    for (const auto& t : domain_.facet_triangles[FacetId(p.index)])
      pieces.push_back({{at(t[0]), at(t[1]), at(t[2])}, 3});
    return pieces;
  }

  static std::array<std::size_t, 2> longest_edge(const Piece& piece) {
    std::array<std::size_t, 2> longest = {0, 1};
    for (std::size_t i = 0; i < piece.n_corners; ++i)
      for (std::size_t j = i + 1; j < piece.n_corners; ++j)
        if (distance_sq(piece.corner[i], piece.corner[j]) >
            distance_sq(piece.corner[longest[0]], piece.corner[longest[1]]))
          longest = {i, j};
    return longest;
  }

  const Domain<3>& domain_;
  const Spacing<3>& spacing_;
  const Protection<3> protection_;
  const Incidence<3>& incidence_;
  std::vector<SpacingCap<3>> caps_;
  std::size_t n_pieces_ = 0;
};

}  // namespace

Spacing<3> with_foreseen_caps(const Domain<3>& domain, const Spacing<3>& spacing) {
  const std::vector<SpacingCap<3>> caps = Foresight(domain, spacing).run();
  return caps.empty() ? spacing : spacing.with_caps(caps);
}

// In the plane all that meets is segments.
Spacing<2> with_foreseen_caps(const Domain<2>&, const Spacing<2>& spacing) { return spacing; }

}  // namespace voropack
