#include "domain/sheets.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "domain/plane.h"

namespace voropack::domain_impl {

namespace {

/// A facet thinner than this many times the merge distance has a normal that noise may turn anywhere.
constexpr double kThinFacet = 4;

/// Sums from which the plane of least squares follows, as heights over the plane of a first facet.
class PlaneFit {
 public:
  explicit PlaneFit(const PlaneFrame& base) : base_(base) {}

  void add(const Vec<3>& x) {
    const Vec<2> uv = base_.to_plane(x);
    const std::array<double, 3> q = {uv[0], uv[1], base_.height(x)};
    ++n_;
    for (std::size_t i = 0; i < 3; ++i) {
      sum_[i] += q[i];
      for (std::size_t j = i; j < 3; ++j) product_[i][j] += q[i] * q[j];
    }
  }

  struct Plane {
    Vec<3> origin, normal;
  };

  [[nodiscard]] Plane plane() const {
    const auto covariance = [&](std::size_t i, std::size_t j) { return product_[i][j] - sum_[i] * sum_[j] / n_; };
    const double uu = covariance(0, 0), uv = covariance(0, 1), vv = covariance(1, 1);
    const double uz = covariance(0, 2), vz = covariance(1, 2), determinant = uu * vv - uv * uv;
    Plane plane{base_.from_plane({sum_[0] / n_, sum_[1] / n_}) + sum_[2] / n_ * base_.normal, base_.normal};
    // Points on one line leave the plane as it was.
    if (!(determinant > 1e-12 * (uu + vv) * (uu + vv))) return plane;
    const double a = (vv * uz - uv * vz) / determinant, b = (uu * vz - uv * uz) / determinant;
    const Vec<3> normal = base_.normal - a * base_.u - b * base_.v;
    plane.normal = normal / norm(normal);
    return plane;
  }

 private:
  PlaneFrame base_;
  double n_ = 0;
  std::array<double, 3> sum_{};
  std::array<std::array<double, 3>, 3> product_{};
};

class Grower {
 public:
  Grower(const Complex<3>& complex, const MergeLimits& limits, bool merge)
      : complex_(complex),
        limits_(limits),
        merge_(merge),
        taken_(complex.facets.size(), 0),
        point_pass_(complex.points.size(), 0) {
    for (const WorkFacet& facet : complex.facets) {
      Box<3> box;
      for (const Index p : facet.points) box.add(complex.points[p]);
      extent_.push_back(box.diagonal());
    }
    point_facets_.resize(complex.points.size());
    for (Index f = 0; f < complex.facets.size(); ++f)
      for (const Index p : complex.facets[f].points) point_facets_[p].push_back(f);
  }

  std::vector<Sheet> run() {
    std::vector<Index> order(complex_.facets.size());
    std::iota(order.begin(), order.end(), 0U);
    // The planes of large facets are known best.
    std::stable_sort(order.begin(), order.end(),
                     [&](Index f, Index g) { return complex_.facets[f].area > complex_.facets[g].area; });
    std::vector<Sheet> sheets;
    for (const Index seed : order) {
      if (taken_[seed] == 0) sheets.push_back(grow(seed));
    }
    return sheets;
  }

 private:
  [[nodiscard]] bool fits(const Vec<3>& origin, const Vec<3>& normal, Index f) const {
    const WorkFacet& facet = complex_.facets[f];
    for (const Index p : facet.points)
      if (std::abs(dot(complex_.points[p] - origin, normal)) > limits_.distance) return false;
    if (facet.area <= 0.5 * kThinFacet * limits_.distance * extent_[f]) return true;
    return norm(cross(facet.frame.normal, normal)) <= limits_.sine;
  }

  void add(PlaneFit& fit, Index f) const {
    for (const Index p : complex_.facets[f].points) fit.add(complex_.points[p]);
  }

  /// Facets around `seed` that fit the plane of all of them.
  Sheet grow(Index seed) {
    Sheet sheet{{seed}, {}, {}};
    std::vector<Index>& members = sheet.facets;
    taken_[seed] = 1;
    PlaneFit fit(complex_.facets[seed].frame);
    add(fit, seed);
    // The plane turns as more of it is known: what did not fit before may do so now.
    for (std::size_t before = 0; merge_ && before < members.size();) {
      before = members.size();
      extend(members, fit);
    }
    fit_sheet(complex_, sheet);
    while (members.size() > 1) {
      const auto kept = std::stable_partition(members.begin(), members.end(),
                                              [&](Index f) { return fits(sheet.frame.origin, sheet.frame.normal, f); });
      if (kept == members.end()) break;
      const bool lost = kept == members.begin() || members.front() != seed;
      for (auto f = lost ? members.begin() : kept; f != members.end(); ++f) taken_[*f] = 0;
      members.erase(kept, members.end());
      if (lost) members = {seed};
      fit_sheet(complex_, sheet);
    }
    taken_[seed] = 1;
    std::sort(members.begin(), members.end());
    return sheet;
  }

  void extend(std::vector<Index>& members, PlaneFit& fit) {
    ++pass_;
    PlaneFit::Plane plane = fit.plane();
    for (std::size_t i = 0; i < members.size(); ++i)
      for (const Index p : complex_.facets[members[i]].points) {
        if (point_pass_[p] == pass_) continue;
        point_pass_[p] = pass_;
        for (const Index f : point_facets_[p]) {
          if (taken_[f] != 0 || !fits(plane.origin, plane.normal, f)) continue;
          taken_[f] = 1;
          members.push_back(f);
          add(fit, f);
          plane = fit.plane();
        }
      }
  }

  const Complex<3>& complex_;
  MergeLimits limits_;
  bool merge_;
  std::vector<char> taken_;
  std::vector<double> extent_;
  std::vector<std::uint32_t> point_pass_;  ///< The last pass that looked at the facets of a point.
  std::uint32_t pass_ = 0;
  std::vector<std::vector<Index>> point_facets_;
};

}  // namespace

void fit_sheet(const Complex<3>& complex, Sheet& sheet) {
  sheet.points.clear();
  Index largest = sheet.facets.front();
  for (const Index f : sheet.facets) {
    const WorkFacet& facet = complex.facets[f];
    sheet.points.insert(sheet.points.end(), facet.points.begin(), facet.points.end());
    if (facet.area > complex.facets[largest].area) largest = f;
  }
  std::sort(sheet.points.begin(), sheet.points.end());
  sheet.points.erase(std::unique(sheet.points.begin(), sheet.points.end()), sheet.points.end());
  sheet.frame = complex.facets[largest].frame;
  fit_points(complex.points, sheet);
}

void fit_points(const std::vector<Vec<3>>& positions, Sheet& sheet) {
  std::vector<Vec<3>> own;
  for (const Index p : sheet.points) own.push_back(positions[p]);
  PlaneFit fit(sheet.frame);
  for (const Vec<3>& x : own) fit.add(x);
  const PlaneFit::Plane plane = fit.plane();
  sheet.frame = plane_frame(plane.normal, plane.origin, own);
  sheet.deviation = 0;
  for (const Vec<3>& x : own) sheet.deviation = std::max(sheet.deviation, std::abs(sheet.frame.height(x)));
  int n_zero = 0;
  for (int k = 0; k < 3; ++k) n_zero += sheet.frame.normal[k] == 0 ? 1 : 0;
  sheet.is_exact = n_zero == 2 && sheet.deviation == 0;
}

std::vector<Sheet> find_sheets(const Complex<3>& complex, const MergeLimits& limits, bool merge) {
  return Grower(complex, limits, merge).run();
}

}  // namespace voropack::domain_impl
