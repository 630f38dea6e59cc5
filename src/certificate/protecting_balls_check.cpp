// Check `protecting_balls`: no vertex lies strictly inside the smallest ball through the corners of a boundary simplex
// or of a segment edge. By theorem T0 (docs/theory/certificate.md) this is what makes the mesh boundary conforming.
#include <algorithm>

#include "base/parallel.h"
#include "certificate/checks.h"

namespace voropack::judge {

namespace {

enum BallFault : int { kVertexInside = 1, kDegenerate };

template <int D>
int exact_side(const Subject<D>& subject, const ProtectingBall<D>& ball, const Vec<D>& q) {
  const Vec<D>& a = subject.point(ball.corner[0]);
  const Vec<D>& b = subject.point(ball.corner[1]);
  if constexpr (D == 3)
    if (ball.n_corners == 3) return in_diametral_ball(a, b, subject.point(ball.corner[2]), q);
  return in_diametral_ball(a, b, q);
}

/// Looks for the vertex deepest inside. Distances that double precision decides are not decided again.
template <int D>
void test_ball(const Subject<D>& subject, std::uint32_t index, Tally& tally) {
  const ProtectingBall<D>& ball = subject.balls[index];
  if (ball.ball.degenerate || !std::isfinite(ball.ball.radius_sq) || !is_finite(ball.ball.center)) {
    if (ball.ball.degenerate)
      tally.violation(kDegenerate, kNoFigure, index);
    else
      ++tally.undecided;
    return;
  }
  const double radius = std::sqrt(ball.ball.radius_sq);
  const double error = ball.ball.error + 8 * kUnitRoundoff * (radius + norm(ball.ball.center));
  const double inner = std::max(0.0, radius - 2 * error);
  const double outer = radius + 2 * error;
  const VertexTree<D>& vertices = subject.vertices;
  double nearest_sq = outer * outer;
  std::uint32_t nearest = kNone;
  bool is_inside = false;
  const auto own = [&](std::uint32_t v) {
    return std::find(ball.corner.begin(), ball.corner.begin() + ball.n_corners, v) !=
           ball.corner.begin() + ball.n_corners;
  };
  vertices.tree.visit([&](const Box<D>& box, double) { return box.distance_sq(ball.ball.center) <= nearest_sq; },
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i) {
                          const double gap_sq = distance_sq(vertices.point[i], ball.ball.center);
                          if (!(gap_sq < nearest_sq)) continue;
                          const std::uint32_t v = vertices.id[i];
                          if (own(v) || !subject.topology.used(v)) continue;
                          if (gap_sq >= inner * inner && exact_side(subject, ball, vertices.point[i]) <= 0) continue;
                          nearest_sq = gap_sq;
                          nearest = v;
                          is_inside = true;
                        }
                      });
  if (is_inside)
    tally.violation(kVertexInside, 1 - nearest_sq / ball.ball.radius_sq, index, nearest);
  else
    tally.legal(0, index, nearest);
}

}  // namespace

template <int D>
Check check_protecting_balls(const Subject<D>& subject) {
  const Tally tally = parallel_reduce_ordered(
      subject.balls.size(), 256, Tally{},
      [&](std::size_t begin, std::size_t end) {
        subject.observer.check_cancelled();
        Tally block;
        for (std::size_t i = begin; i < end; ++i) {
          if (!subject.balls[i].derived) test_ball(subject, static_cast<std::uint32_t>(i), block);
        }
        return block;
      },
      [](Tally a, const Tally& b) { return a += b; });
  std::string where;
  if (tally.worst.present) {
    where = subject.ball_text(subject.balls[tally.worst.ids[0]]);
    if (tally.worst.kind == kDegenerate) where += " is degenerate";
    if (tally.worst.kind == kVertexInside)
      where += " has " + subject.vertex_text(tally.worst.ids[1]) + " in its protecting ball";
  }
  return make_check("protecting_balls", tally, where);
}

template Check check_protecting_balls(const Subject<2>&);
template Check check_protecting_balls(const Subject<3>&);

}  // namespace voropack::judge
