#include "spacing/polytope_set.h"

#include <algorithm>

#include "base/random.h"

namespace voropack {

namespace {

/// Facets with more triangles than this have a tree of their own for distances to them.
constexpr std::uint32_t kSmallFacet = 12;

/// True iff two sorted ranges share an element. A short one is looked up in a long one.
bool share_element(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) {
  if (a.size() > b.size()) std::swap(a, b);
  if (a.size() * 8 < b.size())
    return std::any_of(a.begin(), a.end(), [&](std::uint32_t i) { return std::binary_search(b.begin(), b.end(), i); });
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (a[i] == b[j]) return true;
    if (a[i] < b[j])
      ++i;
    else
      ++j;
  }
  return false;
}

}  // namespace

template <int D>
PolytopeSet<D>::PolytopeSet(const Domain<D>& domain)
    : n_points_(static_cast<std::uint32_t>(domain.points.size())),
      n_segments_(static_cast<std::uint32_t>(domain.segments.size())) {
  item_begin_.push_back(0);
  const auto corner = [&](PointId p) { return domain.points[p]; };
  for (PointId p : ids(domain.points)) add_polytope({{corner(p)}, 0});
  for (SegmentId s : ids(domain.segments))
    add_polytope({{corner(domain.segments[s][0]), corner(domain.segments[s][1])}, 1});
  if constexpr (D == 3) {
    for (FacetId f : ids(domain.facet_frame)) {
      Box<D> box;
      for (const auto& t : domain.facet_triangles[f]) {
        items_.push_back({{corner(t[0]), corner(t[1]), corner(t[2])}, 2});
        item_owner_.push_back(of_facet(f));
        box.add(items_.back().box());
      }
      item_begin_.push_back(static_cast<std::uint32_t>(items_.size()));
      polytope_box_.push_back(box);
    }
  }
  build_closures(domain);
  build_cofaces(domain);
  build_trees();
}

template <int D>
void PolytopeSet<D>::add_polytope(const SmallSimplex<D>& simplex) {
  item_owner_.push_back(static_cast<std::uint32_t>(item_begin_.size() - 1));
  items_.push_back(simplex);
  item_begin_.push_back(static_cast<std::uint32_t>(items_.size()));
  polytope_box_.push_back(simplex.box());
}

template <int D>
void PolytopeSet<D>::build_closures(const Domain<D>& domain) {
  closure_begin_.push_back(0);
  const auto end_row = [&] {
    std::sort(closure_.begin() + static_cast<std::ptrdiff_t>(closure_begin_.back()), closure_.end());
    std::uint64_t mask = 0;
    for (std::size_t i = closure_begin_.back(); i < closure_.size(); ++i)
      mask |= std::uint64_t{1} << (mix64(closure_[i]) & 63U);
    closure_mask_.push_back(mask);
    closure_begin_.push_back(closure_.size());
  };
  for (PointId p : ids(domain.points)) {
    closure_.push_back(p.value());
    end_row();
  }
  for (const auto& ends : domain.segments) {
    closure_.push_back(ends[0].value());
    closure_.push_back(ends[1].value());
    end_row();
  }
  for (FacetId f : ids(domain.facet_frame)) {
    for (PointId p : domain.facet_points[f]) closure_.push_back(p.value());
    end_row();
  }
}

template <int D>
void PolytopeSet<D>::build_cofaces(const Domain<D>& domain) {
  // Counted, then filled: row p lists segments before facets.
  const auto for_each_incidence = [&](auto&& visit) {
    for (SegmentId s : ids(domain.segments))
      for (PointId p : domain.segments[s]) visit(of_point(p), of_segment(s));
    for (FacetId f : ids(domain.facet_frame)) {
      for (PointId p : domain.facet_points[f]) visit(of_point(p), of_facet(f));
      for (SegmentId s : domain.facet_segments[f]) visit(of_segment(s), of_facet(f));
    }
  };
  coface_begin_.assign(n_polytopes() + 1, 0);
  for_each_incidence([&](std::uint32_t low, std::uint32_t) { ++coface_begin_[low + 1]; });
  for (std::size_t p = 0; p < n_polytopes(); ++p) coface_begin_[p + 1] += coface_begin_[p];
  coface_.resize(coface_begin_.back());
  std::vector<std::uint64_t> next(coface_begin_.begin(), coface_begin_.end() - 1);
  for_each_incidence([&](std::uint32_t low, std::uint32_t high) { coface_[next[low]++] = high; });
}

template <int D>
void PolytopeSet<D>::build_trees() {
  std::vector<Box<D>> boxes;
  boxes.reserve(items_.size());
  for (const auto& simplex : items_) boxes.push_back(simplex.box());
  tree_ = BoxTree<D>(boxes);
  if constexpr (D == 3) {
    facet_tree_.resize(n_polytopes());
    for (std::uint32_t p = 0; p < n_polytopes(); ++p) {
      const std::uint32_t begin = item_begin_[p];
      const std::uint32_t count = item_begin_[p + 1] - begin;
      if (count > kSmallFacet)
        facet_tree_[p] = std::make_unique<BoxTree<D>>(std::span<const Box<D>>(boxes).subspan(begin, count));
    }
  }
}

template <int D>
bool PolytopeSet<D>::disjoint(std::uint32_t p, std::uint32_t q) const {
  if ((closure_mask_[p] & closure_mask_[q]) == 0) return true;
  const auto closure = [&](std::uint32_t r) {
    return std::span<const std::uint32_t>(closure_).subspan(closure_begin_[r],
                                                            closure_begin_[r + 1] - closure_begin_[r]);
  };
  return !share_element(closure(p), closure(q));
}

template <int D>
bool PolytopeSet<D>::is_maximal_pair(std::uint32_t p, std::uint32_t q) const {
  if (!disjoint(p, q)) return false;
  const auto has_disjoint_coface = [&](std::uint32_t low, std::uint32_t other) {
    for (std::uint64_t i = coface_begin_[low]; i < coface_begin_[low + 1]; ++i)
      if (disjoint(coface_[i], other)) return true;
    return false;
  };
  return !has_disjoint_coface(p, q) && !has_disjoint_coface(q, p);
}

template <int D>
double PolytopeSet<D>::distance_to(std::uint32_t p, const Vec<D>& x) const {
  const std::uint32_t begin = item_begin_[p];
  const std::uint32_t end = item_begin_[p + 1];
  double best = std::numeric_limits<double>::infinity();
  if (end - begin > kSmallFacet)
    return facet_tree_[p]->minimize(x, 1.0, best, [&](std::uint32_t i) { return item_distance(begin + i, x); });
  for (std::uint32_t i = begin; i < end; ++i) best = std::min(best, item_distance(i, x));
  return best;
}

template <int D>
double PolytopeSet<D>::distance_between(std::uint32_t p, std::uint32_t q) const {
  if (item_begin_[p + 1] - item_begin_[p] > item_begin_[q + 1] - item_begin_[q]) std::swap(p, q);
  const std::uint32_t begin = item_begin_[q];
  const std::uint32_t end = item_begin_[q + 1];
  double best = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = item_begin_[p]; i < item_begin_[p + 1]; ++i) {
    const Box<D> near = items_[i].box();
    const auto consider = [&](std::uint32_t j) {
      if (box_distance(near, items_[j].box()) < best)
        best = std::min(best, distance_between_disjoint(items_[i], items_[j]));
    };
    if (end - begin > kSmallFacet)
      facet_tree_[q]->for_each([&](const Box<D>& box) { return box_distance(near, box) < best; },
                               [&](std::uint32_t j) { consider(begin + j); });
    else
      for (std::uint32_t j = begin; j < end; ++j) consider(j);
  }
  return best;
}

template class PolytopeSet<2>;
template class PolytopeSet<3>;

}  // namespace voropack
