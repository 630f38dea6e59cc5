#include "voropack/certificate.h"

#include <algorithm>
#include <cstdio>

#include "base/parallel.h"
#include "base/place_text.h"
#include "certificate/checks.h"
#include "geom/tolerance.h"

namespace voropack {

namespace judge {

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

template <int D>
std::string Subject<D>::vertex_text(std::uint32_t v) const {
  std::string text = "vertex " + std::to_string(v);
  if (v < mesh.points.size()) text += " at " + place_text(point(v), topology.box());
  return text;
}

template <int D>
std::string Subject<D>::simplex_text(std::uint32_t s) const {
  std::string text = "simplex " + std::to_string(s);
  if (s >= mesh.simplex_vertices.size()) return text;
  text += " (vertices";
  Vec<D> center;
  for (const VertexId v : mesh.simplex_vertices[SimplexId(s)]) {
    text += ' ' + (v.is_none() ? std::string("none") : std::to_string(v.value()));
    if (v.value() < mesh.points.size()) center += mesh.points[v] / (D + 1);
  }
  text += ')';
  if (topology.valid(s)) text += " near " + place_text(center, topology.box());
  return text;
}

template <int D>
std::string Subject<D>::boundary_text(std::uint32_t b) const {
  const BoundaryFace<D>& face = topology.boundary()[b];
  std::string text = face.listed ? "boundary simplex " + std::to_string(b) : std::string("unlisted boundary face");
  text += " (vertices";
  Vec<D> center;
  for (const std::uint32_t v : face.vertices) {
    text += ' ' + std::to_string(v);
    if (face.valid) center += point(v) / D;
  }
  text += "; marker " + std::to_string(face.marker) + ')';
  if (face.valid) text += " near " + place_text(center, topology.box());
  return text;
}

template <int D>
std::string Subject<D>::ball_text(const ProtectingBall<D>& ball) const {
  if (!ball.is_segment_edge) return boundary_text(ball.index);
  return "segment edge " + std::to_string(ball.index) + " (vertices " + std::to_string(ball.corner[0]) + ' ' +
         std::to_string(ball.corner[1]) + ") near " + place_text(ball.ball.center, topology.box());
}

template <int D>
VertexTree<D> build_vertex_tree(const Mesh<D>& mesh, const Topology<D>& topology, bool has_spacing) {
  std::vector<std::uint32_t> items;
  items.reserve(mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (topology.finite(v)) items.push_back(static_cast<std::uint32_t>(v));
  const auto spacing = [&](std::size_t v) {
    const double f = has_spacing ? mesh.vertex_spacing[VertexId(v)] : 0.0;
    return f > 0 && std::isfinite(f) ? f : 0.0;
  };
  VertexTree<D> vertices;
  vertices.tree = BoxTree<D>(
      items.size(),
      [&](std::size_t i) { return Box<D>(mesh.points[VertexId(items[i])], mesh.points[VertexId(items[i])]); },
      [&](std::size_t i) { return spacing(items[i]); });
  vertices.id.resize(items.size());
  vertices.point.resize(items.size());
  vertices.spacing.resize(items.size());
  parallel_for(items.size(), [&](std::size_t k) {
    const std::uint32_t v = vertices.id[k] = items[vertices.tree.order()[k]];
    vertices.point[k] = mesh.points[VertexId(v)];
    vertices.spacing[k] = spacing(v);
  });
  return vertices;
}

namespace {

/// The file lists no segments: the edges at which boundary faces bend, end, meet or change their marker are taken for
/// some. They only explain why circumcenters could not be added.
void derive_segment_edges(const Mesh<3>& mesh, const Topology<3>& topology, std::vector<ProtectingBall<3>>& balls) {
  std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> edges;
  const auto& boundary = topology.boundary();
  for (std::size_t b = 0; b < boundary.size(); ++b) {
    if (!boundary[b].valid || boundary[b].repeated) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = boundary[b].vertices[i], w = boundary[b].vertices[(i + 1) % 3];
      edges.push_back({{std::min(v, w), std::max(v, w)}, static_cast<std::uint32_t>(b)});
    }
  }
  std::sort(edges.begin(), edges.end());
  const auto normal = [&](std::uint32_t b) {
    const auto& v = boundary[b].vertices;
    const Vec<3>& a = mesh.points[VertexId(v[0])];
    return cross(mesh.points[VertexId(v[1])] - a, mesh.points[VertexId(v[2])] - a);
  };
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i + 1;
    while (j < edges.size() && edges[j].first == edges[i].first) ++j;
    bool smooth = j - i == 2 && boundary[edges[i].second].marker == boundary[edges[i + 1].second].marker;
    if (smooth) {
      const Vec<3> n = normal(edges[i].second), m = normal(edges[i + 1].second);
      smooth = norm(cross(n, m)) <= kCoplanarAngle * norm(n) * norm(m);
    }
    if (!smooth) {
      const auto& edge = edges[i].first;
      ProtectingBall<3> ball;
      ball.corner = {edge[0], edge[1], kNone};
      ball.n_corners = 2;
      ball.is_segment_edge = ball.derived = true;
      ball.ball = diametral_ball(mesh.points[VertexId(edge[0])], mesh.points[VertexId(edge[1])]);
      balls.push_back(ball);
    }
    i = j;
  }
}

}  // namespace

template <int D>
std::vector<ProtectingBall<D>> list_protecting_balls(const Mesh<D>& mesh, const Topology<D>& topology) {
  std::vector<ProtectingBall<D>> balls;
  for (std::size_t b = 0; b < topology.boundary().size(); ++b) {
    const BoundaryFace<D>& face = topology.boundary()[b];
    if (!face.valid || face.repeated) continue;
    ProtectingBall<D> ball;
    ball.corner = face.vertices;
    ball.n_corners = D;
    ball.index = static_cast<std::uint32_t>(b);
    const auto p = [&](std::size_t i) { return mesh.points[VertexId(face.vertices[i])]; };
    if constexpr (D == 2)
      ball.ball = diametral_ball(p(0), p(1));
    else
      ball.ball = diametral_ball(p(0), p(1), p(2));
    balls.push_back(ball);
  }
  if constexpr (D == 3) {
    if (mesh.segment_edges.empty()) derive_segment_edges(mesh, topology, balls);
    for (const EdgeId e : ids(mesh.segment_edges)) {
      const auto& edge = mesh.segment_edges[e];
      bool good = edge[0] != edge[1];
      for (const VertexId v : edge) good = good && !v.is_none() && v.value() < mesh.points.size();
      if (!good || !topology.finite(edge[0].value()) || !topology.finite(edge[1].value())) continue;
      ProtectingBall<D> ball;
      ball.corner = {edge[0].value(), edge[1].value(), kNone};
      ball.n_corners = 2;
      ball.index = e.value();
      ball.is_segment_edge = true;
      ball.ball = diametral_ball(mesh.points[edge[0]], mesh.points[edge[1]]);
      balls.push_back(ball);
    }
  }
  return balls;
}

template struct Subject<2>;
template struct Subject<3>;

}  // namespace judge

template <int D>
Certificate certify(const Mesh<D>& mesh, const ControlVolumes<D>& volumes, const Domain<D>* domain,
                    const CertificateOptions& options, Observer& observer) {
  using namespace judge;
  observer.begin_stage("certificate");
  Tally structure;
  const Topology<D> topology(mesh, structure, observer);
  Subject<D> subject{mesh, volumes, domain, options, observer, topology, {}, {}, SharpFeatures<D>(mesh, topology)};
  subject.has_spacing = !mesh.points.empty() && mesh.vertex_spacing.size() == mesh.points.size();
  subject.vertices = build_vertex_tree(mesh, topology, subject.has_spacing);
  subject.balls = list_protecting_balls(mesh, topology);

  // The pass over circumcenters needs b, which the Lipschitz check measures if nobody claims it.
  double measured = 0;
  Check lipschitz = check_spacing_lipschitz(subject, measured);
  subject.gradation = options.gradation.value_or(measured);

  // Independent of each other; each has a part that is not parallel in itself.
  Check packing, delaunay, conformity, protecting;
  std::array<Check, 3> circumcenters, dual;
  parallel_for(
      4,
      [&](std::size_t task) {
        observer.check_cancelled();
        switch (task) {
          case 0: {
            Duplicates duplicates;
            packing = check_packing(subject, duplicates);
            conformity = check_conformity(subject, duplicates);
            protecting = check_protecting_balls(subject);
            break;
          }
          case 1:
            dual = check_volumes(subject);
            break;
          case 2:
            delaunay = check_delaunay(subject, structure);
            break;
          default:
            circumcenters = check_circumcenters(subject);
            break;
        }
      },
      1);

  Certificate certificate;
  certificate.checks = {packing,          lipschitz,        circumcenters[0], delaunay, conformity, protecting,
                        circumcenters[1], circumcenters[2], dual[0],          dual[1],  dual[2]};
  for (const Check& check : certificate.checks) certificate.ok = certificate.ok && check.ok;
  return certificate;
}

template Certificate certify(const Mesh<2>&, const ControlVolumes<2>&, const Domain<2>*, const CertificateOptions&,
                             Observer&);
template Certificate certify(const Mesh<3>&, const ControlVolumes<3>&, const Domain<3>*, const CertificateOptions&,
                             Observer&);

}  // namespace voropack
