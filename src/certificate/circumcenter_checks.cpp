// Checks `voronoi_maximal`, `voronoi_containment` and `radius_edge`: one pass over the circumcenters of the simplices.
#include <algorithm>

#include "base/parallel.h"
#include "certificate/checks.h"
#include "geom/tolerance.h"

namespace voropack::judge {

namespace {

/// Relative slack of comparisons between lengths that were computed in double precision.
constexpr double kSlack = 1e-9;

/// A circumcenter beyond a boundary face by less than this part of its radius lies on it, up to rounding.
constexpr double kOnFace = 1e-9;

/// Barycentric coordinates above minus this are those of a point in the simplex: a walk has arrived.
constexpr double kInside = 1e-12;

/// Largest radius-edge ratio to accept where the theory gives no bound. What the epsilon-maximal forms keep, and most
/// meshes of other programs.
constexpr double kPracticalRadiusEdge = 4;
/// What Voronoi-maximal packings keep away from sharp features, whatever b is: they shrink f where a simplex exceeds
/// it.
constexpr double kVoronoiRadiusEdge = 2.5;

/// Sharp simplices may have a ratio of this over the sine of half the angle: a triangle or tetrahedron between two
/// polytopes at that angle has its short edges across. Up to 7.6 has been seen.
constexpr double kSharpRadiusEdge = 8;

enum MaximalFault : int { kInsertable = 1 };
enum ContainmentFault : int { kBeyondFace = 1, kWalkLost };

/// Largest radius-edge ratio of simplices whose circumcenter cannot be added for a given reason.
///
/// Lemmas 3.1, 3.5 and 3.8 of [Miller1996] with the Lipschitz constant b apart from the feature factor, and for
/// epsilon-maximal packings (E = epsilon): f(c) >= delta * R if a vertex blocks c, with
/// delta = (1 - b) / (2 + E (1 + b)). In a ball of radius Q whose own center satisfies f >= delta Q (enlarged by E f),
/// f(c) >= G(delta) R with G(delta) = (delta - b) / (sqrt 2 (1 + b E) + E (delta - b)). With f(c) >= g R the ratio is
/// at most 1 / (2 (g - b)). For E = 0 these are the three bounds of the lemmas.
struct RatioBounds {
  double vertex, edge_ball, face_ball;
};

double ratio_bound(double g, double b, PackingForm form) {
  const double bound = g > b ? 1 / (2 * (g - b)) : kPracticalRadiusEdge;
  return form == PackingForm::kVoronoi ? std::min(bound, kVoronoiRadiusEdge) : bound;
}

RatioBounds ratio_bounds(const CertificateOptions& options, bool has_spacing, double b) {
  if (options.radius_edge) return {*options.radius_edge, *options.radius_edge, *options.radius_edge};
  if (!has_spacing || b >= 1) return {kPracticalRadiusEdge, kPracticalRadiusEdge, kPracticalRadiusEdge};
  const double epsilon = options.form == PackingForm::kVoronoi ? 0 : options.epsilon;
  const auto in_ball = [&](double delta) {
    return (delta - b) / (std::sqrt(2.0) * (1 + b * epsilon) + epsilon * (delta - b));
  };
  const double delta_1 = (1 - b) / (2 + epsilon * (1 + b));
  const double delta_2 = std::min(delta_1, in_ball(delta_1));
  return {ratio_bound(delta_1, b, options.form), ratio_bound(in_ball(delta_1), b, options.form),
          ratio_bound(in_ball(delta_2), b, options.form)};
}

/// Which protecting balls hold a point.
struct BallsAround {
  bool edge = false;
  bool face = false;
  [[nodiscard]] bool any() const { return edge || face; }
};

enum class Blocked : std::uint8_t { kNo, kByVertex, kByBall, kUnknown };

/// Radius-edge ratios beyond the bound of the interior, by what allows them.
struct RatioClass {
  std::uint64_t count = 0;
  double worst = 0;
  void add(double ratio) {
    ++count;
    worst = std::max(worst, ratio);
  }
  RatioClass& operator+=(const RatioClass& other) {
    count += other.count;
    worst = std::max(worst, other.worst);
    return *this;
  }
};

struct Tallies {
  Tally maximal, containment, ratio;
  RatioClass edge_balls, face_balls, sharp;
  double sharp_constant = 0;  ///< The largest ratio of a sharp simplex times the sine of half its angle.
  Tallies& operator+=(const Tallies& other) {
    edge_balls += other.edge_balls;
    face_balls += other.face_balls;
    sharp += other.sharp;
    sharp_constant = std::max(sharp_constant, other.sharp_constant);
    maximal += other.maximal;
    containment += other.containment;
    ratio += other.ratio;
    return *this;
  }
};

template <int D>
class CircumcenterPass {
 public:
  explicit CircumcenterPass(const Subject<D>& subject)
      : subject_(subject),
        topology_(subject.topology),
        bounds_(ratio_bounds(subject.options, subject.has_spacing, subject.gradation)),
        epsilon_(subject.options.form == PackingForm::kVoronoi ? 0 : subject.options.epsilon),
        ball_tree_(
            subject.balls.size(),
            [&](std::size_t i) {
              const DiametralBall<D>& ball = subject.balls[i].ball;
              if (!is_finite(ball.center) || !std::isfinite(ball.radius_sq))
                return Box<D>(subject.point(subject.balls[i].corner[0]), subject.point(subject.balls[i].corner[0]));
              Box<D> box(ball.center, ball.center);
              box.inflate((1 + kSlack) * (std::sqrt(ball.radius_sq) + ball.error));
              return box;
            },
            [](std::size_t) { return 0.0; }) {}

  void test(std::size_t s, Tallies& tallies) const {
    const std::array<Vec<D>, D + 1> p = topology_.corners(s);
    const Circumball<D> ball = circumball<D>(p);
    if (!(ball.determinant > 0) || !std::isfinite(ball.radius)) return;  // Flat or inverted: see `delaunay`.
    const auto id = static_cast<std::uint32_t>(s);
    const bool contained = test_containment(s, p, ball, tallies.containment);
    std::optional<BallsAround> around;
    Blocked blocked = Blocked::kUnknown;
    if (subject_.has_spacing && contained) {
      const CornerSpacings f = corner_spacings(s);
      blocked = find_blocker(f, ball, around);
      // R / (2 f) with f the mean of the corners: above 1 a point would fit at the circumcenter if f were constant.
      if (blocked == Blocked::kUnknown)
        ++tallies.maximal.undecided;
      else if (blocked == Blocked::kNo)
        tallies.maximal.violation(kInsertable, ball.radius * (D + 1) / (2 * f.sum), id);
      else
        tallies.maximal.legal_quotient(ball.radius * (D + 1), 2 * f.sum, id);
    }
    test_ratio(id, p, ball, blocked, around, tallies);
  }

 private:
  /// The spacings at the corners of a simplex.
  struct CornerSpacings {
    double sum = 0;
    double least = std::numeric_limits<double>::infinity();
    double largest = 0;
  };
  [[nodiscard]] CornerSpacings corner_spacings(std::size_t s) const {
    CornerSpacings corners;
    for (const VertexId v : subject_.mesh.simplex_vertices[SimplexId(s)]) {
      const double f = subject_.spacing(v.value());
      corners.sum += f;
      corners.least = std::min(corners.least, f);
      corners.largest = std::max(corners.largest, f);
    }
    return corners;
  }

  /// True if c is in no simplex but this region's: the straight way from the barycenter to c crosses no boundary face.
  bool test_containment(std::size_t s, const std::array<Vec<D>, D + 1>& p, const Circumball<D>& ball,
                        Tally& tally) const {
    const auto id = static_cast<std::uint32_t>(s);
    unsigned n_negative = 0;
    for (const double coordinate : ball.barycentric) n_negative += coordinate < 0 ? 1U : 0U;
    if (n_negative == 0) {
      tally.legal(0, id, id);
      return true;
    }
    // All barycentric coordinates shrink from 1 / (D + 1) to the circumcenter's; the most negative is the exit.
    int exit =
        static_cast<int>(std::min_element(ball.barycentric.begin(), ball.barycentric.end()) - ball.barycentric.begin());
    Vec<D> start;
    for (const Vec<D>& corner : p) start += corner / (D + 1);
    std::size_t here = s;
    double coordinate = ball.barycentric[static_cast<std::size_t>(exit)];
    constexpr int kMaxSteps = 100'000;
    for (int step = 0; step < kMaxSteps; ++step) {
      const std::uint32_t next = topology_.neighbor(here, exit);
      if (topology_.on_boundary(here, exit) || next == kNone) {
        const double beyond = -coordinate * height<D>(topology_.corners(here), static_cast<std::size_t>(exit));
        const double figure = beyond / ball.radius;
        if (beyond > kOnFace * ball.radius + ball.error) {
          tally.violation(kBeyondFace, figure, id, static_cast<std::uint32_t>(here), static_cast<std::uint32_t>(exit));
          return false;
        }
        tally.legal(figure, id, static_cast<std::uint32_t>(here));
        return true;
      }
      const int entry = topology_.corner_towards(next, here);
      here = next;
      const auto [from, end] = barycentric<D>(topology_.corners(here), start, ball.center);
      exit = -1;
      double first = std::numeric_limits<double>::infinity();
      for (int i = 0; i <= D; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (i == entry || !(end[k] < -kInside)) continue;
        const double at = from[k] > 0 ? from[k] / (from[k] - end[k]) : 0;
        if (at < first) {
          first = at;
          exit = i;
          coordinate = end[k];
        }
      }
      if (exit < 0) {
        tally.legal(0, id, static_cast<std::uint32_t>(here));
        return true;
      }
    }
    tally.violation(kWalkLost, kNoFigure, id, static_cast<std::uint32_t>(here));
    return false;
  }

  /// The protecting balls that hold c, closed, enlarged by the margin that the maker may keep and by `extra`.
  [[nodiscard]] BallsAround balls_around(const Circumball<D>& c, double extra) const {
    BallsAround around;
    ball_tree_.visit(
        [&](const Box<D>& box, double) {
          const double reach = extra + c.error + kSlack * c.radius;
          return box.distance_sq(c.center) <= reach * reach;
        },
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            const ProtectingBall<D>& ball = subject_.balls[ball_tree_.order()[i]];
            const double reach =
                (1 + 2 * kBallMargin) * std::sqrt(ball.ball.radius_sq) + ball.ball.error + c.error + extra;
            if (!(distance_sq(ball.ball.center, c.center) <= reach * reach)) continue;
            (ball.n_corners == 2 ? around.edge : around.face) = true;
          }
        });
    return around;
  }

  /// Does any vertex q satisfy |c - q| <= f(c) + f(q)?
  [[nodiscard]] bool vertex_blocks(const Circumball<D>& c, double f) const {
    const VertexTree<D>& vertices = subject_.vertices;
    bool found = false;
    const double slack = c.error + kSlack * c.radius;
    vertices.tree.visit(
        [&](const Box<D>& box, double weight) {
          const double reach = f + weight + slack;
          return !found && box.distance_sq(c.center) <= reach * reach;
        },
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            const double reach = f + vertices.spacing[i] + slack;
            found = found || distance_sq(vertices.point[i], c.center) <= reach * reach;
          }
        });
    return found;
  }

  /// Why c cannot be added. f(c) is only known to lie in [low, high] unless the options give f.
  Blocked find_blocker(const CornerSpacings& corners, const Circumball<D>& ball,
                       std::optional<BallsAround>& around) const {
    const double low = std::max(0.0, corners.largest - subject_.gradation * ball.radius);
    double high = corners.least + subject_.gradation * ball.radius;
    // R (1 - b) <= (2 + E (1 + b)) f(c) is what an epsilon-maximal packing promises; with E = 0, that some corner
    // blocks c is the same but for the use of b.
    const double b = subject_.gradation;
    const double radius = ball.radius * (1 - kSlack) - ball.error;
    const auto corner_blocks = [&](double f) {
      if (epsilon_ > 0) return radius * (1 - b) <= (2 + epsilon_ * (1 + b)) * f;
      return radius <= f + corners.largest;
    };
    if (corner_blocks(low)) return Blocked::kByVertex;
    bool exact = false;
    if (subject_.options.spacing) {
      const double f = subject_.options.spacing(std::span<const double>(ball.center.coord));
      high = f;
      exact = true;
      if (corner_blocks(f)) return Blocked::kByVertex;
    }
    around = balls_around(ball, epsilon_ * high);
    if (around->any()) return Blocked::kByBall;
    if (corner_blocks(high) || vertex_blocks(ball, high)) return exact ? Blocked::kByVertex : Blocked::kUnknown;
    return Blocked::kNo;
  }

  void test_ratio(std::uint32_t s, const std::array<Vec<D>, D + 1>& p, const Circumball<D>& ball, Blocked blocked,
                  std::optional<BallsAround>& around, Tallies& tallies) const {
    Tally& tally = tallies.ratio;
    double shortest_sq = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < D; ++i)
      for (std::size_t j = i + 1; j <= D; ++j) shortest_sq = std::min(shortest_sq, distance_sq(p[i], p[j]));
    // Most ratios are far below the bound and the worst one, which squares tell without a root.
    const double noted = !tally.worst.present ? 0 : tally.worst.kind > 0 ? bounds_.vertex : tally.worst.figure;
    const double common = std::min(bounds_.vertex, noted) * (1 - kSlack);
    if (ball.radius * ball.radius < common * common * shortest_sq) {
      ++tally.tested;
      return;
    }
    const double ratio = ball.radius / std::sqrt(shortest_sq);
    double bound = bounds_.vertex;
    if (ratio > bound * (1 + kSlack)) {
      if (const std::optional<double> angle = sharp_angle(s)) {
        const double sine = std::sin(0.5 * *angle);
        bound = std::max(bound, kSharpRadiusEdge / sine);
        tallies.sharp.add(ratio);
        tallies.sharp_constant = std::max(tallies.sharp_constant, ratio * sine);
      } else if (blocked != Blocked::kByVertex) {
        const double f = subject_.has_spacing ? corner_spacings(s).largest + subject_.gradation * ball.radius : 0;
        if (!around) around = balls_around(ball, epsilon_ * f);
        if (around->face) {
          bound = std::max(bound, bounds_.face_ball);
          tallies.face_balls.add(ratio);
        } else if (around->edge) {
          bound = std::max(bound, bounds_.edge_ball);
          tallies.edge_balls.add(ratio);
        }
      }
    }
    if (ratio > bound * (1 + kSlack))
      tally.violation(1, ratio, s);
    else
      tally.legal(ratio, s);
  }

  /// The smallest angle of a sharp feature on two of whose polytopes corners of the simplex lie.
  [[nodiscard]] std::optional<double> sharp_angle(std::uint32_t s) const {
    std::optional<double> least;
    if (subject_.sharp.empty()) return least;
    const auto& v = subject_.mesh.simplex_vertices[SimplexId(s)];
    for (std::size_t i = 0; i < D; ++i)
      for (std::size_t j = i + 1; j <= D; ++j)
        if (const auto angle = subject_.sharp.angle(v[i].value(), v[j].value()); angle && (!least || *angle < *least))
          least = angle;
    return least;
  }

  const Subject<D>& subject_;
  const Topology<D>& topology_;
  RatioBounds bounds_;
  double epsilon_;
  BoxTree<D> ball_tree_;
};

template <int D>
std::string describe_containment(const Subject<D>& subject, const Finding& worst) {
  if (!worst.present) return {};
  std::string text = subject.simplex_text(worst.ids[0]);
  if (worst.kind == kBeyondFace) {
    text +=
        " has its circumcenter beyond the boundary face of simplex " + std::to_string(worst.ids[1]) + " with vertices";
    const auto& v = subject.mesh.simplex_vertices[SimplexId(worst.ids[1])];
    for (std::size_t i = 0; i <= D; ++i)
      if (i != worst.ids[2]) text += ' ' + std::to_string(v[i].value());
  }
  if (worst.kind == kWalkLost) text += ": the way to its circumcenter does not end";
  return text;
}

}  // namespace

std::string describe_classes(const Tallies& tallies) {
  std::string text;
  const auto add = [&](const char* name, const RatioClass& c) {
    if (c.count > 0) text += "; " + std::string(name) + ": " + std::to_string(c.count) + ", at most " + number(c.worst);
  };
  add("beyond the interior's bound in edge balls", tallies.edge_balls);
  add("in facet balls", tallies.face_balls);
  add("sharp", tallies.sharp);
  if (tallies.sharp.count > 0) text += " and " + number(tallies.sharp_constant) + " / sin(angle / 2)";
  return text;
}

template <int D>
std::array<Check, 3> check_circumcenters(const Subject<D>& subject) {
  const CircumcenterPass<D> pass(subject);
  const Tallies tallies = parallel_reduce_ordered(
      subject.mesh.simplex_vertices.size(), kBlock, Tallies{},
      [&](std::size_t begin, std::size_t end) {
        subject.observer.check_cancelled();
        Tallies block;
        for (std::size_t s = begin; s < end; ++s)
          if (subject.topology.valid(s)) pass.test(s, block);
        return block;
      },
      [](Tallies a, const Tallies& b) { return a += b; });
  const auto simplex = [&](const Tally& tally, const char* fault) {
    if (!tally.worst.present) return std::string();
    return subject.simplex_text(tally.worst.ids[0]) + (tally.worst.kind > 0 ? fault : "");
  };
  return {
      make_check("voronoi_maximal", tallies.maximal, simplex(tallies.maximal, ": a vertex fits at its circumcenter")),
      make_check("voronoi_containment", tallies.containment, describe_containment(subject, tallies.containment.worst)),
      make_check("radius_edge", tallies.ratio,
                 simplex(tallies.ratio, ": longer than its class allows") + describe_classes(tallies))};
}

template std::array<Check, 3> check_circumcenters(const Subject<2>&);
template std::array<Check, 3> check_circumcenters(const Subject<3>&);

}  // namespace voropack::judge
