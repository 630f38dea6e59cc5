// From what a mesh file lists to a Mesh with all its invariants.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voropack/io.h"
#include "voropack/mesh.h"

namespace voropack::io {

/// A list of K-vertex simplices of one file, for messages with its own numbers.
template <std::size_t K>
struct Listing {
  std::string file;
  std::uint64_t first_number = 0;  ///< The number that the file gives its first element.
  std::uint64_t first_vertex = 0;  ///< The number that the file gives vertex 0.
  std::vector<std::array<VertexId, K>> vertices;
  std::vector<int> markers;          ///< Empty (all 0) or as long as `vertices`.
  std::vector<std::uint64_t> lines;  ///< Empty or as long as `vertices`.
};

/// Fills `mesh`, which has points and optional vertex data: simplices from `simplices` (their `markers` are the
/// regions; region 1 if empty), made positively oriented; their neighbors;
/// `boundary` and every unlisted hull face and interface with marker 0; `segments` (3D).
///
/// A file that lists *all* faces or edges of the mesh, as `tetgen -f -e` and `triangle -e` write, does not mean them
/// all: of such a list, faces inside a region and edges are kept only if their marker is not 0.
///
/// A listed face or edge that no simplex has is kept: `certify` names it.
///
/// `faulty` says whether flat, duplicate and overlapping simplices are refused; if not, `observer` hears of them.
/// Throws: InputError mesh.flat_simplex, mesh.nonmanifold, mesh.overlapping_simplices, io.duplicate_face,
///         io.duplicate_edge.
template <int D>
void assemble_mesh(Mesh<D>& mesh, Listing<D + 1> simplices, const Listing<D>& boundary, const Listing<2>& segments,
                   FaultySimplices faulty, Observer& observer);

}  // namespace voropack::io
