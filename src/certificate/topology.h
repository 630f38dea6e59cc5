// What the certificate believes about how simplices hang together: validated by itself, whatever the mesh claims.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "certificate/tally.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack::judge {

inline constexpr std::uint32_t kNone = 0xffffffffU;

/// Faults of the check `delaunay`, from harmless to basic.
enum DelaunayFault : int {
  kBallNotEmpty = 1,
  kOverlap,
  kNotPositive,
  kWrongNeighbor,
  kSharedFace,
  kRepeatedCorner,
  kInvalidCorner,
  kNoSimplices,
};

/// A (D-1)-simplex of the boundary complex: the ones that the mesh lists, in its order, then hull faces and interfaces
/// that it fails to list.
template <int D>
struct BoundaryFace {
  std::array<std::uint32_t, D> vertices{};
  int marker = 0;
  bool listed = false;
  bool valid = true;      ///< Corners exist, are finite and distinct.
  bool repeated = false;  ///< Listed before, with the same corners.
  /// The simplices on its sides, kNone where there is none, and the face's corner number there.
  std::array<std::uint32_t, 2> simplex{kNone, kNone};
  std::array<std::uint8_t, 2> corner{};

  [[nodiscard]] int n_sides() const { return (simplex[0] != kNone) + (simplex[1] != kNone); }
};

template <int D>
class Topology {
 public:
  /// Validates corners, uses the mesh's neighbors if they are right and builds its own if not. Faults go to `faults`
  /// (DelaunayFault kinds; ids: simplex, corner number or other simplex).
  Topology(const Mesh<D>& mesh, Tally& faults, const Observer& observer);

  [[nodiscard]] bool valid(std::size_t s) const { return (state_[s] & kInvalid) == 0; }
  [[nodiscard]] bool on_boundary(std::size_t s, int corner) const { return ((state_[s] >> corner) & 1U) != 0; }
  [[nodiscard]] std::uint32_t neighbor(std::size_t s, int corner) const {
    const SimplexId n = (*neighbors_)[SimplexId(s)][static_cast<std::size_t>(corner)];
    return n.is_none() ? kNone : n.value();
  }
  /// The corner of n that is opposite to its face with s, or -1.
  [[nodiscard]] int corner_towards(std::uint32_t n, std::size_t s) const {
    const auto& back = (*neighbors_)[SimplexId(n)];
    for (int j = 0; j <= D; ++j)
      if (back[static_cast<std::size_t>(j)] == SimplexId(s)) return j;
    return -1;
  }
  [[nodiscard]] int region(std::size_t s) const { return regions_ == nullptr ? 0 : (*regions_)[SimplexId(s)]; }
  /// A finite vertex that some valid simplex uses.
  [[nodiscard]] bool used(std::size_t v) const { return (vertex_state_[v] & kUsed) != 0; }
  [[nodiscard]] bool finite(std::size_t v) const { return (vertex_state_[v] & kFinite) != 0; }
  [[nodiscard]] const std::vector<BoundaryFace<D>>& boundary() const { return boundary_; }
  [[nodiscard]] std::array<Vec<D>, D + 1> corners(std::size_t s) const {
    const auto& v = mesh_.simplex_vertices[SimplexId(s)];
    if constexpr (D == 2)
      return {mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]]};
    else
      return {mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]], mesh_.points[v[3]]};
  }
  /// The smaller measure of floating point resolution: 16 ulp of the largest coordinate.
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] const Box<D>& box() const { return box_; }

 private:
  static constexpr std::uint8_t kInvalid = 0x80;
  static constexpr std::uint8_t kFinite = 1, kUsed = 2, kListed = 4;
  using Neighbors = IdVector<SimplexId, std::array<SimplexId, D + 1>>;
  struct FaceRef {
    std::array<std::uint32_t, D> key;
    std::uint32_t simplex;
    std::uint8_t corner;
    friend auto operator<=>(const FaceRef&, const FaceRef&) = default;
  };

  void read_vertices();
  void read_simplices(Tally& faults);
  void read_listed();
  bool check_neighbors(Tally& faults) const;
  void check_simplex_neighbors(std::size_t s, Tally& tally) const;
  void rebuild_neighbors(Tally& faults);
  [[nodiscard]] std::array<std::uint32_t, D> face_key(std::size_t s, int corner) const;
  [[nodiscard]] std::vector<FaceRef> boundary_candidates() const;
  [[nodiscard]] bool linked(const FaceRef& a, const FaceRef& b) const;
  bool match_boundary(Tally& faults);

  const Mesh<D>& mesh_;
  const Neighbors* neighbors_ = nullptr;
  const IdVector<SimplexId, int>* regions_ = nullptr;
  Neighbors own_neighbors_;
  std::vector<std::uint8_t> state_;         ///< [n_simplices] bit i: face i is in the boundary complex; kInvalid.
  std::vector<std::uint8_t> vertex_state_;  ///< [n_vertices]
  std::vector<BoundaryFace<D>> boundary_;
  std::size_t n_listed_ = 0;
  Box<D> box_;
  double resolution_ = 0;
};

}  // namespace voropack::judge
