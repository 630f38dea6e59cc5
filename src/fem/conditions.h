// The conditions of a problem on the hull faces of a mesh, and on patches inside.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "solve/coefficients.h"
#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/mesh.h"

namespace voropack {

/// What enters a face is inflow - transfer u, tested with its hat functions.
template <int D>
struct FaceTerms {
  std::array<double, D> inflow{};
  std::array<std::array<double, D>, D> transfer{};
};

/// What enters through the boundary for one solution. A patch's area is the integral of its vertex's hat function.
template <int D>
struct PatchFlows {
  BoundaryAreas<D> boundary;
  IdVector<PatchId, PatchTerm> terms;  ///< Whether they are fixed, no more.
  IdVector<PatchId, double> inflow;    ///< 0 at fixed patches.
};

template <int D>
class Conditions {
 public:
  /// Throws InputError solve.unknown_marker. The mesh and the conditions have to stay where they are.
  Conditions(const Mesh<D>& mesh, const std::map<int, BoundaryCondition<D>>& conditions);

  /// The first Dirichlet value of a vertex stays: that of the smallest marker.
  void add_to(LinearSystem& system) const;

  [[nodiscard]] PatchFlows<D> flows(const IdVector<VertexId, double>& values) const;

 private:
  struct Face {
    BoundaryId id;
    int region;
  };
  [[nodiscard]] FaceTerms<D> face_terms(BoundaryId b, const BoundaryCondition<D>& condition) const;
  [[nodiscard]] PatchTerm patch_term(PatchId p, const BoundaryCondition<D>& condition) const;
  [[nodiscard]] const BoundaryCondition<D>* condition_of(int marker) const;
  [[nodiscard]] std::array<Vec<D>, D> corners_of(BoundaryId b) const;
  [[nodiscard]] bool is_inner(PatchId p) const { return !faces_.contains(inner_.patch_marker[p]); }
  void for_each_point(BoundaryId b, const auto& visit) const;
  void add_face(BoundaryId b, const BoundaryCondition<D>& condition, LinearSystem& system) const;
  void add_patch(PatchId p, const BoundaryCondition<D>& condition, LinearSystem& system) const;
  void fix(VertexId v, const Dirichlet<D>& condition, LinearSystem& system) const;

  const Mesh<D>& mesh_;
  const std::map<int, BoundaryCondition<D>>& conditions_;
  std::map<int, std::vector<Face>> faces_;  ///< Of the hull, by marker.
  std::map<int, double> marker_area_;       ///< Of these faces and of the markers inside.
  BoundaryAreas<D> inner_;                  ///< Patches of the other markers, and of the hull.
};

}  // namespace voropack
