// The writers of mesh formats, chosen by write_mesh.
#pragma once

#include <filesystem>

#include "voropack/io.h"
#include "voropack/mesh.h"

namespace voropack::io {

/// .node, .ele, .edge and in 3D .face: all or none of them.
template <int D>
void write_node_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays);

template <int D>
void write_vtu_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays);

}  // namespace voropack::io
