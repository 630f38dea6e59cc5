#include "geom/exact_predicates.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "geom/predicates.h"

namespace voropack {

namespace {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

/// Sign and magnitude, the lowest limb first.
template <std::size_t L>
struct Signed {
  std::array<std::uint64_t, L> magnitude{};
  bool negative = false;
};

Signed<1> make_signed(std::int64_t x) {
  return {{x < 0 ? -static_cast<std::uint64_t>(x) : static_cast<std::uint64_t>(x)}, x < 0};
}

Signed<2> make_signed(Int128 x) {
  const UInt128 m = x < 0 ? -static_cast<UInt128>(x) : static_cast<UInt128>(x);
  return {{static_cast<std::uint64_t>(m), static_cast<std::uint64_t>(m >> 64U)}, x < 0};
}

template <std::size_t A, std::size_t B>
Signed<A + B> operator*(const Signed<A>& a, const Signed<B>& b) {
  Signed<A + B> out;
  for (std::size_t i = 0; i < A; ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < B; ++j) {
      const UInt128 t = static_cast<UInt128>(a.magnitude[i]) * b.magnitude[j] + out.magnitude[i + j] + carry;
      out.magnitude[i + j] = static_cast<std::uint64_t>(t);
      carry = static_cast<std::uint64_t>(t >> 64U);
    }
    out.magnitude[i + B] = carry;
  }
  out.negative = a.negative != b.negative;
  return out;
}

/// A sum in two's complement; it must fit.
template <std::size_t L>
class Sum {
 public:
  Sum& operator+=(const Signed<L>& x) {
    // -x = ~x + 1.
    const std::uint64_t flip = x.negative ? ~std::uint64_t{0} : 0;
    std::uint64_t carry = x.negative ? 1 : 0;
    for (std::size_t i = 0; i < L; ++i) {
      const UInt128 t = static_cast<UInt128>(limb_[i]) + (x.magnitude[i] ^ flip) + carry;
      limb_[i] = static_cast<std::uint64_t>(t);
      carry = static_cast<std::uint64_t>(t >> 64U);
    }
    return *this;
  }
  Sum& operator-=(Signed<L> x) {
    x.negative = !x.negative;
    return *this += x;
  }
  [[nodiscard]] int sign() const {
    if (limb_[L - 1] >> 63U != 0) return -1;
    return std::any_of(limb_.begin(), limb_.end(), [](std::uint64_t l) { return l != 0; }) ? 1 : 0;
  }
  [[nodiscard]] Signed<L> value() const {
    if (limb_[L - 1] >> 63U == 0) return {limb_, false};
    Sum positive;
    positive -= Signed<L>{limb_, false};
    return {positive.limb_, true};
  }

 private:
  std::array<std::uint64_t, L> limb_{};
};

/// The differences p - origin of N points as integers in units of one power of two, below 2^61 in size.
template <int K, std::size_t N>
struct Differences {
  std::array<std::array<std::int64_t, K>, N> d{};
  bool fit = false;

  Differences(const std::array<const Vec<K>*, N>& points, const Vec<K>& origin) {
    // Each difference is exactly high + low [Knuth's TwoSum].
    std::array<std::array<double, K>, N> high, low;
    double largest = 0;
    for (std::size_t n = 0; n < N; ++n)
      for (int k = 0; k < K; ++k) {
        const double a = (*points[n])[k], b = origin[k];
        const double x = a - b;
        const double b_part = a - x;
        const double a_part = x + b_part;
        const std::size_t axis = static_cast<std::size_t>(k);
        high[n][axis] = x;
        low[n][axis] = (a - a_part) + (b_part - b);
        largest = std::max(largest, std::abs(x));
      }
    // The scale is a normal number of at least 1, so that scaling loses nothing to underflow.
    if (!(largest > 0x1.0p-400 && largest < 0x1.0p60)) return;
    constexpr std::uint64_t kBias = 1023;
    constexpr unsigned kMantissaBits = 52;
    const std::uint64_t exponent = std::bit_cast<std::uint64_t>(largest) >> kMantissaBits;  // Biased.
    const double scale = std::bit_cast<double>((2 * kBias + 60 - exponent) << kMantissaBits);
    bool exact = true;
    for (std::size_t n = 0; n < N; ++n)
      for (std::size_t k = 0; k < K; ++k) {
        const double h = high[n][k] * scale, l = low[n][k] * scale;
        const auto i = static_cast<std::int64_t>(h), j = static_cast<std::int64_t>(l);
        exact = exact && static_cast<double>(i) == h && static_cast<double>(j) == l;
        d[n][k] = i + j;
      }
    fit = exact;
  }
};

template <std::size_t K>
Int128 minor(const std::array<std::int64_t, K>& a, const std::array<std::int64_t, K>& b) {
  return static_cast<Int128>(a[0]) * b[1] - static_cast<Int128>(b[0]) * a[1];
}

template <std::size_t K>
Signed<2> lift(const std::array<std::int64_t, K>& a) {
  Int128 sum = 0;
  for (const std::int64_t x : a) sum += static_cast<Int128>(x) * x;
  return make_signed(sum);
}

/// x a + y b + z c: below 2^188 in size if x, y, z are differences and a, b, c minors.
Sum<3> combine(std::int64_t x, Int128 a, std::int64_t y, Int128 b, std::int64_t z, Int128 c) {
  Sum<3> sum;
  sum += make_signed(x) * make_signed(a);
  sum += make_signed(y) * make_signed(b);
  sum += make_signed(z) * make_signed(c);
  return sum;
}

}  // namespace

int orientation_exact(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  const Differences<2, 2> to({&a, &b}, c);
  if (!to.fit) return orientation(a, b, c);
  const Int128 det = minor(to.d[0], to.d[1]);
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

int orientation_exact(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  const Differences<3, 3> to({&a, &b, &c}, d);
  if (!to.fit) return orientation(a, b, c, d);
  const auto& [da, db, dc] = to.d;
  return -combine(da[2], minor(db, dc), db[2], minor(dc, da), dc[2], minor(da, db)).sign();
}

int in_circumball_exact(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& e) {
  const Differences<2, 3> to({&a, &b, &c}, e);
  if (!to.fit) return in_circumball(a, b, c, e);
  const auto& [da, db, dc] = to.d;
  Sum<4> det;
  det += lift(da) * make_signed(minor(db, dc));
  det += lift(db) * make_signed(minor(dc, da));
  det += lift(dc) * make_signed(minor(da, db));
  return det.sign();
}

int in_circumball_exact(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, const Vec<3>& e) {
  const Differences<3, 4> to({&a, &b, &c, &d}, e);
  if (!to.fit) return in_circumball(a, b, c, d, e);
  const auto& [da, db, dc, dd] = to.d;
  const Int128 ab = minor(da, db), bc = minor(db, dc), cd = minor(dc, dd), ac = minor(da, dc), bd = minor(db, dd),
               ad = minor(da, dd);
  const Signed<3> abc = combine(da[2], bc, db[2], -ac, dc[2], ab).value();
  const Signed<3> bcd = combine(db[2], cd, dc[2], -bd, dd[2], bc).value();
  const Signed<3> acd = combine(da[2], cd, dc[2], -ad, dd[2], ac).value();
  const Signed<3> abd = combine(da[2], bd, db[2], -ad, dd[2], ab).value();
  Sum<5> det;
  det += bcd * lift(da);
  det -= acd * lift(db);
  det += abd * lift(dc);
  det -= abc * lift(dd);
  return det.sign();
}

}  // namespace voropack
