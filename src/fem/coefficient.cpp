#include "fem/coefficient.h"

#include "solve/faults.h"

namespace voropack {

namespace {

template <int D>
struct Check {
  const Mesh<D>& mesh;
  std::string_view name;

  void operator()(double) const {}
  void operator()(const RegionFunction<D>&) const {}
  void operator()(const std::map<int, double>& by_region) const {
    check_regions(by_region, {mesh.simplex_region.begin(), mesh.simplex_region.end()}, name);
  }
  void operator()(const IdVector<VertexId, double>& by_vertex) const {
    check_length(by_vertex, mesh.points.size(), name);
  }
  void operator()(const StateFunction<D>&) const {
    refuse_state_function(name, "use the control volume method for nonlinear problems");
  }
};

template <int D>
struct ValueAt {
  const Mesh<D>& mesh;
  SimplexId s;
  const std::array<double, D + 1>& barycentric;
  const Vec<D>& x;

  double operator()(double value) const { return value; }
  double operator()(const RegionFunction<D>& function) const { return function(x, mesh.simplex_region[s]); }
  double operator()(const std::map<int, double>& by_region) const { return by_region.at(mesh.simplex_region[s]); }
  double operator()(const IdVector<VertexId, double>& by_vertex) const {
    double value = 0;
    for (std::size_t i = 0; i <= D; ++i) value += barycentric[i] * by_vertex[mesh.simplex_vertices[s][i]];
    return value;
  }
  double operator()(const StateFunction<D>&) const { return 0; }  // Refused by the check.
};

}  // namespace

template <int D>
void check_coefficient(const Coefficient<D>& coefficient, const Mesh<D>& mesh, std::string_view name) {
  std::visit(Check<D>{mesh, name}, coefficient);
}

template <int D>
double value_at(const Coefficient<D>& coefficient, const Mesh<D>& mesh, SimplexId s,
                const std::array<double, D + 1>& barycentric, const Vec<D>& x) {
  return std::visit(ValueAt<D>{mesh, s, barycentric, x}, coefficient);
}

template void check_coefficient(const Coefficient<2>&, const Mesh<2>&, std::string_view);
template void check_coefficient(const Coefficient<3>&, const Mesh<3>&, std::string_view);
template double value_at(const Coefficient<2>&, const Mesh<2>&, SimplexId, const std::array<double, 3>&, const Vec<2>&);
template double value_at(const Coefficient<3>&, const Mesh<3>&, SimplexId, const std::array<double, 4>&, const Vec<3>&);

}  // namespace voropack
