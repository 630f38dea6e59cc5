// A stranger's program: meshes the unit square through the public headers only.
#include <cmath>
#include <cstdio>

#include "voropack/pipeline.h"

int main() {
  voropack::DomainInput<2> square;
  square.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (unsigned i = 0; i < 4; ++i) square.segments.push_back({.points = {i, (i + 1) % 4}, .marker = {}, .line = {}});
  voropack::MeshingOptions<2> options;
  options.wishes.size = 0.2;
  const voropack::MeshingResult<2> result = voropack::make_mesh(square, options);
  std::printf("%zu vertices, area %.17g\n", result.mesh.points.size(), result.quality.volume_sum);
  return result.certificate.ok && std::abs(result.quality.volume_sum - 1) < 1e-12 ? 0 : 1;
}
