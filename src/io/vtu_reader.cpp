#include "io/readers.h"

namespace voropack::io {

AnyMesh parse_vtu(const Source& source, Observer&) {
  fail(source.file, "io.unsupported", "reading .vtu is not there yet", "give the mesh as .node");
}

}  // namespace voropack::io
