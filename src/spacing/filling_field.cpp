#include "spacing/filling_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geom/polytope_distance.h"
#include "spacing/affine_envelope.h"
#include "spacing/hat_gradients.h"

namespace voropack {

namespace {

/// Values at corners may differ by so much more than is Lipschitz: rounding.
constexpr double kLipschitzSlack = 1e-9;

}  // namespace

template <int D>
bool is_lipschitz(const std::array<Vec<D>, D + 1>& corners, const std::array<double, D + 1>& values, double slope) {
  for (std::size_t i = 0; i <= D; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::abs(values[i] - values[j]) > slope * (1 + kLipschitzSlack) * distance(corners[i], corners[j]))
        return false;
  return true;
}

template <int D>
FillingField<D>::FillingField(const Mesh<D>& mesh, std::vector<double> values_at_points, double slope)
    : points_(mesh.points),
      values_(std::move(values_at_points)),
      slope_(slope),
      simplices_(mesh.simplex_vertices.begin(), mesh.simplex_vertices.end()) {
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    const auto& vertices = mesh.simplex_vertices[s];
    if (is_steep(vertices)) steep_.push_back(vertices);
    for (std::size_t i = 0; i <= D; ++i) {
      if (!mesh.simplex_neighbors[s][i].is_none()) continue;
      std::array<VertexId, D> face;
      for (std::size_t k = 0; k < D; ++k) face[k] = vertices[(i + 1 + k) % (D + 1)];
      outer_.push_back(face);
    }
  }
  tree_ = build_tree(simplices_);
  steep_tree_ = build_tree(steep_);
  outer_tree_ = build_tree(outer_);
  const auto& nodes = tree_.nodes();
  largest_.assign(nodes.size(), 0);
  for (std::size_t i = nodes.size(); i-- > 0;) {  // Children come after their parents.
    if (nodes[i].count == 0) largest_[i] = std::max(largest_[nodes[i].first], largest_[nodes[i].first + 1]);
    for (const std::uint32_t s : tree_.items(nodes[i]))
      largest_[i] = std::max(largest_[i], std::ranges::max(values(simplices_[s])));
  }
  find_dips();
}

template <int D>
void FillingField<D>::find_dips() {
  has_dip_.assign(simplices_.size(), 0);
  const auto* const first = tree_.nodes().data();
  for (const auto& steep : steep_) {
    const Box<D> at = box(steep);
    const double least = std::ranges::min(values(steep));
    tree_.for_each_below(
        [&](const typename BoxTree<D>::Node& node) {
          return least + slope_ * box_distance(at, node.box) < largest_[static_cast<std::size_t>(&node - first)];
        },
        [&](std::uint32_t s) {
          if (least + slope_ * box_distance(at, box(simplices_[s])) < std::ranges::max(values(simplices_[s])))
            has_dip_[s] = 1;
        });
  }
}

template <int D>
template <std::size_t N>
std::array<Vec<D>, N> FillingField<D>::corners(const std::array<VertexId, N>& vertices) const {
  std::array<Vec<D>, N> x;
  for (std::size_t i = 0; i < N; ++i) x[i] = points_[vertices[i]];
  return x;
}

template <int D>
template <std::size_t N>
std::array<double, N> FillingField<D>::values(const std::array<VertexId, N>& vertices) const {
  std::array<double, N> v;
  for (std::size_t i = 0; i < N; ++i) v[i] = values_[vertices[i].value()];
  return v;
}

template <int D>
template <std::size_t N>
Box<D> FillingField<D>::box(const std::array<VertexId, N>& vertices) const {
  Box<D> result;
  for (const VertexId v : vertices) result.add(points_[v]);
  return result;
}

template <int D>
template <std::size_t N>
BoxTree<D> FillingField<D>::build_tree(const std::vector<std::array<VertexId, N>>& simplices) const {
  std::vector<Box<D>> boxes;
  std::vector<double> least;
  for (const auto& vertices : simplices) {
    boxes.push_back(box(vertices));
    least.push_back(std::ranges::min(values(vertices)));
  }
  return BoxTree<D>(boxes, least);
}

template <int D>
bool FillingField<D>::is_steep(const std::array<VertexId, D + 1>& simplex) const {
  const auto hats = hat_gradients(corners(simplex));
  const auto value = values(simplex);
  Vec<D> gradient{};
  for (std::size_t k = 0; k < D; ++k) gradient += (value[k + 1] - value[0]) * hats[k];
  return !(norm_sq(gradient) <= slope_ * slope_);
}

template <int D>
std::optional<double> FillingField<D>::inside(const std::array<VertexId, D + 1>& simplex, const Vec<D>& x) const {
  const auto corner = corners(simplex);
  const auto hats = hat_gradients(corner);
  const Vec<D> to = x - corner[0];
  const auto value = values(simplex);
  double first = 1, at_x = value[0];
  for (std::size_t k = 0; k < D; ++k) {
    const double lambda = dot(hats[k], to);
    if (!(lambda >= -kInsideSlack)) return std::nullopt;
    first -= lambda;
    at_x += lambda * (value[k + 1] - value[0]);
  }
  if (!(first >= -kInsideSlack)) return std::nullopt;
  return std::clamp(at_x, std::ranges::min(value), std::ranges::max(value));
}

template <int D>
template <std::size_t N>
double FillingField<D>::envelope(const std::array<VertexId, N>& simplex, const Vec<D>& x, double bound) const {
  const auto value = values(simplex);
  if (!(std::ranges::min(value) + slope_ * std::sqrt(box(simplex).distance_sq(x)) < bound)) return bound;
  if constexpr (N == D)
    return std::min(bound, affine_envelope_of_face<D>(corners(simplex), value, slope_, x));
  else
    return std::min(bound, affine_envelope<D>(corners(simplex), value, slope_, x));
}

// Let y be where the envelope over all simplices is attained. On the straight way from y to x the linear function of a
// simplex that is not steep falls by no more than the way is long: so y may as well be x, or lie in a steep one, or on
// an outer face if x is outside.
template <int D>
double FillingField<D>::at(const Vec<D>& x) const {
  double bound = std::numeric_limits<double>::infinity();
  bool may_dip = false;
  const bool is_inside = tree_.find([&](const Box<D>& node) { return node.contains(x); },
                                    [&](std::uint32_t s) {
                                      const std::optional<double> value = inside(simplices_[s], x);
                                      if (value) bound = *value, may_dip = has_dip_[s] != 0;
                                      return value.has_value();
                                    });
  if (is_inside && !may_dip) return bound;
  const auto over = [&](const auto& simplices) {
    return [&](std::uint32_t i) { return bound = envelope(simplices[i], x, bound); };
  };
  if (!is_inside) outer_tree_.minimize(x, slope_, bound, over(outer_));
  return steep_tree_.minimize(x, slope_, bound, over(steep_));
}

template <int D>
std::optional<double> FillingField<D>::constant_on(const Box<D>& box) const {
  std::optional<double> constant;
  const bool varies = tree_.find([&](const Box<D>& other) { return other.overlaps(box); },
                                 [&](std::uint32_t s) {
                                   if (!this->box(simplices_[s]).overlaps(box)) return false;
                                   const auto value = values(simplices_[s]);
                                   if (!constant) constant = value[0];
                                   return std::ranges::any_of(value, [&](double v) { return v != *constant; });
                                 });
  return varies ? std::nullopt : constant;
}

template <int D>
Interval FillingField<D>::range(const Box<D>& box) const {
  Interval range = {std::numeric_limits<double>::infinity(), 0};
  const auto& nodes = tree_.nodes();
  const auto is_news = [&](const typename BoxTree<D>::Node& node) {
    const double most = largest_[static_cast<std::size_t>(&node - nodes.data())];
    return (node.value < range.lo || most > range.hi) && node.box.overlaps(box);
  };
  tree_.for_each_below(is_news, [&](std::uint32_t s) {
    if (!this->box(simplices_[s]).overlaps(box)) return;
    const auto value = values(simplices_[s]);
    range = {std::min(range.lo, std::ranges::min(value)), std::max(range.hi, std::ranges::max(value))};
  });
  return range.hi > 0 ? range : Interval{0, std::numeric_limits<double>::infinity()};
}

#define VOROPACK_INSTANTIATE(D)                                                                              \
  template bool is_lipschitz<D>(const std::array<Vec<D>, D + 1>&, const std::array<double, D + 1>&, double); \
  template class FillingField<D>;
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
