// Traces: where a segment that rises from a facet at a small angle would lie if it were turned into the facet about
// their common point. The facet gets a segment there of its own. Tied to the one above it carries the same distances,
// and no center above encroaches upon the facet (docs/theory/sharp.md, T6).
#pragma once

#include <optional>
#include <vector>

#include "packing/incidence.h"
#include "voropack/spacing.h"

namespace voropack {

/// A segment over a facet, from a common point on.
struct TraceSite {
  PointId tip;
  SegmentId segment;
  FacetId facet;
  friend auto operator<=>(const TraceSite&, const TraceSite&) = default;
};

struct Trace {
  TraceSite site;
  Vec<3> direction;  ///< Unit vector, inside the facet.
  double angle;      ///< Between segment and trace, radians.
  double length;
};

/// The trace, as long as segment and facet are near to each other; nothing if the segment is not over the facet's
/// interior or if the trace would be as near to another segment there.
///
/// If the segment is in a page of a book with the facet, it turns about the book's spine, so that what is packed
/// equally in both pages goes up to both lines. Else the trace is its orthogonal projection.
std::optional<Trace> find_trace(const Domain<3>& domain, const Incidence<3>& incidence, const TraceSite& site,
                                const Spacing<3>& spacing);

/// Adds the trace to the facet: as the domain's last segment, ending in its last point.
void add_trace(Domain<3>& domain, const Trace& trace);

}  // namespace voropack
