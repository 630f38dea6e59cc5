#include "geom/expansion.h"

#include <cmath>
#include <utility>

namespace voropack {

void Expansion::reserve(std::size_t n) {
  if (n <= capacity_) return;
  std::unique_ptr<double[]> bigger(new double[n]);  // NOLINT: uninitialized on purpose.
  std::copy_n(data(), size_, bigger.get());
  heap_ = std::move(bigger);
  capacity_ = n;
}

// [Shewchuk1997], figure 15: sweeps down collecting each sum's head, then up, so that the terms end non-adjacent and
// the largest approximates the sum to an ulp.
void Expansion::compress() {
  if (size_ < 2) return;
  double* e = data();
  double head = e[size_ - 1];
  std::size_t bottom = size_ - 1;
  for (std::size_t i = size_ - 1; i-- > 0;) {
    const Dd s = fast_two_sum(head, e[i]);
    if (s.lo != 0) {
      e[bottom--] = s.hi;
      head = s.lo;
    } else {
      head = s.hi;
    }
  }
  std::size_t n = 0;
  for (std::size_t i = bottom + 1; i < size_; ++i) {
    const Dd s = fast_two_sum(e[i], head);
    if (s.lo != 0) e[n++] = s.lo;
    head = s.hi;
  }
  if (head != 0) e[n++] = head;
  size_ = n;
}

// Fast expansion sum: merge by magnitude, then one pass of two-sums. The inputs are non-adjacent, so they satisfy the
// theorem's condition (strongly nonoverlapping) and so does the output.
void Expansion::add(const Expansion& a, const Expansion& b, Expansion& out) {
  out.size_ = 0;
  out.reserve(a.size_ + b.size_ + 1);
  const double* x = a.data();
  const double* y = b.data();
  std::size_t i = 0, j = 0;
  double sum = 0;
  while (i < a.size_ || j < b.size_) {
    const bool take_x = j == b.size_ || (i < a.size_ && std::abs(x[i]) <= std::abs(y[j]));
    const Dd s = two_sum(sum, take_x ? x[i++] : y[j++]);
    if (s.lo != 0) out.data()[out.size_++] = s.lo;
    sum = s.hi;
  }
  if (sum != 0) out.data()[out.size_++] = sum;
}

// [Shewchuk1997], figure 13.
void Expansion::scale(std::span<const double> a, double b, Expansion& out) {
  out.size_ = 0;
  out.reserve(2 * a.size() + 1);
  const Dd sb = split(b);
  double carry = 0;
  for (const double term : a) {
    const Dd p = two_prod(term, b, sb);
    const Dd s = two_sum(carry, p.lo);
    if (s.lo != 0) out.data()[out.size_++] = s.lo;
    const Dd t = fast_two_sum(p.hi, s.hi);
    if (t.lo != 0) out.data()[out.size_++] = t.lo;
    carry = t.hi;
  }
  if (carry != 0) out.data()[out.size_++] = carry;
}

Expansion operator+(const Expansion& a, const Expansion& b) {
  if (a.size_ == 0) return b;
  if (b.size_ == 0) return a;
  Expansion out;
  Expansion::add(a, b, out);
  out.compress();
  return out;
}

Expansion operator*(const Expansion& a, const Expansion& b) {
  const Expansion& longer = a.size_ >= b.size_ ? a : b;
  const Expansion& shorter = a.size_ >= b.size_ ? b : a;
  Expansion out;
  for (const double term : shorter.terms()) {
    Expansion part;
    Expansion::scale(longer.terms(), term, part);
    part.compress();
    if (out.size_ == 0) {
      out = std::move(part);
    } else {
      Expansion sum;
      Expansion::add(out, part, sum);
      sum.compress();
      out = std::move(sum);
    }
  }
  return out;
}

Dd Expansion::approximate() const {
  // Compressed: the three largest terms hold 2 * 53 bits and more.
  Dd sum;
  for (std::size_t i = size_ > 3 ? size_ - 3 : 0; i < size_; ++i) sum = Dd(data()[i]) + sum;
  return sum;
}

}  // namespace voropack
