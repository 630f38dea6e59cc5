#include "support/certificate_case.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "support/delaunay_mesh.h"
#include "support/plain_domain.h"
#include "voropack/dual.h"

namespace voropack::test {

namespace {

/// Corners of the two boxes, by x in {0, 1/2, 1}, then y (then z) in {0, 1}.
Domain<2> two_boxes_2d() {
  plain::Builder<2> build;
  std::vector<PointId> p;
  for (const double y : {0.0, 1.0})
    for (const double x : {0.0, 0.5, 1.0}) p.push_back(build.point({x, y}));
  const RegionId left = build.region(1, 0.5);
  const RegionId right = build.region(2, 0.5);
  const RegionId out = RegionId::none();
  build.segment(p[0], p[1], 1, left, out);
  build.segment(p[1], p[2], 2, right, out);
  build.segment(p[2], p[5], 3, right, out);
  build.segment(p[5], p[4], 4, right, out);
  build.segment(p[4], p[3], 5, left, out);
  build.segment(p[3], p[0], 6, left, out);
  build.segment(p[1], p[4], 7, left, right);
  return build.domain();
}

Domain<3> two_boxes_3d() {
  plain::Builder<3> build;
  std::vector<PointId> p;
  for (const double z : {0.0, 1.0})
    for (const double y : {0.0, 1.0})
      for (const double x : {0.0, 0.5, 1.0}) p.push_back(build.point({x, y, z}));
  const RegionId left = build.region(1, 0.5);
  const RegionId right = build.region(2, 0.5);
  const RegionId out = RegionId::none();
  const auto facet = [&](std::array<std::size_t, 4> corners, RegionId side0, RegionId side1, int marker) {
    build.facet({p[corners[0]], p[corners[1]], p[corners[2]], p[corners[3]]}, side0, side1, marker);
  };
  for (std::size_t half = 0; half < 2; ++half) {
    const RegionId inside = half == 0 ? left : right;
    const int marker = static_cast<int>(5 * half) + 1;
    facet({half, half + 1, half + 4, half + 3}, inside, out, marker);
    facet({half + 6, half + 7, half + 10, half + 9}, out, inside, marker + 1);
    facet({half, half + 1, half + 7, half + 6}, out, inside, marker + 2);
    facet({half + 3, half + 4, half + 10, half + 9}, inside, out, marker + 3);
    const std::size_t end = half == 0 ? 0 : 2;
    facet({end, end + 3, end + 9, end + 6}, half == 0 ? inside : out, half == 0 ? out : inside, marker + 4);
  }
  facet({1, 4, 10, 7}, right, left, 11);
  Domain<3> domain = build.domain();
  for (const SegmentId s : ids(domain.segments)) domain.segment_marker[s] = static_cast<int>(s.value()) + 1;
  return domain;
}

template <int D>
Domain<D> two_boxes() {
  if constexpr (D == 2)
    return two_boxes_2d();
  else
    return two_boxes_3d();
}

bool on_segment(const Domain<3>& domain, SegmentId s, const Vec<3>& x) {
  const Vec<3>& a = domain.points[domain.segments[s][0]];
  const Vec<3>& b = domain.points[domain.segments[s][1]];
  return distance(a, x) + distance(x, b) <= distance(a, b) * (1 + 1e-12);
}

/// The wall that holds the middle of a boundary simplex; plain search.
template <int D>
int marker_at(const Domain<D>& domain, const Vec<D>& x) {
  for (std::size_t w = 0; w < domain.n_walls(); ++w) {
    Box<D> box;
    if constexpr (D == 2) {
      for (const PointId p : domain.segments[SegmentId(w)]) box.add(domain.points[p]);
    } else {
      for (const PointId p : domain.facet_points[FacetId(w)]) box.add(domain.points[p]);
    }
    box.inflate(1e-12);
    if (box.contains(x)) return domain.wall_marker(w);
  }
  return 0;
}

void list_segment_edges(Mesh<3>& mesh, const Domain<3>& domain) {
  std::set<std::array<VertexId, 2>> edges;
  for (const auto& face : mesh.boundary_vertices)
    for (std::size_t i = 0; i < 3; ++i)
      edges.insert({std::min(face[i], face[(i + 1) % 3]), std::max(face[i], face[(i + 1) % 3])});
  for (const auto& edge : edges) {
    for (const SegmentId s : ids(domain.segments)) {
      if (!on_segment(domain, s, mesh.points[edge[0]]) || !on_segment(domain, s, mesh.points[edge[1]])) continue;
      mesh.segment_edges.push_back(edge);
      mesh.segment_edge_marker.push_back(domain.segment_marker[s]);
    }
  }
}

}  // namespace

template <int D>
void refresh(CertificateCase<D>& c) {
  const auto boundary = c.mesh.boundary_vertices;
  const auto markers = c.mesh.boundary_marker;
  connect(c.mesh);
  c.mesh.boundary_vertices = boundary;
  c.mesh.boundary_marker = markers;
  c.volumes = build_control_volumes(c.mesh);
}

template <int D>
CertificateCase<D> case_of_points(const std::vector<Vec<D>>& points) {
  CertificateCase<D> c;
  c.domain = two_boxes<D>();
  c.mesh = delaunay_mesh<D>(points, [](const Vec<D>& x) { return x[0] < 0.5 ? 1 : 2; });
  for (const BoundaryId b : ids(c.mesh.boundary_vertices)) {
    Vec<D> middle;
    for (const VertexId v : c.mesh.boundary_vertices[b]) middle += c.mesh.points[v] / D;
    c.mesh.boundary_marker[b] = marker_at(c.domain, middle);
  }
  if constexpr (D == 3) list_segment_edges(c.mesh, c.domain);
  for (const Vec<D>& p : points) {
    int planes = p[0] == 0.5 ? 1 : 0;
    for (int k = 0; k < D; ++k) planes += p[k] == 0 || p[k] == 1 ? 1 : 0;
    c.mesh.vertex_carrier_dimension.push_back(static_cast<std::uint8_t>(D - planes));
  }
  c.volumes = build_control_volumes(c.mesh);
  return c;
}

template <int D>
CertificateCase<D> golden_case(int n) {
  CertificateCase<D> c = case_of_points<D>(perturbed_grid<D>(n, 0.02, 1, true));
  c.mesh.vertex_spacing = IdVector<VertexId, double>(c.mesh.points.size(), 0.479 / n);
  return c;
}

const Certificate::Check& check_named(const Certificate& certificate, std::string_view name) {
  for (const Certificate::Check& check : certificate.checks)
    if (check.name == name) return check;
  throw std::out_of_range("no check " + std::string(name));
}

std::string summary(const Certificate& certificate) {
  std::string text;
  for (const Certificate::Check& check : certificate.checks) {
    text += check.name + (check.ok ? ": ok, " : ": FAILED, ") + std::to_string(check.tested) + " tested, " +
            std::to_string(check.violations) + " violations";
    if (check.worst) text += ", worst " + std::to_string(*check.worst);
    text += ", " + check.where + '\n';
  }
  return text;
}

template <int D>
VertexId interior_vertex(const Mesh<D>& mesh) {
  for (const VertexId v : ids(mesh.points))
    if (mesh.vertex_carrier_dimension[v] == D) return v;
  throw std::out_of_range("no interior vertex");
}

template <int D>
SimplexId interior_simplex(const Mesh<D>& mesh) {
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    bool inside = true;
    for (const VertexId v : mesh.simplex_vertices[s]) inside = inside && mesh.vertex_carrier_dimension[v] == D;
    if (inside) return s;
  }
  throw std::out_of_range("no interior simplex");
}

template void refresh(CertificateCase<2>&);
template void refresh(CertificateCase<3>&);
template CertificateCase<2> case_of_points(const std::vector<Vec<2>>&);
template CertificateCase<3> case_of_points(const std::vector<Vec<3>>&);
template CertificateCase<2> golden_case(int);
template CertificateCase<3> golden_case(int);
template VertexId interior_vertex(const Mesh<2>&);
template VertexId interior_vertex(const Mesh<3>&);
template SimplexId interior_simplex(const Mesh<2>&);
template SimplexId interior_simplex(const Mesh<3>&);

}  // namespace voropack::test
