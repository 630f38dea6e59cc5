// Exact arithmetic on doubles: floating-point expansions [Shewchuk1997].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "geom/dd.h"

namespace voropack {

/// An exact real number: the sum of finitely many doubles that do not overlap, in ascending magnitude, none zero.
///
/// Sums, differences and products are exact, barring overflow and underflow: results whose last bit is below 2^-1074
/// lose it. Callers scale their input by a power of two to be far from both. After each operation the expansion is
/// compressed, so that its length follows the number of bits and not the history.
class Expansion {
 public:
  Expansion() = default;
  Expansion(double x) { append(x); }  // NOLINT: a double is an exact number.
  Expansion(Dd x) {                   // NOLINT: so is the sum of two.
    append(x.lo);
    append(x.hi);
  }
  Expansion(const Expansion& other) { *this = other; }
  Expansion(Expansion&& other) noexcept { *this = std::move(other); }
  Expansion& operator=(const Expansion& other) {
    if (this != &other) {
      reserve(other.size_);
      std::copy_n(other.data(), other.size_, data());
      size_ = other.size_;
    }
    return *this;
  }
  Expansion& operator=(Expansion&& other) noexcept {
    if (other.heap_) {
      heap_ = std::move(other.heap_);
      capacity_ = other.capacity_;
      other.capacity_ = kInline;
    } else {
      std::copy_n(other.inline_.data(), other.size_, data());  // Every capacity is at least kInline.
    }
    size_ = other.size_;
    other.size_ = 0;
    return *this;
  }
  ~Expansion() = default;

  [[nodiscard]] std::span<const double> terms() const { return {data(), size_}; }
  [[nodiscard]] int sign() const {
    if (size_ == 0) return 0;
    return data()[size_ - 1] > 0 ? 1 : -1;
  }
  /// The nearest Dd, up to a relative error of kDdUnit.
  [[nodiscard]] Dd approximate() const;

  friend Expansion operator-(Expansion a) {
    for (std::size_t i = 0; i < a.size_; ++i) a.data()[i] = -a.data()[i];
    return a;
  }
  friend Expansion operator+(const Expansion& a, const Expansion& b);
  friend Expansion operator-(const Expansion& a, const Expansion& b) { return a + (-b); }
  friend Expansion operator*(const Expansion& a, const Expansion& b);

 private:
  static constexpr std::size_t kInline = 20;

  double* data() { return heap_ ? heap_.get() : inline_.data(); }
  [[nodiscard]] const double* data() const { return heap_ ? heap_.get() : inline_.data(); }
  void append(double x) {
    if (x == 0) return;
    if (size_ == capacity_) reserve(2 * capacity_);
    data()[size_++] = x;
  }
  void reserve(std::size_t n);
  void compress();
  static void scale(std::span<const double> a, double b, Expansion& out);
  static void add(const Expansion& a, const Expansion& b, Expansion& out);

  std::size_t size_ = 0, capacity_ = kInline;
  std::unique_ptr<double[]> heap_;  // NOLINT: a buffer; null while inline_ suffices.
  std::array<double, kInline> inline_;
};

inline int sign(const Expansion& a) { return a.sign(); }

}  // namespace voropack
