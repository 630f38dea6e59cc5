// Angles between polytopes that meet.
#pragma once

#include <string>
#include <vector>

#include "domain/faults.h"
#include "voropack/domain.h"

namespace voropack::domain_impl {

/// What messages call the polytopes of the result, and the input lines behind them.
struct PolytopeNames {
  std::vector<std::string> segment, facet;
  std::vector<std::optional<std::uint64_t>> segment_line, facet_line;
};

/// Faults domain.small_angle: each pair of polytopes, neither in the other, with a common point and a smaller angle
/// between them than the limit. Smallest angles first.
template <int D>
void check_angles(const Domain<D>& domain, const PolytopeNames& names, double min_angle_deg, FaultList<D>& faults);

}  // namespace voropack::domain_impl
