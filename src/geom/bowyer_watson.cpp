#include "geom/bowyer_watson.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "base/parallel.h"
#include "geom/hilbert.h"
#include "geom/parallel_insertion.h"
#include "geom/predicates.h"
#include "voropack/error.h"

namespace voropack {

namespace {

/// Batches with hints up to this size are inserted as they come.
constexpr std::size_t kSmallBatch = 64;

template <int K>
std::vector<double> position(const Vec<K>& p) {
  return {p.coord.begin(), p.coord.end()};
}

template <int K>
std::string text(const Vec<K>& p) {
  return fmt::format("({})", fmt::join(p.coord, ", "));
}

/// True if a, b, c lie on a line, which is so if all their projections to coordinate planes do.
bool collinear(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    if (orientation(Vec<2>{a[k], a[l]}, Vec<2>{b[k], b[l]}, Vec<2>{c[k], c[l]}) != 0) return false;
  }
  return true;
}

}  // namespace

template <int K>
void BowyerWatson<K>::check_finite(std::span<const Vec<K>> points) const {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!voropack::is_finite(points[i]))
      throw InputError(Fault{.id = "delaunay.not_finite",
                             .message = "point " + std::to_string(n_vertices() + i) +
                                        " has a coordinate that is infinite or not a number: " + text(points[i]),
                             .fix = "give finite coordinates",
                             .position = position(points[i])});
}

/// Numbers the points of a batch by their place in `order`.
template <int K>
void BowyerWatson<K>::append_points(std::span<const Vec<K>> points, const std::vector<std::uint32_t>& order) {
  const std::uint32_t first_vertex = n_vertices();
  const std::size_t first = arrays_.points.size();
  number_.resize(first_vertex + points.size());
  arrays_.points.resize(first + points.size());
  arrays_.vertex.resize(arrays_.points.size());
  arrays_.vertex_slot.resize(arrays_.points.size(), Arrays::kEmpty);
  parallel_for(order.size(), [&](std::size_t place) {
    const std::uint32_t i = order[place];
    number_[first_vertex + i] = static_cast<std::uint32_t>(first + place);
    arrays_.vertex[first + place] = first_vertex + i;
    arrays_.points[first + place] = points[i];
  });
  for (const Vec<K>& p : points) box_.add(p);
  arrays_.predicates.set_box(box_);
}

/// Moves the first K + 1 points of `order` that do not lie in a hyperplane to its front and makes a simplex of them.
template <int K>
void BowyerWatson<K>::make_first_simplex(std::vector<std::uint32_t>& order) {
  const auto point = [&](std::size_t i) -> const Vec<K>& { return arrays_.points[order[i]]; };
  // Whether point i is not in the affine hull of points 0 .. n - 1 of the order.
  const auto independent = [&](std::size_t n, std::size_t i) {
    if (n == 1) return point(i) != point(0);
    if constexpr (K == 2) return orientation(point(0), point(1), point(i)) != 0;
    if constexpr (K == 3)
      return n == 2 ? !collinear(point(0), point(1), point(i))
                    : orientation(point(0), point(1), point(2), point(i)) != 0;
  };
  for (std::size_t n = 1; n <= K; ++n) {
    std::size_t i = n;
    while (i < order.size() && !independent(n, i)) ++i;
    if (i >= order.size())
      throw InputError(
          Fault{.id = "delaunay.degenerate",
                .message = "all " + std::to_string(order.size()) + " points lie in one " + (K == 2 ? "line" : "plane"),
                .fix = std::string("add a point outside of this ") + (K == 2 ? "line" : "plane")});
    std::swap(order[n], order[i]);
  }

  Corners corner;
  for (std::size_t i = 0; i <= K; ++i) corner[i] = order[i];
  const auto at = [&](std::size_t i) -> const Vec<K>& { return arrays_.points[corner[i]]; };
  int side = 0;
  if constexpr (K == 2) side = orientation(at(0), at(1), at(2));
  if constexpr (K == 3) side = orientation(at(0), at(1), at(2), at(3));
  if (side < 0) std::swap(corner[0], corner[1]);
  insertion_.last_slot = arrays_.make_first(corner);
}

/// Saves the copies of a growing array, which would be the peak of memory. Sets with more simplices than usual let the
/// arrays grow.
template <int K>
void BowyerWatson<K>::reserve_for(std::size_t n_points) {
  const std::size_t expected = expected_simplices<K>(n_points) + 64;
  arrays_.simplices.reserve(expected);
  arrays_.state.reserve(expected);
  arrays_.points.reserve(n_points + 1);
  arrays_.vertex.reserve(n_points + 1);
}

/// Inserts the vertices with the numbers in `schedule`: in rounds, each of ascending numbers, the large ones in
/// parallel.
template <int K>
void BowyerWatson<K>::insert_rounds(std::span<const std::uint32_t> schedule) {
  VertexInserter<K, WholeTriangulation> inserter(arrays_, insertion_);
  for (auto next = schedule.begin(); next != schedule.end();) {
    const auto end = std::is_sorted_until(next, schedule.end());
    const auto size = static_cast<std::size_t>(end - next);
    if (size < kLeastParallelRound<K>) {
      for (; next != end; ++next) inserter.insert(*next, insertion_.last_slot);
      continue;
    }
    const std::vector<std::uint32_t> left = insert_in_parallel<K>(arrays_, insertion_, {next, end});
    n_parallel_ += size - left.size();
    for (const std::uint32_t v : left) {
      const Slot near = slot_nearby(arrays_, v, [](std::uint32_t) { return true; });
      inserter.insert(v, near == Arrays::kEmpty ? insertion_.last_slot : near);
    }
    next = end;
  }
}

template <int K>
void BowyerWatson<K>::insert(std::span<const Vec<K>> points, std::span<const std::uint32_t> hints) {
  if (points.empty()) return;
  check_finite(points);
  const std::uint32_t first = n_vertices() + 1;
  const bool from_nothing = arrays_.simplices.empty();
  std::vector<std::uint32_t> order(points.size());
  if (!hints.empty() && points.size() <= kSmallBatch)
    std::iota(order.begin(), order.end(), 0U);
  else
    order = hilbert_order<K>(points);
  if (from_nothing) reserve_for(points.size());
  append_points(points, order);
  std::vector<std::uint32_t> schedule(points.size());
  if (hints.empty())
    schedule = insertion_rounds(points.size());
  else
    std::iota(schedule.begin(), schedule.end(), 0U);
  for (std::uint32_t& number : schedule) number += first;
  std::size_t n_done = 0;
  if (from_nothing) {
    try {
      make_first_simplex(schedule);
    } catch (const InputError&) {
      *this = BowyerWatson{};
      throw;
    }
    n_done = K + 1;
  }
  const auto rest = std::span<const std::uint32_t>(schedule).subspan(n_done);
  if (hints.empty()) {
    insert_rounds(rest);
    return;
  }
  VertexInserter<K, WholeTriangulation> inserter(arrays_, insertion_);
  for (const std::uint32_t v : rest) {
    const std::uint32_t hint = hints[order[v - first]];
    const Slot hinted = hint == kNoHint ? Arrays::kEmpty : slot_of_vertex(hint);
    inserter.insert(v, hinted == Arrays::kEmpty ? insertion_.last_slot : hinted);
  }
}

template <int K>
std::vector<typename BowyerWatson<K>::Slot> BowyerWatson<K>::take_created() {
  std::vector<Slot> created;
  created.reserve(insertion_.recreated.size() + (n_slots() - arrays_.first_new_slot));
  std::sort(insertion_.recreated.begin(), insertion_.recreated.end());
  for (const Slot slot : insertion_.recreated) {
    arrays_.state[slot] &= ~Arrays::kCreatedBit;
    if (is_alive(slot)) created.push_back(slot);
  }
  insertion_.recreated.clear();
  Slot& next = arrays_.first_new_slot;
  for (; next < n_slots(); ++next)
    if (is_alive(next)) created.push_back(next);
  return created;
}

template class BowyerWatson<2>;
template class BowyerWatson<3>;

}  // namespace voropack
