// How a check counts what it tests and remembers its worst case, in a way that parallel blocks can combine.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "voropack/certificate.h"
#include "voropack/vec.h"

namespace voropack::judge {

inline constexpr double kNoFigure = std::numeric_limits<double>::quiet_NaN();

/// One thing that was tested. `kind` 0 is legal; a fault has a kind > 0, and the larger kind is the more basic fault.
struct Finding {
  int kind = 0;
  double figure = kNoFigure;           ///< Larger is worse. NaN: this finding has no figure.
  std::array<std::uint32_t, 3> ids{};  ///< What it is about; the check knows their meaning from `kind`.
  bool present = false;

  [[nodiscard]] bool worse_than(const Finding& other) const {
    if (!other.present) return present;
    if (!present) return false;
    if (kind != other.kind) return kind > other.kind;
    return figure > other.figure || (std::isnan(other.figure) && !std::isnan(figure));
  }
};

/// Counts and worst case of one check. Combining in a fixed order gives the same result for any number of threads: of
/// equally bad findings the first one stays.
struct Tally {
  std::uint64_t tested = 0;
  std::uint64_t violations = 0;
  std::uint64_t undecided = 0;
  std::uint64_t excepted = 0;  ///< Would be violations but for a stated exception.
  Finding worst;

  void legal(double figure, std::uint32_t a = 0, std::uint32_t b = 0, std::uint32_t c = 0) {
    ++tested;
    if (worst.present && (worst.kind > 0 || figure <= worst.figure)) return;
    note({.kind = 0, .figure = figure, .ids = {a, b, c}, .present = true});
  }
  /// The same for the figure numerator / denominator, denominator > 0; spares most calls the division.
  void legal_quotient(double numerator, double denominator, std::uint32_t a = 0, std::uint32_t b = 0,
                      std::uint32_t c = 0) {
    constexpr double kRounding = 0x1p-48;
    if (worst.present && numerator + kRounding * std::abs(numerator) < worst.figure * denominator)
      ++tested;
    else
      legal(numerator / denominator, a, b, c);
  }
  void violation(int kind, double figure, std::uint32_t a = 0, std::uint32_t b = 0, std::uint32_t c = 0) {
    ++tested;
    fault(kind, figure, a, b, c);
  }
  /// A violation that is found besides the things counted in `tested`.
  void fault(int kind, double figure, std::uint32_t a = 0, std::uint32_t b = 0, std::uint32_t c = 0) {
    ++violations;
    note({.kind = kind, .figure = figure, .ids = {a, b, c}, .present = true});
  }
  void note(const Finding& finding) {
    if (finding.worse_than(worst)) worst = finding;
  }
  Tally& operator+=(const Tally& other) {
    tested += other.tested;
    violations += other.violations;
    undecided += other.undecided;
    excepted += other.excepted;
    note(other.worst);
    return *this;
  }
};

/// `figure_sign` -1 turns a "larger is worse" figure back into one where small values are bad.
inline Certificate::Check make_check(std::string name, const Tally& tally, std::string where, double figure_sign = 1) {
  Certificate::Check check;
  check.name = std::move(name);
  check.tested = tally.tested;
  check.violations = tally.violations;
  check.ok = tally.violations == 0;
  if (tally.worst.present && !std::isnan(tally.worst.figure)) check.worst = figure_sign * tally.worst.figure;
  check.where = std::move(where);
  if (tally.undecided > 0) check.where += "; undecided: " + std::to_string(tally.undecided);
  return check;
}

/// Six significant digits.
std::string number(double x);

/// A sum of many terms whose error does not grow with their number (Neumaier 1974).
class AccurateSum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    correction_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  void add(const AccurateSum& other) {
    add(other.sum_);
    add(other.correction_);
  }
  [[nodiscard]] double value() const { return sum_ + correction_; }

 private:
  double sum_ = 0;
  double correction_ = 0;
};

}  // namespace voropack::judge
