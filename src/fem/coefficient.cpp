#include "fem/coefficient.h"

#include <fmt/format.h>

#include "voropack/error.h"

namespace voropack {

namespace {

template <int D>
struct ValueAt {
  const Mesh<D>& mesh;
  SimplexId s;
  const std::array<double, D + 1>& barycentric;
  const Vec<D>& x;

  double operator()(double value) const { return value; }
  double operator()(const RegionFunction<D>& function) const { return function(x, mesh.simplex_region[s]); }
  double operator()(const std::map<int, double>& by_region) const {
    const auto entry = by_region.find(mesh.simplex_region[s]);
    if (entry != by_region.end()) return entry->second;
    throw InputError(Fault{.id = "solve.unknown_region",
                           .message = fmt::format("a coefficient has no value for region {}", mesh.simplex_region[s]),
                           .fix = "give it one for each region",
                           .position = {x.coord.begin(), x.coord.end()}});
  }
  double operator()(const IdVector<VertexId, double>& by_vertex) const {
    if (by_vertex.size() != mesh.points.size())
      throw InputError(Fault{
          .id = "solve.wrong_length",
          .message = fmt::format("a coefficient has {} values for {} vertices", by_vertex.size(), mesh.points.size()),
          .fix = "give it one for each vertex"});
    double value = 0;
    for (std::size_t i = 0; i <= D; ++i) value += barycentric[i] * by_vertex[mesh.simplex_vertices[s][i]];
    return value;
  }
};

}  // namespace

template <int D>
double value_at(const Coefficient<D>& coefficient, const Mesh<D>& mesh, SimplexId s,
                const std::array<double, D + 1>& barycentric, const Vec<D>& x) {
  return std::visit(ValueAt<D>{mesh, s, barycentric, x}, coefficient);
}

template double value_at(const Coefficient<2>&, const Mesh<2>&, SimplexId, const std::array<double, 3>&, const Vec<2>&);
template double value_at(const Coefficient<3>&, const Mesh<3>&, SimplexId, const std::array<double, 4>&, const Vec<3>&);

}  // namespace voropack
