// Which volumes are regions: seeds, numbers, and walls that bound nothing.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "domain/complex.h"
#include "domain/volumes.h"

namespace voropack::domain_impl {

/// The regions of a domain, and the region of each volume: none() for holes.
struct RegionTable {
  std::vector<RegionId> of_volume;
  IdVector<RegionId, int> id;
  IdVector<RegionId, double> measure;
  IdVector<RegionId, std::optional<double>> max_simplex;

  /// The region of a volume, also for the outside.
  [[nodiscard]] RegionId at(std::uint32_t volume) const {
    return volume == Volumes<2>::kOutside ? RegionId::none() : of_volume[volume];
  }
};

/// Empties volumes with a hole seed, numbers the others. Faults: domain.seed_outside, domain.seed_conflict.
template <int D>
RegionTable assign_regions(const Complex<D>& complex, const Volumes<D>& volumes, FaultList<D>& faults);

/// How messages name walls and ridges.
struct WallNames {
  std::function<std::string(std::uint32_t wall)> wall;
  std::function<std::string(std::uint32_t ridge)> ridge;
};

/// Faults: domain.open_boundary and domain.outside, for walls with no region on either side.
template <int D>
void check_walls(const Complex<D>& complex, const Walls<D>& walls, const std::vector<Fin>& fins,
                 const Volumes<D>& volumes, const RegionTable& regions, const WallNames& names, FaultList<D>& faults);

/// The region that holds x, which is on no wall. Fault: domain.outside if there is none.
template <int D>
RegionId region_of(const Complex<D>& complex, const Volumes<D>& volumes, const RegionTable& regions, const Vec<D>& x,
                   const std::string& name, FaultList<D>& faults);

}  // namespace voropack::domain_impl
