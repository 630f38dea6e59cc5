#include "domain/flatten.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voropack::domain_impl {

namespace {

/// Newton's method doubles the digits with each step; noise of 1e-5 needs three.
constexpr int kMaxNewtonSteps = 8;
/// Enough for the digits that one Newton step can gain, unless planes are nearly parallel.
constexpr int kMaxGradientSteps = 400;
constexpr double kGradientReduction = 1e-9;
/// So many steps are between two looks whether points have left their limit already.
constexpr int kStepsBetweenLooks = 16;

/// Points x and planes with the equations n * (x - o) = 0, one for each point of a sheet.
class Incidences {
 public:
  Incidences(const std::vector<Vec<3>>& points, const std::vector<const Sheet*>& sheets, double noise, double limit)
      : points_(points), sheets_(sheets), limit_(limit), local_(points.size(), kNone) {
    choose_points(noise);
    for (const Vec<3>& x : points) center_ += x / static_cast<double>(points.size());
    for (const Index p : moving_) x_.push_back(points[p] - center_);
    for (const Sheet* sheet : sheets) add_plane(*sheet);
  }

  /// Newton's method until the equations hold up to rounding, no longer improve, or move points too far.
  void solve() {
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kMaxNewtonSteps; ++step) {
      const std::vector<double> residual = residuals();
      double worst = 0;
      for (const double r : residual) worst = std::max(worst, std::abs(r));
      if (!(worst < 0.5 * before) || worst == 0) return;
      before = worst;
      const Step change = pull(multipliers(residual));
      move(change);
      if (is_too_far(change)) return;
    }
  }

  [[nodiscard]] const std::vector<Index>& moving() const { return moving_; }

  /// The new position of moving()[i]; exact where it lies on planes normal to an axis.
  [[nodiscard]] std::vector<Vec<3>> positions() const {
    std::vector<Vec<3>> result;
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      const Vec<3>& old = points_[moving_[i]];
      result.push_back(old + (x_[i] - (old - center_)));
    }
    for (std::size_t row = 0; row < row_point_.size(); ++row) {
      const Sheet& sheet = *sheets_[row_plane_[row]];
      for (int k = 0; k < 3 && sheet.is_exact; ++k)
        if (sheet.frame.normal[k] != 0) result[row_point_[row]][k] = sheet.frame.origin[k];
    }
    return result;
  }

 private:
  struct Plane {
    Vec<3> origin, u, v, normal;
    double radius = 0;      ///< By which tilts are scaled to lengths.
    double compliance = 0;  ///< 0: it stays.
  };

  /// The points of sheets that are not planar, and of those that share points with them.
  void choose_points(double noise) {
    std::vector<std::vector<Index>> point_sheets(points_.size());
    std::vector<Index> stack;
    std::vector<char> reached(sheets_.size(), 0);
    for (Index s = 0; s < sheets_.size(); ++s) {
      for (const Index p : sheets_[s]->points) point_sheets[p].push_back(s);
      if (sheets_[s]->deviation <= noise) continue;
      reached[s] = 1;
      stack.push_back(s);
    }
    while (!stack.empty()) {
      const Index s = stack.back();
      stack.pop_back();
      for (const Index p : sheets_[s]->points) {
        if (local_[p] != kNone) continue;
        local_[p] = static_cast<Index>(moving_.size());
        moving_.push_back(p);
        for (const Index other : point_sheets[p]) {
          // A plane that stays passes nothing on.
          if (reached[other] != 0 || sheets_[other]->is_exact) continue;
          reached[other] = 1;
          stack.push_back(other);
        }
      }
    }
  }

  void add_plane(const Sheet& sheet) {
    const auto index = static_cast<Index>(planes_.size());
    const PlaneFrame& frame = sheet.frame;
    Plane plane{frame.origin - center_, frame.u, frame.v, frame.normal};
    double sum = 0;
    std::size_t n = 0;
    for (const Index p : sheet.points) {
      if (local_[p] == kNone) continue;
      row_point_.push_back(local_[p]);
      row_plane_.push_back(index);
      sum += distance_sq(points_[p] - center_, plane.origin);
      ++n;
    }
    // As many equations pull at a plane as it has points: with this compliance it follows them rather than they it.
    plane.radius = n > 0 && sum > 0 ? std::sqrt(sum / static_cast<double>(n)) : 1;
    plane.compliance = sheet.is_exact ? 0 : static_cast<double>(n);
    planes_.push_back(plane);
  }

  [[nodiscard]] std::vector<double> residuals() const {
    std::vector<double> r(row_point_.size());
    for (std::size_t row = 0; row < r.size(); ++row) {
      const Plane& plane = planes_[row_plane_[row]];
      r[row] = dot(x_[row_point_[row]] - plane.origin, plane.normal);
    }
    return r;
  }

  /// The derivative of an equation by the plane's offset and its tilts about v and u.
  [[nodiscard]] Vec<3> by_plane(std::size_t row) const {
    const Plane& plane = planes_[row_plane_[row]];
    const Vec<3> arm = (x_[row_point_[row]] - plane.origin) / plane.radius;
    return {-1.0, dot(arm, plane.u), dot(arm, plane.v)};
  }

  struct Step {
    std::vector<Vec<3>> points, planes;
  };

  /// W J^T y, where J is the derivative of the equations and W the compliances.
  [[nodiscard]] Step pull(const std::vector<double>& y) const {
    Step step{std::vector<Vec<3>>(x_.size()), std::vector<Vec<3>>(planes_.size())};
    for (std::size_t row = 0; row < y.size(); ++row) {
      step.points[row_point_[row]] += y[row] * planes_[row_plane_[row]].normal;
      step.planes[row_plane_[row]] += y[row] * by_plane(row);
    }
    for (std::size_t s = 0; s < planes_.size(); ++s) step.planes[s] *= planes_[s].compliance;
    return step;
  }

  [[nodiscard]] std::vector<double> multiply(const std::vector<double>& y) const {
    const Step step = pull(y);
    std::vector<double> result(y.size());
    for (std::size_t row = 0; row < y.size(); ++row)
      result[row] = dot(planes_[row_plane_[row]].normal, step.points[row_point_[row]]) +
                    dot(by_plane(row), step.planes[row_plane_[row]]);
    return result;
  }

  /// Solves J W J^T y = -residual by conjugate gradients, preconditioned by the diagonal.
  [[nodiscard]] std::vector<double> multipliers(const std::vector<double>& residual) const {
    const std::size_t n = residual.size();
    std::vector<double> y(n, 0), r(n), z(n), inverse(n);
    for (std::size_t i = 0; i < n; ++i) {
      inverse[i] = 1 / (1 + planes_[row_plane_[i]].compliance * norm_sq(by_plane(i)));
      r[i] = -residual[i];
      z[i] = inverse[i] * r[i];
    }
    const auto product = [n](const std::vector<double>& a, const std::vector<double>& b) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
      return sum;
    };
    std::vector<double> direction = z;
    double rz = product(r, z);
    const double goal = rz * kGradientReduction * kGradientReduction;
    for (int step = 1; step <= kMaxGradientSteps && rz > goal; ++step) {
      // The energy of the displacement grows with each step: what is too far will not come back.
      if (step % kStepsBetweenLooks == 0 && is_too_far(pull(y))) break;
      const std::vector<double> image = multiply(direction);
      const double curvature = product(direction, image);
      if (!(curvature > 0)) break;
      const double alpha = rz / curvature;
      for (std::size_t i = 0; i < n; ++i) {
        y[i] += alpha * direction[i];
        r[i] -= alpha * image[i];
        z[i] = inverse[i] * r[i];
      }
      const double next = product(r, z), beta = next / rz;
      rz = next;
      for (std::size_t i = 0; i < n; ++i) direction[i] = z[i] + beta * direction[i];
    }
    return y;
  }

  /// Far beyond the limit, which is held against the final positions.
  [[nodiscard]] bool is_too_far(const Step& step) const {
    return std::any_of(step.points.begin(), step.points.end(),
                       [&](const Vec<3>& x) { return !(norm_sq(x) <= 4 * limit_ * limit_); });
  }

  void move(const Step& step) {
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += step.points[i];
    for (std::size_t s = 0; s < planes_.size(); ++s) {
      Plane& plane = planes_[s];
      if (plane.compliance == 0) continue;
      plane.origin += step.planes[s][0] * plane.normal;
      plane.normal += (step.planes[s][1] * plane.u + step.planes[s][2] * plane.v) / plane.radius;
      plane.normal = plane.normal / norm(plane.normal);
      plane.u -= dot(plane.u, plane.normal) * plane.normal;
      plane.u = plane.u / norm(plane.u);
      plane.v = cross(plane.normal, plane.u);
    }
  }

  const std::vector<Vec<3>>& points_;
  const std::vector<const Sheet*>& sheets_;
  double limit_;
  std::vector<Index> local_;  ///< By point: its index in moving_, or kNone.
  std::vector<Index> moving_;
  Vec<3> center_;
  std::vector<Vec<3>> x_;  ///< Positions relative to center_.
  std::vector<Plane> planes_;
  std::vector<Index> row_point_, row_plane_;  ///< By equation.
};

}  // namespace

FlatPoints flatten_sheets(const std::vector<Vec<3>>& points, const std::vector<const Sheet*>& sheets, double tolerance,
                          double limit, double told) {
  FlatPoints result{points, {}};
  Incidences incidences(points, sheets, kVisibleNoise * tolerance, limit);
  if (incidences.moving().empty()) return result;
  incidences.solve();
  const std::vector<Vec<3>> positions = incidences.positions();
  std::vector<double> excess(points.size(), 0);  // Of displacement or distance from a plane, over what is allowed.
  std::vector<char> moves(points.size(), 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Index p = incidences.moving()[i];
    moves[p] = 1;
    result.positions[p] = positions[i];
    const double displacement = distance(positions[i], points[p]);
    excess[p] = std::isfinite(displacement) ? displacement / limit : std::numeric_limits<double>::infinity();
  }
  for (const Sheet* sheet : sheets) {
    Sheet flat = *sheet;
    fit_points(result.positions, flat);
    for (const Index p : flat.points)
      if (moves[p] != 0)
        excess[p] = std::max(excess[p], std::abs(flat.frame.height(result.positions[p])) / (0.5 * tolerance));
  }
  const double worst = *std::max_element(excess.begin(), excess.end());
  for (Index p = 0; p < excess.size() && worst > 1; ++p)
    if (excess[p] > std::max(1.0, told * worst) || std::isinf(excess[p])) result.failed.push_back(p);
  return result;
}

}  // namespace voropack::domain_impl
