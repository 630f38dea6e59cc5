// The faces of a mesh, found by their vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "voropack/mesh.h"

namespace voropack {

/// A face's vertices, sorted, and the side of it that one looks from: 0 if the face followed by a point there is
/// positively oriented when the face is given with its vertices in ascending order, 1 if not.
template <int D>
struct SeenFace {
  std::array<VertexId, D> vertices;
  std::size_t side;
};

/// The face that is positively oriented when followed by a point on the side that is meant.
template <int D>
SeenFace<D> seen_face(std::array<VertexId, D> face) {
  const bool is_odd = sort_vertices(face);
  return {face, is_odd ? 1U : 0U};
}

/// The simplices beside each face of a mesh. Overlapping simplices may lie on the same side of a face.
template <int D>
class FaceTable {
 public:
  struct Sides {
    std::array<SimplexId, 2> simplex = {SimplexId::none(), SimplexId::none()};  ///< By side; the last one there.
    std::uint32_t n_simplices = 0;
  };

  explicit FaceTable(const Mesh<D>& mesh) : table_((D + 1) * mesh.simplex_vertices.size()) {
    for (const SimplexId s : ids(mesh.simplex_vertices))
      for (int i = 0; i <= D; ++i) {
        const auto [face, side] = seen_face<D>(face_vertices(mesh, s, i));
        std::uint32_t index = table_.insert(face, static_cast<std::uint32_t>(sides_.size()));
        if (index == table_.kAbsent) {
          index = static_cast<std::uint32_t>(sides_.size());
          sides_.emplace_back();
        }
        sides_[index].simplex[side] = s;
        ++sides_[index].n_simplices;
      }
  }

  /// Null if no simplex has the face.
  [[nodiscard]] const Sides* find(const std::array<VertexId, D>& face) const {
    const std::uint32_t index = table_.find(face);
    return index == table_.kAbsent ? nullptr : &sides_[index];
  }

 private:
  VertexSetTable<D> table_;
  std::vector<Sides> sides_;
};

}  // namespace voropack
