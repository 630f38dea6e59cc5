// User sizes as a family of Lipschitz functions ("atoms") whose minimum is the sizing part of f.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geom/box_tree.h"
#include "spacing/filling_field.h"
#include "spacing/polytope_set.h"
#include "spacing/region_locator.h"
#include "voropack/domain.h"

namespace voropack {

/// A function value + slope * (distance from x to a set), or the envelope of an affine function on a simplex, whose
/// least value `value` is. In both cases it is at least value + slope * (distance from x to the atom's box).
struct SizeAtom {
  enum class Kind : std::uint8_t {
    kItem,     ///< Distance to item `index` of the polytopes.
    kBox,      ///< Distance to box `index`.
    kTube,     ///< Distance to tube `index`.
    kSimplex,  ///< Envelope on simplex `index` of the size field.
  };
  double value;
  Kind kind;
  std::uint32_t index;
};

/// What is within a distance of a segment.
template <int D>
struct SegmentTube {
  Vec<D> a, b;
  double radius;
};

/// A simplex of the size field with values of f at its corners.
template <int D>
struct FieldSimplex {
  std::array<Vec<D>, D + 1> corner;
  std::array<double, D + 1> value;
};

/// The same with its affine function.
template <int D>
struct AffineSimplex : FieldSimplex<D> {
  std::array<Vec<D>, D> hat_gradient{};  ///< Of the hat functions of corners 1 .. D.
  Vec<D> gradient{};
  bool is_gentle = false;  ///< The affine function is Lipschitz.
  bool is_local = false;   ///< Its corner values are, pairwise.
};

/// A value that holds throughout a region's closure. Its continuation outside is one atom for each wall item.
struct RegionValue {
  double value;
  RegionId region;
  friend auto operator<=>(const RegionValue&, const RegionValue&) = default;
};

/// Refers to `polytopes` and `locator`, which must outlive it. Fill, then `finish`.
template <int D>
class SizeAtoms {
 public:
  SizeAtoms(const PolytopeSet<D>& polytopes, const RegionLocator<D>& locator, double slope)
      : polytopes_(&polytopes), locator_(&locator), slope_(slope) {}

  void add_item(double value, std::uint32_t item) { atoms_.push_back({value, SizeAtom::Kind::kItem, item}); }
  void add_polytope(double value, std::uint32_t polytope);
  void add_region(double value, RegionId region);
  void add_box(double value, const Box<D>& box);
  void add_tube(double value, const SegmentTube<D>& tube);
  /// Where the values at the corners of a simplex are Lipschitz, the field is taken to be so by itself around it: then
  /// the simplex is *local*, and matters at its own points only.
  void add_simplex(const FieldSimplex<D>& simplex);
  void add_field(FillingField<D> field) { fields_.push_back(std::move(field)); }
  /// Drops repetitions and builds the search tree.
  void finish();

  [[nodiscard]] double slope() const { return slope_; }
  [[nodiscard]] std::size_t size() const { return atoms_.size(); }
  [[nodiscard]] const SizeAtom& atom(std::uint32_t i) const { return atoms_[i]; }
  [[nodiscard]] Box<D> atom_box(std::uint32_t i) const;
  [[nodiscard]] double at(std::uint32_t i, const Vec<D>& x) const;
  [[nodiscard]] bool is_local(std::uint32_t i) const {
    return atoms_[i].kind == SizeAtom::Kind::kSimplex && simplices_[atoms_[i].index].is_local;
  }
  /// The value at a point of a local atom; nothing if x is outside of it.
  [[nodiscard]] std::optional<double> inside(std::uint32_t i, const Vec<D>& x) const;
  /// What `at` is between. Of local atoms, for less than `at` costs; of others exact.
  [[nodiscard]] Interval bounds(std::uint32_t i, const Vec<D>& x) const;
  /// By value, the least first.
  [[nodiscard]] const std::vector<RegionValue>& regions() const { return regions_; }
  [[nodiscard]] const RegionLocator<D>& locator() const { return *locator_; }
  [[nodiscard]] const std::vector<FillingField<D>>& fields() const { return fields_; }
  /// The least of `bound` and all fields at x.
  [[nodiscard]] double fields_minimum(const Vec<D>& x, double bound) const {
    for (const FillingField<D>& field : fields_) bound = std::min(bound, field.at(x));
    return bound;
  }
  /// The value of the field in a box, if there is one field and it has one value there.
  [[nodiscard]] std::optional<double> fields_constant(const Box<D>& box) const {
    return fields_.size() == 1 ? fields_[0].constant_on(box) : std::nullopt;
  }
  /// The least of `bound`, all atoms, region values and fields at x.
  [[nodiscard]] double minimum(const Vec<D>& x, double bound) const;

 private:
  const PolytopeSet<D>* polytopes_;
  const RegionLocator<D>* locator_;
  double slope_;
  std::vector<SizeAtom> atoms_;
  std::vector<Box<D>> boxes_;
  std::vector<SegmentTube<D>> tubes_;
  std::vector<AffineSimplex<D>> simplices_;
  std::vector<RegionValue> regions_;
  std::vector<FillingField<D>> fields_;
  BoxTree<D> tree_;
};

}  // namespace voropack
