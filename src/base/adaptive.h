// Integrals over pieces that are cut in halves where they contribute most to the error of the sum.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel.h"

namespace voropack {

/// How far an integral is refined.
struct AdaptiveLimits {
  double accuracy = 0.02;  ///< Wanted relative error.
  std::size_t max_pieces = 20'000;
  std::size_t min_pieces = 512;  ///< At the start, whatever the error, so that a small part is not overlooked.
  double cut_fraction = 0.25;    ///< Pieces whose error is at least this part of the largest are cut in one round.
};

/// The pieces at the end. A Piece has an `error`, and `is_exact` where it need not be cut, whatever the others do.
///
/// examine(piece, round, i) sets the integral and the error of the i-th new piece of a round, in parallel;
/// halves(piece) are two pieces; relative_error(pieces) is that of the sum.
template <class Piece, class Examine, class Halves, class RelativeError>
std::vector<Piece> cut_adaptively(std::vector<Piece> pieces, Examine&& examine, Halves&& halves,
                                  RelativeError&& relative_error, const AdaptiveLimits& limits = {}) {
  constexpr std::size_t kGrain = 16;
  std::size_t n_old = 0;  // Pieces from here on are new.
  for (std::uint64_t round = 0;; ++round) {
    parallel_for(
        pieces.size() - n_old, [&](std::size_t i) { examine(pieces[n_old + i], round, i); }, kGrain);
    double largest = 0;
    bool is_exact = true;
    for (const Piece& piece : pieces) {
      largest = std::max(largest, piece.error);
      is_exact = is_exact && piece.is_exact;
    }
    // Few pieces may miss what makes their error.
    const bool is_start = pieces.size() < limits.min_pieces;
    const bool is_fine = largest == 0 || relative_error(std::as_const(pieces)) <= limits.accuracy;
    if (is_exact || (is_fine && !is_start) || pieces.size() >= limits.max_pieces) return pieces;
    const double threshold = is_start ? 0.0 : limits.cut_fraction * largest;
    std::vector<Piece> kept, cut;
    for (const Piece& piece : pieces) {
      if (piece.is_exact || !(piece.error >= threshold)) {
        kept.push_back(piece);
        continue;
      }
      for (const Piece& half : halves(piece)) cut.push_back(half);
    }
    if (cut.empty()) return kept;  // Where errors are no numbers.
    n_old = kept.size();
    kept.insert(kept.end(), cut.begin(), cut.end());
    pieces = std::move(kept);
  }
}

}  // namespace voropack
