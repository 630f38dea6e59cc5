// Centers along curves of one dimension (segments, and the arcs in which facets cross a corner's sphere), at common
// distances from a common end where the curves leave it at a small angle.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "voropack/spacing.h"
#include "voropack/vec.h"

namespace voropack {

/// A curve by arc length.
template <int D>
struct Strand {
  double length = 0;
  std::function<Vec<D>(double)> at;
  double longest_step = std::numeric_limits<double>::infinity();  ///< No gap between untied centers is longer.
  double least_step = 0;  ///< Gaps are no shorter than that for the sake of f alone.
  double jitter = 0;      ///< Untied centers move at random by this much, relative to f.
  /// Positions that an untied strand shall have instead of equal steps. Empty: equal steps.
  std::function<std::vector<double>()> positions;
  std::vector<double> kept;  ///< Positions of centers that are there already, ascending, inside. All of them stay.
};

/// One end of a strand.
struct StrandEnd {
  std::uint32_t strand = 0;
  bool is_far = false;  ///< The end at `length`.
  double angle = 0;     ///< The smallest with another strand of the tie, radians.
  bool operator==(const StrandEnd&) const = default;
};

/// Strands that leave one point at small angles. Points at equal distances from it never encroach upon each other
/// (docs/theory/sharp.md, T3), so strands carry the same distances as long as they are near to others. Each one leaves
/// where it is far enough from all others, or where it ends.
struct Tie {
  std::vector<StrandEnd> ends;
  double angle = 0;  ///< Smallest angle between two of the strands, radians.
  double start = 0;  ///< The distance from the common point at which the strands begin.
  bool operator==(const Tie&) const = default;
};

/// Centers inside a strand, ends excluded.
struct PackedStrand {
  std::vector<double> position;  ///< Arc length, ascending.
  std::vector<double> radius;    ///< At most f there; less where the other strands of a tie have less.
  std::vector<int> kept;         ///< Index into Strand::kept, or -1 for a new center.
  double tied_begin = 0;         ///< Up to here the positions are common to a tie at the near end.
  double tied_end = 0;           ///< The same from the far end.
};

/// What is tied goes its own ways where it is this many f apart: protecting balls of independent points then do not
/// reach the others.
inline constexpr double kTieApart = 1.5;

/// How much tied centers move at random, relative to the room that their angle leaves: exact copies would be
/// cocircular, and rounding would decide how they are triangulated. Small enough that nothing encroaches.
inline constexpr double kTieJitter = 0.01;

/// Packs strands, and packs them again after some of them have changed, or f along them, or ties: the rest stays.
template <int D>
class StrandPacker {
 public:
  /// `jitter`: kTieJitter, or 0 for exact copies.
  StrandPacker(double jitter, std::uint64_t seed) : jitter_(jitter), seed_(seed) {}

  /// The strands and ties of the call before may have become more, and ties may have been joined; what else is
  /// different, f included, is so only on strands that `is_new` names. It will name all that have been packed anew. The
  /// result is that of a packer that begins with this call.
  void pack(const std::vector<Strand<D>>& strands, const std::vector<Tie>& ties, const Spacing<D>& spacing,
            std::vector<std::uint8_t>& is_new);

  [[nodiscard]] const std::vector<PackedStrand>& packed() const { return packed_; }

 private:
  class Round;
  /// A center by its distance from an end. Radius -1: f.
  struct Shell {
    double position, radius;
    int kept = -1;  ///< As in PackedStrand.
  };
  /// What one end of a strand has got from the tie there.
  struct End {
    int tie = -1;               ///< -1: none.
    double wanted = 0;          ///< How far the strand is nearer to others of the tie than it may be alone.
    bool is_full = false;       ///< The shells reach to the other end.
    std::vector<Shell> shells;  ///< Positions from this end.
  };

  double jitter_;
  std::uint64_t seed_;
  std::vector<Tie> ties_;
  std::vector<std::array<End, 2>> ends_;  ///< By strand.
  std::vector<PackedStrand> packed_;
};

/// All at once. `jitter` as above.
template <int D>
std::vector<PackedStrand> pack_strands(const std::vector<Strand<D>>& strands, const std::vector<Tie>& ties,
                                       const Spacing<D>& spacing, double jitter, std::uint64_t seed);

}  // namespace voropack
