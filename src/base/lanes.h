// Two doubles that take part in the same arithmetic, one instruction for both.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace voropack {

/// A number type for the polynomials that are written for any: each lane holds the result that a double would, to the
/// bit.
struct Lanes {
  static constexpr std::size_t kSize = 2;
  using Vector [[gnu::vector_size(kSize * sizeof(double))]] = double;
  using Bits [[gnu::vector_size(kSize * sizeof(double))]] = std::int64_t;

  /// The outcome of a comparison, lane by lane.
  struct Mask {
    Bits bits;
    friend Mask operator&(Mask a, Mask b) { return {a.bits & b.bits}; }
    [[nodiscard]] bool all() const { return (bits[0] & bits[1]) != 0; }
    bool operator[](std::size_t lane) const { return bits[lane] != 0; }
  };

  Vector v;

  Lanes() = default;
  Lanes(double x) : v{x, x} {}  // NOLINT(google-explicit-constructor): a number type.
  Lanes(double first, double second) : v{first, second} {}
  explicit Lanes(Vector x) : v(x) {}

  double operator[](std::size_t lane) const { return v[lane]; }
  void set(std::size_t lane, double x) { v[lane] = x; }

  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.v + b.v); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.v - b.v); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.v * b.v); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.v / b.v); }
  friend Lanes operator-(Lanes a) { return Lanes(-a.v); }
  friend Mask operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
  friend Mask operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
  friend Mask operator==(Lanes a, Lanes b) { return {a.v == b.v}; }

  friend Lanes select(Mask mask, Lanes yes, Lanes no) { return Lanes(mask.bits ? yes.v : no.v); }
  friend Lanes max(Lanes a, Lanes b) { return select(a < b, b, a); }
  friend Lanes min(Lanes a, Lanes b) { return select(b < a, b, a); }
  friend Lanes abs(Lanes a) { return {std::abs(a[0]), std::abs(a[1])}; }
  friend Lanes square(Lanes a) { return a * a; }
  friend Lanes sqrt(Lanes a) { return {std::sqrt(a[0]), std::sqrt(a[1])}; }
};

}  // namespace voropack
