#include "spacing/size_atoms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "geom/polytope_distance.h"
#include "spacing/affine_envelope.h"
#include "spacing/hat_gradients.h"

namespace voropack {

template <int D>
void SizeAtoms<D>::add_polytope(double value, std::uint32_t polytope) {
  for (std::uint32_t i = polytopes_->first_item(polytope); i < polytopes_->first_item(polytope + 1); ++i)
    add_item(value, i);
}

template <int D>
void SizeAtoms<D>::add_region(double value, RegionId region) {
  regions_.push_back({value, region});
  for (std::uint32_t item : locator_->wall_items(region)) add_item(value, item);
}

template <int D>
void SizeAtoms<D>::add_box(double value, const Box<D>& box) {
  atoms_.push_back({value, SizeAtom::Kind::kBox, static_cast<std::uint32_t>(boxes_.size())});
  boxes_.push_back(box);
}

template <int D>
void SizeAtoms<D>::add_tube(double value, const SegmentTube<D>& tube) {
  atoms_.push_back({value, SizeAtom::Kind::kTube, static_cast<std::uint32_t>(tubes_.size())});
  tubes_.push_back(tube);
}

template <int D>
void SizeAtoms<D>::add_simplex(const FieldSimplex<D>& simplex) {
  const double least = *std::min_element(simplex.value.begin(), simplex.value.end());
  atoms_.push_back({least, SizeAtom::Kind::kSimplex, static_cast<std::uint32_t>(simplices_.size())});
  AffineSimplex<D> affine{simplex};
  affine.hat_gradient = hat_gradients(simplex.corner);
  if (std::ranges::all_of(affine.hat_gradient, [](const Vec<D>& g) { return std::isfinite(norm(g)); })) {
    for (std::size_t i = 0; i < D; ++i)
      affine.gradient += (simplex.value[i + 1] - simplex.value[0]) * affine.hat_gradient[i];
    affine.is_gentle = norm(affine.gradient) <= slope_;
    affine.is_local = is_lipschitz<D>(simplex.corner, simplex.value, slope_);
  }
  simplices_.push_back(affine);
}

template <int D>
void SizeAtoms<D>::finish() {
  // Walls between sized regions and marked polytopes appear more than once: keep the least value of each.
  const auto key = [](const SizeAtom& a) { return std::tuple(a.kind, a.index, a.value); };
  std::sort(atoms_.begin(), atoms_.end(), [&](const SizeAtom& a, const SizeAtom& b) { return key(a) < key(b); });
  const auto same = [](const SizeAtom& a, const SizeAtom& b) { return a.kind == b.kind && a.index == b.index; };
  atoms_.erase(std::unique(atoms_.begin(), atoms_.end(), same), atoms_.end());
  std::sort(regions_.begin(), regions_.end());
  std::vector<Box<D>> boxes;
  std::vector<double> values;
  for (std::uint32_t i = 0; i < atoms_.size(); ++i) {
    boxes.push_back(atom_box(i));
    values.push_back(atoms_[i].value);
  }
  tree_ = BoxTree<D>(boxes, values);
}

template <int D>
Box<D> SizeAtoms<D>::atom_box(std::uint32_t i) const {
  const std::uint32_t index = atoms_[i].index;
  switch (atoms_[i].kind) {
    case SizeAtom::Kind::kItem:
      return polytopes_->item(index).box();
    case SizeAtom::Kind::kBox:
      return boxes_[index];
    case SizeAtom::Kind::kTube: {
      Box<D> box(tubes_[index].a, tubes_[index].a);
      box.add(tubes_[index].b);
      box.inflate(tubes_[index].radius);
      return box;
    }
    default: {
      Box<D> box;
      for (const Vec<D>& corner : simplices_[index].corner) box.add(corner);
      return box;
    }
  }
}

template <int D>
double SizeAtoms<D>::at(std::uint32_t i, const Vec<D>& x) const {
  const SizeAtom& atom = atoms_[i];
  switch (atom.kind) {
    case SizeAtom::Kind::kItem:
      return atom.value + slope_ * polytopes_->item_distance(atom.index, x);
    case SizeAtom::Kind::kBox:
      return atom.value + slope_ * std::sqrt(boxes_[atom.index].distance_sq(x));
    case SizeAtom::Kind::kTube: {
      const SegmentTube<D>& tube = tubes_[atom.index];
      return atom.value + slope_ * std::max(0.0, distance_to_segment(x, tube.a, tube.b) - tube.radius);
    }
    default:
      return affine_envelope<D>(simplices_[atom.index].corner, simplices_[atom.index].value, slope_, x);
  }
}

template <int D>
std::optional<double> SizeAtoms<D>::inside(std::uint32_t i, const Vec<D>& x) const {
  const AffineSimplex<D>& s = simplices_[atoms_[i].index];
  const Vec<D> to = x - s.corner[0];
  double first = 1;
  for (const Vec<D>& g : s.hat_gradient) {
    const double lambda = dot(g, to);
    if (lambda < -kInsideSlack) return std::nullopt;
    first -= lambda;
  }
  if (first < -kInsideSlack) return std::nullopt;
  return s.is_gentle ? std::max(s.value[0] + dot(s.gradient, to), atoms_[i].value) : at(i, x);
}

template <int D>
Interval SizeAtoms<D>::bounds(std::uint32_t i, const Vec<D>& x) const {
  if (!is_local(i)) {
    const double value = at(i, x);
    return {value, value};
  }
  const AffineSimplex<D>& s = simplices_[atoms_[i].index];
  Interval value = {atoms_[i].value + slope_ * std::sqrt(atom_box(i).distance_sq(x)),
                    std::numeric_limits<double>::infinity()};
  // The value at y in the simplex is that of the affine function at x, and at most |gradient| |x - y| less.
  if (s.is_gentle) value.lo = std::max(value.lo, s.value[0] + dot(s.gradient, x - s.corner[0]));
  for (std::size_t k = 0; k <= D; ++k) value.hi = std::min(value.hi, s.value[k] + slope_ * distance(x, s.corner[k]));
  return value;
}

template <int D>
double SizeAtoms<D>::minimum(const Vec<D>& x, double bound) const {
  bound = tree_.minimize(x, slope_, fields_minimum(x, bound), [&](std::uint32_t i) { return at(i, x); });
  for (const RegionValue& r : regions_) {
    if (!(r.value < bound)) break;
    if (locator_->in_region(x, r.region)) return r.value;
  }
  return bound;
}

template class SizeAtoms<2>;
template class SizeAtoms<3>;

}  // namespace voropack
