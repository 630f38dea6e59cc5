// Spheres along the segments of a domain, from round to round of the verify-and-adapt loop: only where f has become
// smaller, or a tie or a corner is new, they are packed anew.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/random.h"
#include "packing/protection.h"
#include "packing/strands.h"
#include "voropack/packing.h"
#include "voropack/spacing.h"

namespace voropack {

template <int D>
class SegmentPacker {
 public:
  struct Center {
    Vec<D> position;
    double radius;  ///< At most f; less if what is tied to the segment has less.
    double f;       ///< There.
  };

  SegmentPacker(const PackingOptions& options, const Observer& observer)
      : options_(options), observer_(observer), strands_(D == 3 ? kTieJitter : 0.0, hash_words(options.seed, 1)) {}

  /// `spacing` is that of the call before with the caps `lowered`, and the domain has at most more segments. The result
  /// is that of a packer that begins with this call.
  void pack(const Protection<D>& protection, const Spacing<D>& spacing, std::span<const SpacingCap<D>> lowered);

  /// Inside the segment, in its direction.
  [[nodiscard]] const std::vector<Center>& centers(SegmentId s) const { return chains_[s.value()].centers; }
  /// f at a domain point.
  [[nodiscard]] double f_at(PointId p) const { return f_at_point_[p.value()]; }
  /// True if the last call has packed the segment.
  [[nodiscard]] bool is_new(SegmentId s) const { return is_new_[s.value()] != 0; }
  /// The next call packs the segment in any case.
  void pack_again(SegmentId s) { is_doubtful_[s.value()] = 1; }

 private:
  using KeptCenter = typename KeptCenters<D>::OnSegment;
  struct Chain {
    std::array<double, 2> rim = {-1, -1};  ///< Radii of the corners at its ends.
    bool is_shaken = false;
    double most = 0;               ///< f is at most that along the segment.
    std::vector<KeptCenter> kept;  ///< Those that stay.
    std::vector<Center> centers;
  };

  void find_new(const Protection<D>& protection, double lipschitz, std::span<const SpacingCap<D>> lowered);
  void update_points(const Domain<D>& domain, const Spacing<D>& spacing);
  [[nodiscard]] std::vector<KeptCenter> choose_kept(const Protection<D>& protection, const Spacing<D>& spacing,
                                                    SegmentId s) const;
  [[nodiscard]] std::vector<Strand<D>> strands(const Protection<D>& protection, const Spacing<D>& spacing) const;
  [[nodiscard]] std::vector<Center> place(const Domain<D>& domain, const Spacing<D>& spacing, SegmentId s) const;

  const PackingOptions& options_;
  const Observer& observer_;
  StrandPacker<D> strands_;
  std::vector<Chain> chains_;                       ///< By segment.
  std::vector<std::uint8_t> is_new_, is_doubtful_;  ///< By segment.
  std::vector<double> f_at_point_;                  ///< By point; negative where it is not known.
};

}  // namespace voropack
