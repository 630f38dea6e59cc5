// Check `dual_nonnegative`: no dual face has a negative area, and a sample of the areas is what circumcenters say.
#include "certificate/dual_sample.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"

namespace voropack::judge {

namespace {

enum DualFault : int { kNegative = 1, kWrongArea, kMissing, kWrongLength, kWrongSite, kBadFace };

/// Areas may differ by this much times h^(D-1), and by what rounding leaves of the terms of their sums.
constexpr double kAreaTolerance = 1e-9;
constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();

/// Edge lengths may differ by this much, relative.
constexpr double kLengthTolerance = 1e-12;

/// Vertices whose faces are computed again: some 60,000 edges in space.
constexpr std::size_t kSampledVertices = 8'000;

/// Sampled vertices and the simplices around each.
struct Stars {
  std::vector<std::uint32_t> vertex;
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> simplices;
};

template <int D>
Stars sample_stars(const Subject<D>& subject) {
  const std::size_t n = subject.mesh.points.size();
  const std::size_t step = n / kSampledVertices + 1;
  Stars stars;
  for (std::size_t v = 0; v < n; v += step) stars.vertex.push_back(static_cast<std::uint32_t>(v));
  std::vector<std::uint8_t> sampled(n, 0);
  for (const std::uint32_t v : stars.vertex) sampled[v] = 1;
  struct Hit {
    std::uint32_t star, simplex;
  };
  const std::size_t n_simplices = subject.mesh.simplex_vertices.size();
  std::vector<std::vector<Hit>> hits((n_simplices + kBlock - 1) / kBlock);
  parallel_for(
      hits.size(),
      [&](std::size_t block) {
        for (std::size_t s = block * kBlock; s < std::min(n_simplices, (block + 1) * kBlock); ++s) {
          if (!subject.topology.valid(s)) continue;
          for (const VertexId v : subject.mesh.simplex_vertices[SimplexId(s)])
            if (sampled[v.value()] != 0)
              hits[block].push_back({static_cast<std::uint32_t>(v.value() / step), static_cast<std::uint32_t>(s)});
        }
      },
      1);
  stars.offsets.assign(stars.vertex.size() + 1, 0);
  for (const auto& block : hits)
    for (const Hit& hit : block) ++stars.offsets[hit.star + 1];
  for (std::size_t k = 0; k < stars.vertex.size(); ++k) stars.offsets[k + 1] += stars.offsets[k];
  stars.simplices.resize(stars.offsets.back());
  std::vector<std::uint64_t> next(stars.offsets.begin(), stars.offsets.end() - 1);
  for (const auto& block : hits)
    for (const Hit& hit : block) stars.simplices[next[hit.star]++] = hit.simplex;
  return stars;
}

/// A signed area, and the magnitude of the terms it is the sum of.
struct Share {
  double area = 0, magnitude = 0;

  Share& operator+=(const Share& other) {
    area += other.area;
    magnitude += other.magnitude;
    return *this;
  }
};

/// What one simplex contributes to the dual face of its edge (i, j): the quadrilateral from the edge's midpoint by the
/// circumcenters of the two faces and of the simplex, projected along the edge; in the plane, the segment from the
/// midpoint to the circumcenter. Negative beyond the midpoint or face.
Share dual_share(const std::array<Vec<2>, 3>& p, std::size_t i, std::size_t j, const Vec<2>& center) {
  const Vec<2> middle = 0.5 * (p[i] + p[j]);
  const Vec<2> third = p[3 - i - j];
  const Vec<2> edge = p[j] - p[i];
  const double side = cross(edge, third - p[i]) > 0 ? 1 : -1;
  return {side * cross(edge, center - middle) / norm(edge), norm(center - middle)};
}

Share dual_share(const std::array<Vec<3>, 4>& p, std::size_t i, std::size_t j, const Vec<3>& center) {
  std::array<std::size_t, 2> rest{};
  std::size_t n = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (k != i && k != j) rest[n++] = k;
  const Vec<3> middle = 0.5 * (p[i] + p[j]);
  const Vec<3> edge = p[j] - p[i];
  const Vec<3> c = center - middle;
  const Vec<3> f = diametral_ball(p[i], p[j], p[rest[0]]).center - middle;
  const Vec<3> g = diametral_ball(p[i], p[j], p[rest[1]]).center - middle;
  const double side = dot(edge, cross(p[rest[0]] - middle, p[rest[1]] - middle)) > 0 ? 1 : -1;
  return {side * 0.5 * dot(edge, cross(f, c) + cross(c, g)) / norm(edge), 0.5 * norm(c) * (norm(f) + norm(g))};
}

struct EdgeShare {
  std::uint32_t other;
  int region;
  Share share;
};

/// The dual faces of vertex v towards higher vertices, from the simplices around it.
template <int D>
std::vector<EdgeShare> recompute(const Subject<D>& subject, const Stars& stars, std::size_t k) {
  const std::uint32_t v = stars.vertex[k];
  std::vector<EdgeShare> shares;
  for (std::uint64_t at = stars.offsets[k]; at < stars.offsets[k + 1]; ++at) {
    const std::uint32_t s = stars.simplices[at];
    std::array<Vec<D>, D + 1> p = subject.topology.corners(s);
    const Circumball<D> ball = circumball<D>(p);
    // Relative to corner 0: far from the origin, rounding the centers would change the areas.
    for (std::size_t c = D + 1; c-- > 0;) p[c] -= p[0];
    const auto& corners = subject.mesh.simplex_vertices[SimplexId(s)];
    const auto i = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), VertexId(v)) - corners.begin());
    for (std::size_t j = 0; j <= D; ++j)
      if (corners[j].value() > v)
        shares.push_back({corners[j].value(), subject.topology.region(s), dual_share(p, i, j, ball.offset)});
  }
  std::stable_sort(shares.begin(), shares.end(), [](const EdgeShare& a, const EdgeShare& b) {
    return a.other != b.other ? a.other < b.other : a.region < b.region;
  });
  std::vector<EdgeShare> faces;
  for (const EdgeShare& edge : shares) {
    if (!faces.empty() && faces.back().other == edge.other && faces.back().region == edge.region)
      faces.back().share += edge.share;
    else
      faces.push_back(edge);
  }
  return faces;
}

template <int D>
void test_star(const Subject<D>& subject, const Stars& stars, std::size_t k, Tally& tally) {
  const ControlVolumes<D>& volumes = subject.volumes;
  const std::uint32_t v = stars.vertex[k];
  const auto& edges = volumes.face_vertices.raw();
  const auto first = std::lower_bound(edges.begin(), edges.end(), std::array<VertexId, 2>{VertexId(v), VertexId(0)});
  const auto last =
      std::lower_bound(first, edges.end(), std::array<VertexId, 2>{VertexId(std::size_t{v} + 1), VertexId(0)});
  const std::vector<EdgeShare> faces = recompute(subject, stars, k);
  std::vector<bool> matched(static_cast<std::size_t>(last - first), false);
  for (const EdgeShare& face : faces) {
    const double tolerance = kAreaTolerance * std::pow(distance(subject.point(v), subject.point(face.other)), D - 1) +
                             kRounding * face.share.magnitude;
    double listed = 0;  // A face that is not listed has area zero.
    std::uint32_t id = kNone;
    for (auto it = first; it != last; ++it) {
      const auto f = static_cast<std::size_t>(it - edges.begin());
      if ((*it)[1].value() != face.other || volumes.face_region[DualFaceId(f)] != face.region) continue;
      listed += volumes.face_area[DualFaceId(f)];
      id = static_cast<std::uint32_t>(f);
      matched[static_cast<std::size_t>(it - first)] = true;
    }
    if (!(std::abs(listed - face.share.area) <= tolerance))
      tally.violation(id == kNone ? kMissing : kWrongArea, std::abs(listed - face.share.area), id, v, face.other);
    else
      ++tally.tested;
  }
  for (std::size_t m = 0; m < matched.size(); ++m) {
    const auto f = static_cast<std::size_t>(first - edges.begin()) + m;
    if (!matched[m] && volumes.face_area[DualFaceId(f)] != 0)
      tally.violation(kWrongArea, volumes.face_area[DualFaceId(f)], static_cast<std::uint32_t>(f), v,
                      edges[f][1].value());
  }
}

template <int D>
void test_face(const Subject<D>& subject, std::size_t f, Tally& tally) {
  const ControlVolumes<D>& volumes = subject.volumes;
  const auto& edge = volumes.face_vertices[DualFaceId(f)];
  const double area = volumes.face_area[DualFaceId(f)];
  const auto id = static_cast<std::uint32_t>(f);
  if (!valid_edge(subject, edge) || !(edge[0] < edge[1]) ||
      (f > 0 && volumes.face_vertices[DualFaceId(f - 1)] > edge)) {
    tally.violation(kBadFace, kNoFigure, id);
    return;
  }
  const double length = distance(subject.mesh.points[edge[0]], subject.mesh.points[edge[1]]);
  if (!(std::abs(volumes.face_edge_length[DualFaceId(f)] - length) <= kLengthTolerance * length))
    tally.violation(kWrongLength, kNoFigure, id, edge[0].value(), edge[1].value());
  else if (!(area >= 0))
    tally.violation(kNegative, -area, id, edge[0].value(), edge[1].value());
  else
    tally.legal(-area, id, edge[0].value(), edge[1].value());
}

template <int D>
std::string describe(const Subject<D>& subject, const Finding& worst) {
  if (!worst.present) return {};
  const std::uint32_t f = worst.ids[0];
  if (worst.kind == kWrongSite) return "the site of " + subject.vertex_text(f) + " is another point";
  const std::string edge = "between " + subject.vertex_text(worst.ids[1]) + " and " + subject.vertex_text(worst.ids[2]);
  const std::string face = "dual face " + std::to_string(f) + ' ';
  switch (worst.kind) {
    case kBadFace:
      return f == kNone ? "the arrays of dual faces differ in length"
                        : face + "is out of order or does not join two vertices";
    case kWrongLength:
      return face + edge + " has a wrong edge length";
    case kNegative:
      return face + edge + " has a negative area";
    case kWrongArea:
      return face + edge + " has another area than its circumcenters span";
    case kMissing:
      return "the dual face " + edge + " is not listed";
    default:
      return "smallest: " + face + edge;
  }
}

}  // namespace

template <int D>
Check check_dual_nonnegative(const Subject<D>& subject, bool complete) {
  const ControlVolumes<D>& volumes = subject.volumes;
  const std::size_t n_faces = volumes.face_vertices.size();
  const auto combine = [](Tally a, const Tally& b) { return a += b; };
  Tally tally;
  if (!complete) {
    tally.fault(kBadFace, kNoFigure, kNone);
  } else if (n_faces > 0) {
    tally = parallel_reduce_ordered(
        n_faces, 16 * kBlock, Tally{},
        [&](std::size_t begin, std::size_t end) {
          Tally block;
          for (std::size_t f = begin; f < end; ++f) test_face(subject, f, block);
          return block;
        },
        combine);
    if (volumes.sites.size() == subject.mesh.points.size()) {
      for (std::size_t v = 0; v < volumes.sites.size(); ++v)
        if (subject.topology.finite(v) && !(volumes.sites[VertexId(v)] == subject.mesh.points[VertexId(v)]))
          tally.fault(kWrongSite, kNoFigure, static_cast<std::uint32_t>(v));
    }
    const bool readable = !tally.worst.present || tally.worst.kind != kBadFace;
    if (readable) {
      const Stars stars = sample_stars(subject);
      tally += parallel_reduce_ordered(
          stars.vertex.size(), 128, Tally{},
          [&](std::size_t begin, std::size_t end) {
            Tally block;
            for (std::size_t k = begin; k < end; ++k) test_star(subject, stars, k, block);
            return block;
          },
          combine);
    }
  }
  const bool is_area = !tally.worst.present || tally.worst.kind == 0 || tally.worst.kind == kNegative;
  return make_check("dual_nonnegative", tally, describe(subject, tally.worst), is_area ? -1 : 1);
}

template Check check_dual_nonnegative(const Subject<2>&, bool);
template Check check_dual_nonnegative(const Subject<3>&, bool);

}  // namespace voropack::judge
