// Lattices whose points are the centers of a maximal packing by themselves: hexagonal in the plane, body-centered cubic
// in space.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "base/random.h"
#include "voropack/vec.h"

namespace voropack {

/// A family of lattices of sides side(0) > side(1) > ... about one origin.
///
/// A lattice of side s has smallest distance kDistance * s and covering radius kCovering * s. Its points carry a
/// maximal packing of f-spheres wherever kCovering * s / 2 < f <= kDistance * s / 2: no two conflict, and no place is
/// left.
template <int K>
class LatticeFamily {
 public:
  static constexpr double kDistance = K == 2 ? 1.0 : 0.8660254037844386;                 // sqrt(3) / 2
  static constexpr double kCovering = K == 2 ? 0.5773502691896258 : 0.5590169943749475;  // 1 / sqrt(3), sqrt(5) / 4
  /// Less than kDistance / kCovering, so that neighboring classes overlap. In space 2 is two classes: there lattices
  /// for f and 2 f are equally coarse, and one is a part of the other.
  static constexpr double kRatio = K == 2 ? 1.7 : 1.4142135623730951;  // sqrt(2)
  /// How much finer the lattice is than it must be. Pays for the jitter.
  static constexpr double kSlack = 1e-4;
  /// Points move at random by up to this much of the side: exact lattices are cospherical and slow down every
  /// predicate.
  static constexpr double kJitter = 1e-6;

  /// One class is the coarsest lattice that is maximal for f = `fitted`; class 0 is the coarsest one for `largest`.
  LatticeFamily(const Vec<K>& origin, double fitted, double largest, std::uint64_t seed)
      : origin_(origin), side0_(2 * fitted * (1 - kSlack) / kCovering), seed_(seed) {
    const double steps = std::log(largest / fitted) / std::log(kRatio);
    side0_ *= std::pow(kRatio, std::floor(steps + kSlack));
  }

  [[nodiscard]] double side(int cls) const { return side0_ * std::pow(kRatio, -cls); }

  /// The class whose lattice is a maximal packing for every f in [lo, hi], if there is one.
  [[nodiscard]] std::optional<int> class_for(double lo, double hi) const {
    const double limit = 2 * lo * (1 - 0.5 * kSlack) / kCovering;
    const int cls = std::max(0, static_cast<int>(std::ceil(std::log(side0_ / limit) / std::log(kRatio))));
    if (2 * hi > kDistance * side(cls) * (1 - 4 * kJitter)) return std::nullopt;
    return cls;
  }

  /// Calls visit(x) for every point of the lattice in the half-open box [lo, hi).
  template <class Visit>
  void visit(int cls, const Box<K>& box, Visit&& visit) const {
    const double s = side(cls);
    const auto first = [&](double lo, int axis, double step, double shift) {
      return static_cast<std::int64_t>(std::ceil((lo - origin_[axis]) / step - shift));
    };
    if constexpr (K == 2) {
      const double row = s * 0.8660254037844386;
      for (std::int64_t j = first(box.lo[1], 1, row, 0); origin_[1] + row * static_cast<double>(j) < box.hi[1]; ++j) {
        const double shift = (j & 1) != 0 ? 0.5 : 0.0, y = origin_[1] + row * static_cast<double>(j);
        for (std::int64_t i = first(box.lo[0], 0, s, shift);; ++i) {
          const double x = origin_[0] + s * (static_cast<double>(i) + shift);
          if (x >= box.hi[0]) break;
          visit(jittered({x, y}, s, hash_words(seed_, cls, i, j)));
        }
      }
    } else {
      for (const double shift : {0.0, 0.5}) {
        const auto at = [&](std::int64_t i, int axis) { return origin_[axis] + s * (static_cast<double>(i) + shift); };
        for (std::int64_t k = first(box.lo[2], 2, s, shift); at(k, 2) < box.hi[2]; ++k)
          for (std::int64_t j = first(box.lo[1], 1, s, shift); at(j, 1) < box.hi[1]; ++j)
            for (std::int64_t i = first(box.lo[0], 0, s, shift); at(i, 0) < box.hi[0]; ++i)
              visit(jittered({at(i, 0), at(j, 1), at(k, 2)}, s, hash_words(seed_, cls, shift > 0, i, j, k)));
      }
    }
  }

 private:
  static Vec<K> jittered(Vec<K> x, double s, std::uint64_t hash) {
    for (int k = 0; k < K; ++k) {
      hash = mix64(hash);
      x[k] += s * kJitter * (2 * to_unit(hash) - 1) / std::sqrt(static_cast<double>(K));
    }
    return x;
  }

  Vec<K> origin_;
  double side0_;
  std::uint64_t seed_;
};

}  // namespace voropack
