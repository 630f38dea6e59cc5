// The readers of each format, on memory. Fuzz targets and tests call them as read_domain and read_mesh do.
#pragma once

#include <functional>
#include <optional>

#include "io/source.h"
#include "voropack/io.h"
#include "voropack/observer.h"

namespace voropack::io {

/// Gives the .node file beside a .poly or .smesh that lists no points itself. Called at most once.
using NodeFileOpener = std::function<FileContent()>;

AnyDomainInput parse_poly(const Source& source, const NodeFileOpener& open_node, Observer& observer);
AnyDomainInput parse_smesh(const Source& source, const NodeFileOpener& open_node, Observer& observer);
AnyDomainInput parse_node_domain(const Source& source, Observer& observer);
DomainInput<3> parse_off(const Source& source, Observer& observer);
DomainInput<3> parse_stl(const Source& source, Observer& observer);
DomainInput<3> parse_obj(const Source& source, Observer& observer);
DomainInput<3> parse_ply(const Source& source, Observer& observer);

/// The files of one mesh in the format of Triangle (2D) and TetGen (3D).
struct NodeMeshSources {
  Source node, ele;
  std::optional<Source> face;  ///< Used in 3D.
  std::optional<Source> edge;
  std::optional<Source> poly;  ///< Used in 2D without `edge`, if its points are those of `node`.
};
AnyMesh parse_node_mesh(const NodeMeshSources& sources, Observer& observer,
                        FaultySimplices faulty = FaultySimplices::kRefuse);
AnyMesh parse_vtu(const Source& source, Observer& observer, FaultySimplices faulty = FaultySimplices::kRefuse);
std::vector<double> parse_vtu_point_array(const Source& source, const std::string& name, Observer& observer);

}  // namespace voropack::io
