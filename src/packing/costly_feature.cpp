// Costly features in words.
#include <fmt/format.h>

#include "base/place_text.h"
#include "voropack/packing.h"

namespace voropack {

namespace {

template <int D>
std::string name_of(PolytopeId p, const Domain<D>& domain) {
  if (p.dimension == 0) return "the point " + place_text(domain.points[PointId(p.index)], domain.box);
  if (p.dimension == 1) return fmt::format("a segment of marker {}", domain.segment_marker[SegmentId(p.index)]);
  return fmt::format("a facet of marker {}", domain.facet_marker[FacetId(p.index)]);
}

}  // namespace

template <int D>
std::string describe(const CostlyFeature<D>& feature, const Domain<D>& domain) {
  using Kind = typename CostlyFeature<D>::Kind;
  const std::string p = name_of(feature.polytopes[0], domain), q = name_of(feature.polytopes[1], domain);
  std::string what;
  if (feature.kind == Kind::kGap)
    what = fmt::format("{} and {} are {:.4g} apart", p, q, feature.size);
  else if (feature.kind == Kind::kAngle)
    what = fmt::format("{} and {} meet at {:.4g} degrees", p, q, feature.angle_deg);
  else
    what = fmt::format("repairs at {}{}", p, feature.polytopes[0] == feature.polytopes[1] ? "" : " and " + q);
  std::string text =
      fmt::format("{:.0f} vertices: {} near {}", feature.vertices, what, place_text(feature.place, domain.box));
  if (feature.n_pairs > 1)
    text += fmt::format(", with {} more such pairs within {:.4g}", feature.n_pairs - 1, feature.radius);
  return text;
}

template std::string describe(const CostlyFeature<2>&, const Domain<2>&);
template std::string describe(const CostlyFeature<3>&, const Domain<3>&);

}  // namespace voropack
