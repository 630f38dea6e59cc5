// Vertices of an older mesh that a packing begins with, by the polytope that carries them.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "packing/incidence.h"
#include "voropack/packing.h"

namespace voropack {

template <int D>
class KeptCenters {
 public:
  struct OnSegment {
    double position;  ///< Arc length from the segment's first point.
    Vec<D> center;
  };
  struct Inside {
    Vec<D> center;
    RegionId region;
  };

  KeptCenters() = default;
  /// What lies on a trace belongs to it, and not to the facet that the trace is in.
  KeptCenters(const Domain<D>& domain, const Incidence<D>& incidence, const KeptVertices<D>& vertices);

  [[nodiscard]] bool empty() const { return n_ == 0; }
  /// True if all of them have to stay; else those that fit do.
  [[nodiscard]] bool all_stay() const { return all_stay_; }
  /// Ascending.
  [[nodiscard]] std::span<const OnSegment> on_segment(SegmentId s) const {
    return empty() ? std::span<const OnSegment>{} : on_segment_[s];
  }
  [[nodiscard]] std::span<const Vec<D>> on_facet(FacetId f) const {
    return empty() ? std::span<const Vec<D>>{} : on_facet_[f];
  }
  [[nodiscard]] const std::vector<Inside>& inside() const { return inside_; }
  /// The distance from a point to the nearest center on its segments and facets; infinite if there is none.
  [[nodiscard]] double nearest(const Domain<D>& domain, const Incidence<D>& incidence, PointId p) const;

 private:
  std::size_t n_ = 0;
  bool all_stay_ = true;
  Csr<SegmentId, OnSegment> on_segment_;
  Csr<FacetId, Vec<D>> on_facet_;
  std::vector<Inside> inside_;
};

}  // namespace voropack
