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
    const double scale = volume.value * size * size;
    if (inside.sign > 0)
      tally.violation(kBallNotEmpty, std::max(inside.value / scale, 0.0), id, n, opposite.value());
    else
      tally.legal_quotient(std::min(inside.value, 0.0), scale, id, n, opposite.value());
  }
}

/// A straight line that is followed through the mesh.
template <int D>
struct Line {
  Vec<D> point;
  Vec<D> direction;  ///< Of length 1.
  std::uint32_t simplex = 0;
};

/// Where a line enters (+1) or leaves (-1) the mesh through a hull face.
struct Crossing {
  std::uint32_t line;
  int step;
  double at;
};

/// The parameter at which the line crosses the face `p`, if it does.
std::optional<double> cross_face(const Line<2>& line, const std::array<Vec<2>, 2>& p) {
  const Vec<2> a = p[0] - line.point, b = p[1] - line.point;
  const double sa = cross(line.direction, a), sb = cross(line.direction, b);
  if ((sa > 0) == (sb > 0)) return std::nullopt;
  return dot(a + (sa / (sa - sb)) * (b - a), line.direction);
}

std::optional<double> cross_face(const Line<3>& line, const std::array<Vec<3>, 3>& p) {
  const Vec<3> a = p[0] - line.point, b = p[1] - line.point, c = p[2] - line.point;
  const double sa = dot(line.direction, cross(b, c)), sb = dot(line.direction, cross(c, a));
  if ((sa > 0) != (sb > 0)) return std::nullopt;
  const double sc = dot(line.direction, cross(a, b));
  if ((sb > 0) != (sc > 0)) return std::nullopt;
  return dot(sa * a + sb * b + sc * c, line.direction) / (sa + sb + sc);
}

/// All crossings of the lines with hull faces, by line, then along it.
template <int D>
std::vector<Crossing> find_crossings(const Subject<D>& subject, const std::vector<Line<D>>& lines) {
  const auto& boundary = subject.topology.boundary();
  const std::size_t n_blocks = (boundary.size() + kBlock - 1) / kBlock;
  std::vector<std::vector<Crossing>> found(n_blocks);
  parallel_for(
      n_blocks,
      [&](std::size_t block) {
        for (std::size_t b = block * kBlock; b < std::min(boundary.size(), (block + 1) * kBlock); ++b) {
          const BoundaryFace<D>& face = boundary[b];
          if (face.n_sides() != 1) continue;
          std::array<Vec<D>, D> p;
          for (std::size_t i = 0; i < D; ++i) p[i] = subject.point(face.vertices[i]);
          const VertexId inside = subject.mesh.simplex_vertices[SimplexId(face.simplex[0])][face.corner[0]];
          const Vec<D> inward = inward_normal(p, subject.mesh.points[inside]);
          for (std::size_t line = 0; line < lines.size(); ++line) {
            const std::optional<double> at = cross_face(lines[line], p);
            if (!at) continue;
            const int step = dot(inward, lines[line].direction) > 0 ? 1 : -1;
            found[block].push_back({static_cast<std::uint32_t>(line), step, *at});
          }
        }
      },
      1);
  std::vector<Crossing> crossings;
  for (const auto& block : found) crossings.insert(crossings.end(), block.begin(), block.end());
  std::sort(crossings.begin(), crossings.end(),
            [](const Crossing& a, const Crossing& b) { return a.line != b.line ? a.line < b.line : a.at < b.at; });
  return crossings;
}

/// Catches simplices that occur twice and sheets that lie over each other, which no local test can see.
///
/// Lines are laid through the barycenters of evenly spread simplices. The number of simplices over a point of a line is
/// the sum of steps before it, if neighbors are mutual and all simplices positive: it changes only at hull faces. It
/// must be 0 or 1. Faces that a line hits on an edge, up to rounding, spoil the count, which then does not return to 0
/// at the end: such a line says nothing.
template <int D>
Tally test_overlap(const Subject<D>& subject) {
  constexpr std::size_t kLines = 32;
  constexpr double kShort = 1e-7;  // Relative to the box: what coincident hull faces may leave by rounding.
  Tally tally;
  const std::size_t n = subject.mesh.simplex_vertices.size();
  std::vector<Line<D>> lines;
  for (std::size_t k = 0; k < kLines && n > 0; ++k) {
    const std::size_t s = n * k / kLines;
    if (!subject.topology.valid(s)) continue;
    Line<D> line;
    line.simplex = static_cast<std::uint32_t>(s);
    for (const Vec<D>& p : subject.topology.corners(s)) line.point += p / (D + 1);
    for (int axis = 0; axis < D; ++axis)
      line.direction[axis] = 0.1 + to_unit(hash_words(k, static_cast<std::uint64_t>(axis)));
    line.direction *= 1 / norm(line.direction);
    lines.push_back(line);
  }
  const std::vector<Crossing> crossings = find_crossings(subject, lines);
  for (std::size_t i = 0; i < crossings.size();) {
    std::size_t j = i;
    int depth = 0;
    double wrong = 0;
    for (; j < crossings.size() && crossings[j].line == crossings[i].line; ++j) {
      if (j > i && (depth < 0 || depth > 1)) wrong += crossings[j].at - crossings[j - 1].at;
      depth += crossings[j].step;
    }
    if (depth == 0 && wrong > kShort * subject.topology.box().diagonal())
      tally.fault(kOverlap, wrong, lines[crossings[i].line].simplex);
    i = j;
  }
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
