// Counter-based random numbers: a pure function of what is hashed, so that results do not depend on the order of
// evaluation.
#pragma once

#include <cstdint>

namespace voropack {

/// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): a bijection of 64-bit words that passes BigCrush as a
/// generator.
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

/// A hash of any number of words.
template <class... Words>
constexpr std::uint64_t hash_words(Words... words) {
  std::uint64_t h = 0x9e3779b97f4a7c15ULL;
  ((h = mix64(h + 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(words))), ...);
  return h;
}

/// Uniform in [0, 1) with 53 bits.
constexpr double to_unit(std::uint64_t h) { return static_cast<double>(h >> 11U) * 0x1.0p-53; }

/// A sequence of random numbers from a seed.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(mix64(seed + 0x9e3779b97f4a7c15ULL)) {}
  constexpr std::uint64_t bits() { return mix64(state_ += 0x9e3779b97f4a7c15ULL); }
  constexpr double unit() { return to_unit(bits()); }

 private:
  std::uint64_t state_;
};

}  // namespace voropack
