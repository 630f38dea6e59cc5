// Strong 32-bit ids, vectors indexed by them, and compressed rows (CSR) for variable-length data.
#pragma once

#include <cassert>
#include <compare>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace voropack {

/// A 32-bit index that converts from and to no other kind of index. `Id::none()` stands for "there is none".
template <class Tag>
class Id {
 public:
  using value_type = std::uint32_t;
  constexpr Id() = default;
  constexpr explicit Id(std::size_t value) : value_(static_cast<value_type>(value)) {}
  static constexpr Id none() { return Id{}; }

  [[nodiscard]] constexpr value_type value() const { return value_; }
  [[nodiscard]] constexpr bool is_none() const { return value_ == kNone; }
  constexpr Id& operator++() {
    ++value_;
    return *this;
  }
  friend constexpr auto operator<=>(Id, Id) = default;

 private:
  static constexpr value_type kNone = std::numeric_limits<value_type>::max();
  value_type value_ = kNone;
};

using PointId = Id<struct PointTag>;        ///< A 0-polytope of a Domain.
using SegmentId = Id<struct SegmentTag>;    ///< A 1-polytope of a Domain.
using FacetId = Id<struct FacetTag>;        ///< A 2-polytope of a Domain<3>.
using RegionId = Id<struct RegionTag>;      ///< A D-polytope of a Domain<D>: a connected volume (3D) or area (2D).
using SphereId = Id<struct SphereTag>;      ///< An f-sphere of a Packing.
using VertexId = Id<struct VertexTag>;      ///< A corner of a Mesh.
using SimplexId = Id<struct SimplexTag>;    ///< A D-simplex of a Mesh<D>.
using BoundaryId = Id<struct BoundaryTag>;  ///< A (D-1)-simplex of a Mesh<D> on its boundary or on an interface.
using EdgeId = Id<struct EdgeTag>;          ///< An edge of a Mesh<3> that is part of a segment of the domain.
using CellId = Id<struct CellTag>;          ///< The part of one vertex's Voronoi cell that lies in one region.
using DualFaceId = Id<struct DualFaceTag>;  ///< The part of one Voronoi face that lies in one region.

/// A std::vector that is indexed by one kind of id only.
template <class I, class T>
class IdVector {
 public:
  using Index = I;
  IdVector() = default;
  explicit IdVector(std::size_t n, const T& value = T{}) : values_(n, value) {}
  explicit IdVector(std::vector<T> values) : values_(std::move(values)) {}

  T& operator[](I id) {
    assert(id.value() < values_.size());
    return values_[id.value()];
  }
  const T& operator[](I id) const {
    assert(id.value() < values_.size());
    return values_[id.value()];
  }

  /// Appends and returns the id of the new entry.
  I push_back(T value) {
    values_.push_back(std::move(value));
    return I(values_.size() - 1);
  }

  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  void resize(std::size_t n, const T& value = T{}) { values_.resize(n, value); }
  void reserve(std::size_t n) { values_.reserve(n); }
  void clear() { values_.clear(); }
  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }
  T& back() { return values_.back(); }
  const T& back() const { return values_.back(); }
  std::vector<T>& raw() { return values_; }
  const std::vector<T>& raw() const { return values_; }
  friend bool operator==(const IdVector&, const IdVector&) = default;

 private:
  std::vector<T> values_;
};

/// The ids 0 .. n-1 as a range: `for (VertexId v : ids<VertexId>(n))`.
template <class I>
class IdRange {
 public:
  class iterator {
   public:
    explicit iterator(std::size_t i) : i_(i) {}
    I operator*() const { return I(i_); }
    iterator& operator++() {
      ++i_;
      return *this;
    }
    friend bool operator==(iterator, iterator) = default;

   private:
    std::size_t i_;
  };
  explicit IdRange(std::size_t n) : n_(n) {}
  [[nodiscard]] iterator begin() const { return iterator(0); }
  [[nodiscard]] iterator end() const { return iterator(n_); }

 private:
  std::size_t n_;
};

template <class I>
IdRange<I> ids(std::size_t n) {
  return IdRange<I>(n);
}

template <class I, class T>
IdRange<I> ids(const IdVector<I, T>& v) {
  return IdRange<I>(v.size());
}

/// Rows of variable length: row r holds values[offsets[r]] .. values[offsets[r + 1] - 1]. Offsets have 64 bits.
template <class I, class T>
struct Csr {
  std::vector<std::uint64_t> offsets = {0};  ///< [n_rows + 1], offsets[0] == 0.
  std::vector<T> values;                     ///< [offsets[n_rows]]

  [[nodiscard]] std::size_t size() const { return offsets.size() - 1; }
  std::span<const T> operator[](I row) const {
    return {values.data() + offsets[row.value()], values.data() + offsets[row.value() + 1]};
  }
  std::span<T> operator[](I row) {
    return {values.data() + offsets[row.value()], values.data() + offsets[row.value() + 1]};
  }
  /// Appends a row.
  template <class Range>
  void push_row(const Range& row) {
    values.insert(values.end(), std::begin(row), std::end(row));
    offsets.push_back(values.size());
  }
  friend bool operator==(const Csr&, const Csr&) = default;
};

}  // namespace voropack

template <class Tag>
struct std::hash<voropack::Id<Tag>> {
  std::size_t operator()(voropack::Id<Tag> id) const noexcept { return std::hash<std::uint32_t>{}(id.value()); }
};
