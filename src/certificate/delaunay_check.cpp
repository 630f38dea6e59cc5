// Check `delaunay`: every simplex positively oriented, every interior face locally Delaunay, no two sheets overlap.
#include <algorithm>

#include "base/parallel.h"
#include "base/random.h"
#include "certificate/checks.h"

namespace voropack::judge {

namespace {

template <int D>
void test_simplex(const Subject<D>& subject, std::size_t s, Tally& tally) {
  const Topology<D>& topology = subject.topology;
  const auto id = static_cast<std::uint32_t>(s);
  const std::array<Vec<D>, D + 1> p = topology.corners(s);
  const SignedValue volume = certain_orientation<D>(p);
  if (volume.sign <= 0) {
    tally.violation(kNotPositive, kNoFigure, id);
    return;
  }
  ++tally.tested;
  for (int i = 0; i <= D; ++i) {
    const std::uint32_t n = topology.neighbor(s, i);
    if (n == kNone || n < s) continue;
    const int j = topology.corner_towards(n, s);
    if (j < 0) continue;  // A neighbor that does not point back was reported and replaced before.
    const VertexId opposite = subject.mesh.simplex_vertices[SimplexId(n)][static_cast<std::size_t>(j)];
    double size = 0;
    const SignedValue inside = certain_in_circumball(p, subject.mesh.points[opposite], size);
    // -power of the opposite vertex relative to the squared size of the pair.
    const double figure = inside.value / (volume.value * size * size);
    if (inside.sign > 0)
      tally.violation(kBallNotEmpty, std::max(figure, 0.0), id, n, opposite.value());
    else
      tally.legal(std::min(figure, 0.0), id, n, opposite.value());
  }
}

/// Where a line enters (+1) or leaves (-1) the mesh through a hull face.
struct Crossing {
  double at;
  int step;
};

/// The part of the line from x along `direction` that is covered twice or less than zero times.
///
/// The number of simplices over a point of the line is the sum of steps before it, if neighbors are mutual and all
/// simplices positive: it changes only at hull faces. Faces that the line hits on an edge, up to rounding, spoil the
/// count, which then does not return to 0 at the end: such a line says nothing.
template <int D>
double wrongly_covered(const Subject<D>& subject, const Vec<D>& x, const Vec<D>& direction) {
  std::vector<Crossing> crossings;
  for (const BoundaryFace<D>& face : subject.topology.boundary()) {
    if (face.n_sides() != 1) continue;
    const std::uint32_t inside = subject.mesh.simplex_vertices[SimplexId(face.simplex[0])][face.corner[0]].value();
    if constexpr (D == 2) {
      const Vec<2> a = subject.point(face.vertices[0]) - x, b = subject.point(face.vertices[1]) - x;
      const double sa = cross(direction, a), sb = cross(direction, b);
      if ((sa > 0) == (sb > 0)) continue;
      const Vec<2> hit = a + (sa / (sa - sb)) * (b - a);
      const double side = cross(b - a, subject.point(inside) - x - a);
      crossings.push_back({dot(hit, direction), (cross(b - a, direction) > 0) == (side > 0) ? 1 : -1});
    } else {
      const Vec<3> a = subject.point(face.vertices[0]) - x;
      const Vec<3> b = subject.point(face.vertices[1]) - x;
      const Vec<3> c = subject.point(face.vertices[2]) - x;
      const double sa = dot(direction, cross(b, c)), sb = dot(direction, cross(c, a)), sc = dot(direction, cross(a, b));
      if ((sa > 0) != (sb > 0) || (sb > 0) != (sc > 0)) continue;
      const Vec<3> hit = (sa * a + sb * b + sc * c) / (sa + sb + sc);
      const Vec<3> normal = cross(b - a, c - a);
      const double side = dot(normal, subject.point(inside) - x - a);
      crossings.push_back({dot(hit, direction), (dot(normal, direction) > 0) == (side > 0) ? 1 : -1});
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
  int depth = 0;
  double wrong = 0;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    depth += crossings[i].step;
    if (i + 1 < crossings.size() && (depth < 0 || depth > 1)) wrong += crossings[i + 1].at - crossings[i].at;
  }
  return depth == 0 ? wrong : 0;
}

/// Lines through the barycenters of evenly spread simplices. Catches simplices that occur twice and sheets that lie
/// over each other, which no local test can see.
template <int D>
Tally test_overlap(const Subject<D>& subject) {
  constexpr std::size_t kLines = 32;
  constexpr double kShort = 1e-7;  // Relative to the box: what coincident hull faces may leave by rounding.
  Tally tally;
  const std::size_t n = subject.mesh.simplex_vertices.size();
  std::vector<double> wrong(kLines, 0);
  std::vector<std::uint32_t> simplex(kLines, 0);
  parallel_for(
      kLines,
      [&](std::size_t line) {
        const std::size_t s = n * line / kLines;
        if (n == 0 || !subject.topology.valid(s)) return;
        Vec<D> x, direction;
        for (const Vec<D>& p : subject.topology.corners(s)) x += p / (D + 1);
        for (int k = 0; k < D; ++k) direction[k] = 0.1 + to_unit(hash_words(line, static_cast<std::uint64_t>(k)));
        simplex[line] = static_cast<std::uint32_t>(s);
        wrong[line] = wrongly_covered(subject, x, direction / norm(direction));
      },
      1);
  for (std::size_t line = 0; line < kLines; ++line)
    if (wrong[line] > kShort * subject.topology.box().diagonal()) tally.fault(kOverlap, wrong[line], simplex[line]);
  return tally;
}

template <int D>
std::string describe(const Subject<D>& subject, const Finding& worst) {
  if (!worst.present) return {};
  const std::string first = subject.simplex_text(worst.ids[0]);
  switch (worst.kind) {
    case kNoSimplices:
      return "the mesh has no simplices";
    case kInvalidCorner:
      return first + " has a corner that is no vertex or is not finite";
    case kRepeatedCorner:
      return first + " has the same corner twice";
    case kSharedFace:
      return first + " shares a face with " + subject.simplex_text(worst.ids[1]) + ", which is not its neighbor";
    case kWrongNeighbor: {
      const SimplexId n = subject.mesh.simplex_neighbors[SimplexId(worst.ids[0])][worst.ids[1]];
      return first + " has a wrong neighbor " + std::to_string(n.value()) + " opposite to its corner " +
             std::to_string(worst.ids[1]);
    }
    case kNotPositive:
      return first + " is flat or inverted";
    case kOverlap:
      return "simplices overlap on a line through " + first;
    case kBallNotEmpty:
      return first + " has " + subject.vertex_text(worst.ids[2]) + " in its circumball";
    default:
      return "nearest to a violation: " + first + " and " + subject.vertex_text(worst.ids[2]) + " of simplex " +
             std::to_string(worst.ids[1]);
  }
}

}  // namespace

template <int D>
Check check_delaunay(const Subject<D>& subject, const Tally& structure) {
  Tally tally = structure;
  tally += parallel_reduce_ordered(
      subject.mesh.simplex_vertices.size(), kBlock, Tally{},
      [&](std::size_t begin, std::size_t end) {
        subject.observer.check_cancelled();
        Tally block;
        for (std::size_t s = begin; s < end; ++s)
          if (subject.topology.valid(s)) test_simplex(subject, s, block);
        return block;
      },
      [](Tally a, const Tally& b) { return a += b; });
  tally += test_overlap(subject);
  return make_check("delaunay", tally, describe(subject, tally.worst));
}

template Check check_delaunay(const Subject<2>&, const Tally&);
template Check check_delaunay(const Subject<3>&, const Tally&);

}  // namespace voropack::judge
