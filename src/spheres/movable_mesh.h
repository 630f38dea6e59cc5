// A Delaunay triangulation in which single vertices come, go and move on trial: each change can be taken back.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "voropack/packing.h"
#include "voropack/vec.h"

namespace voropack {

/// Made from a triangulation of regions whose hull and walls are protected: their faces have empty diametral balls, and
/// no point in one of these may be inserted. Then no change reaches across a wall.
///
/// Changes add simplices at the end and mark others as gone, so that `undo` has little to do.
template <int K>
class MovableMesh {
 public:
  static constexpr std::uint32_t kNone = Triangulation<K>::kNoNeighbor;
  using Corners = std::array<std::uint32_t, K + 1>;
  struct Simplex {
    Corners corner;    ///< Positively oriented.
    Corners neighbor;  ///< Entry i is opposite to corner i; kNone at the hull.
    int region = 0;
    bool is_alive = true;
  };
  /// How far the changes have come.
  struct Mark {
    std::size_t n_points, n_simplices, n_killed, n_links;
  };

  MovableMesh(std::vector<Vec<K>> points, const Triangulation<K>& triangulation);

  [[nodiscard]] const std::vector<Vec<K>>& points() const { return points_; }
  [[nodiscard]] std::size_t size() const { return simplices_.size(); }
  [[nodiscard]] const Simplex& operator[](std::uint32_t s) const { return simplices_[s]; }
  [[nodiscard]] std::array<Vec<K>, K + 1> corners(std::uint32_t s) const;

  /// Inserts x, which is looked for from simplex `near` on. Nothing changes, and the answer is false, if x is outside
  /// or a new simplex would be flat. The new vertex is the last of points().
  bool insert(const Vec<K>& x, std::uint32_t near);
  /// Removes a corner of simplex `at`. Nothing changes, and the answer is false, if it is on the hull, or if
  /// cospherical points around it keep its place from being filled.
  bool remove(std::uint32_t vertex, std::uint32_t at);

  [[nodiscard]] Mark mark() const { return {points_.size(), simplices_.size(), killed_.size(), links_.size()}; }
  void undo(const Mark& mark);
  /// What was killed since then, new ones that did not last included.
  [[nodiscard]] std::vector<std::uint32_t> killed_since(const Mark& mark) const {
    return {killed_.begin() + static_cast<std::ptrdiff_t>(mark.n_killed), killed_.end()};
  }
  /// Makes the changes final.
  void commit() { killed_.clear(), links_.clear(); }

  /// The simplices that are there, numbered anew; corners are indices of points().
  [[nodiscard]] Triangulation<K> to_triangulation() const;

 private:
  /// A face of the part that is replaced: opposite to corner `face` of simplex `outside`, which may be kNone.
  struct Rim {
    std::array<std::uint32_t, K> corner;  ///< Sorted.
    std::uint32_t simplex, face;          ///< Inside.
  };
  struct Link {
    std::uint32_t simplex, face, before;
  };

  [[nodiscard]] bool holds(std::uint32_t s, const Vec<K>& x) const;
  [[nodiscard]] std::optional<std::uint32_t> locate(const Vec<K>& x, std::uint32_t near) const;
  [[nodiscard]] std::vector<Rim> rim_of(const std::vector<std::uint32_t>& part) const;
  /// Replaces `part` by simplices that share its rim.
  bool replace(const std::vector<std::uint32_t>& part, const std::vector<Corners>& by);

  std::vector<Vec<K>> points_;
  std::vector<Simplex> simplices_;
  std::vector<std::uint32_t> killed_;
  std::vector<Link> links_;  ///< Of simplices that stay.
};

}  // namespace voropack
