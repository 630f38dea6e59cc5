// Splits the number of vertices among the pairs of polytopes and the caps that f is the minimum of.
//
// At a point of a polytope of dimension d, vertices are as dense as f^-d. Let v_1 <= v_2 <= ... be what the pairs and
// caps ask for there, and w the user's wish. Pair k gets the part (f / v_k)^d - (f / v_k+1)^d of each vertex, the last
// one up to (f / w)^d. So the parts of all add up to 1 - (f / w)^d, and those of any set of pairs to at least what
// would be saved without them.
#include "packing/attribution.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "base/parallel.h"
#include "packing/incidence.h"
#include "packing/places.h"

namespace voropack {

namespace {

/// Points that stand for all: a feature with a tenth of all vertices is known to 5 % of itself.
constexpr std::size_t kMaxPoints = 3'000;
/// What would make f more than this many times larger is not looked for; its part goes to what decides f.
constexpr double kReach = 2;
/// Features of less than this many vertices are left out.
constexpr double kLeastCount = 1;

using Key = std::array<PolytopeId, 2>;

/// What a pair of polytopes accounts for.
template <int D>
struct Account {
  Key key;
  typename CostlyFeature<D>::Kind kind = CostlyFeature<D>::Kind::kGap;
  double angle_deg = 0;  // kAngle only.
  double count = 0;
  double weight = 0;      // Of what was added up in `moment`.
  Vec<D> moment;          // Positions times weights.
  double least_f = 0;     // The smallest f that it decides.
  double size_there = 0;  // SpacingCause::size there.
  [[nodiscard]] Vec<D> middle() const { return moment / weight; }
};

/// Every so many of the points, so that each stands for about the same number of vertices.
template <int D>
std::vector<CountedPoint<D>> thinned(std::vector<CountedPoint<D>> points) {
  std::erase_if(points, [](const auto& p) { return p.dimension == 0 || !(std::abs(p.count) > 0); });
  if (points.size() <= kMaxPoints) return points;
  double total = 0;
  for (const auto& p : points) total += std::abs(p.count);
  if (!std::isfinite(total)) return points;
  const double step = total / static_cast<double>(kMaxPoints);
  std::vector<CountedPoint<D>> kept;
  double sum = 0.5 * step;
  for (const auto& p : points) {
    const double before = std::floor(sum / step);
    sum += std::abs(p.count);
    const double times = std::floor(sum / step) - before;
    if (times > 0) kept.push_back({p.position, p.dimension, std::copysign(times * step, p.count)});
  }
  return kept;
}

/// The parts of one vertex.
struct Part {
  Key key;
  double part;
  double size;
};
struct Parts {
  double f = 0;
  std::vector<Part> parts;  // Of what decides f first.
};

template <int D>
Parts split(const Spacing<D>& spacing, const CountedPoint<D>& point) {
  const std::vector<SpacingCause> causes = spacing.causes(point.position, kReach);
  Parts result;
  if (causes.empty()) return result;
  const double f = causes.front().value, wish = spacing.wished(point.position);
  const auto density = [&](double value) { return std::pow(f / value, point.dimension); };
  result.f = f;
  double last = 1;  // The density of what has been handed out to the last one.
  for (const SpacingCause& cause : causes) {
    if (std::any_of(result.parts.begin(), result.parts.end(), [&](const Part& p) { return p.key == cause.polytopes; }))
      continue;
    if (!result.parts.empty()) result.parts.back().part = last - density(cause.value);
    last = density(cause.value);
    result.parts.push_back({cause.polytopes, 0, cause.size});
  }
  const double limit = std::min(wish, kReach * f);
  result.parts.back().part = last - density(limit);
  result.parts.front().part += density(limit) - density(wish);
  return result;
}

/// Caps of which one polytope is known only are booked on it and what it meets at the smallest angle.
template <int D>
class Partners {
 public:
  explicit Partners(const Incidence<D>& incidence, const Domain<D>& domain) : incidence_(incidence), domain_(domain) {}

  Key complete(const Key& key) {
    if (key[0] != key[1]) return {std::min(key[0], key[1]), std::max(key[0], key[1])};
    const auto [entry, is_new] = known_.try_emplace(key[0], key);
    if (is_new) entry->second = find(key[0]);
    return entry->second;
  }

 private:
  Key find(PolytopeId p) const {
    Key best = {p, p};
    double least = kSharpAngle;
    const auto consider = [&](PolytopeId q) {
      const std::optional<double> angle = incidence_.meeting_angle(p, q);
      if (!angle || !(*angle < least)) return;
      least = *angle;
      best = {std::min(p, q), std::max(p, q)};
    };
    for (const PointId x : points_of(p)) {
      for (const SegmentId s : incidence_.segments_at(x)) consider(PolytopeId(s));
      for (const FacetId f : incidence_.facets_at(x)) consider(PolytopeId(f));
    }
    return best;
  }

  [[nodiscard]] std::vector<PointId> points_of(PolytopeId p) const {
    if (p.dimension == 1) return {domain_.segments[SegmentId(p.index)][0], domain_.segments[SegmentId(p.index)][1]};
    if (p.dimension == 0 || p.dimension == D) return {};
    const auto row = domain_.facet_points[FacetId(p.index)];
    return {row.begin(), row.end()};
  }

  const Incidence<D>& incidence_;
  const Domain<D>& domain_;
  std::map<PolytopeId, Key> known_;
};

/// An empty account of a pair.
template <int D>
Account<D> open_account(const Incidence<D>& incidence, const Key& key) {
  using Kind = typename CostlyFeature<D>::Kind;
  Account<D> account;
  account.key = key;
  if (incidence.common_points(key[0], key[1]).empty()) return account;
  const std::optional<double> angle = incidence.meeting_angle(key[0], key[1]);
  account.kind = angle && *angle < kSharpAngle ? Kind::kAngle : Kind::kRepair;
  if (account.kind == Kind::kAngle) account.angle_deg = *angle * 180 / std::numbers::pi;
  return account;
}

/// Accounts of all pairs, the costliest first.
template <int D>
std::vector<Account<D>> add_up(const Domain<D>& domain, const Incidence<D>& incidence, const Spacing<D>& spacing,
                               const std::vector<CountedPoint<D>>& points) {
  std::vector<Parts> parts(points.size());
  parallel_for(
      points.size(), [&](std::size_t i) { parts[i] = split(spacing, points[i]); }, 16);
  std::map<Key, Account<D>> accounts;
  Partners<D> partners(incidence, domain);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const Part& part : parts[i].parts) {
      const Key key = partners.complete(part.key);
      auto found = accounts.find(key);
      if (found == accounts.end()) found = accounts.emplace(key, open_account(incidence, key)).first;
      Account<D>& account = found->second;
      const double count = part.part * points[i].count, weight = std::abs(count);
      account.count += count;
      account.weight += weight;
      account.moment += weight * points[i].position;
      if (account.least_f > 0 && account.least_f <= parts[i].f) continue;
      account.least_f = parts[i].f;
      account.size_there = part.size;
    }
  }
  std::vector<Account<D>> result;
  for (const auto& [key, account] : accounts)
    if (account.weight > 0) result.push_back(account);
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.count > b.count; });
  return result;
}

/// Accounts that count as one feature.
struct Group {
  std::vector<std::size_t> members;  // The costliest first.
  double count = 0;
};

/// Groups of accounts around the costliest that is left, as many as are reported: those of its kind join it that are
/// within `reach` times its f and whose f is like its own up to the factor `ratio`.
template <int D>
std::vector<Group> grouped(const std::vector<Account<D>>& accounts, double reach, double ratio) {
  std::vector<Group> groups;
  std::vector<char> is_taken(accounts.size());
  for (std::size_t lead = 0; lead < accounts.size() && groups.size() < kMaxFeatures; ++lead) {
    if (is_taken[lead] != 0) continue;
    const Account<D>& leader = accounts[lead];
    Group group;
    for (std::size_t i = lead; i < accounts.size(); ++i) {
      const Account<D>& other = accounts[i];
      const bool is_like = other.least_f <= ratio * leader.least_f && leader.least_f <= ratio * other.least_f;
      const bool is_near = distance(other.middle(), leader.middle()) <= reach * leader.least_f;
      if (i != lead && (is_taken[i] != 0 || other.kind != leader.kind || !is_like || !is_near)) continue;
      is_taken[i] = 1;
      group.members.push_back(i);
      group.count += other.count;
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

/// The least grouping whose groups make up kCoverage of all.
template <int D>
std::vector<Group> least_grouping(const std::vector<Account<D>>& accounts) {
  double total = 0;
  for (const Account<D>& account : accounts) total += account.count;
  std::vector<Group> groups = grouped(accounts, 0, 1);
  const auto covered = [&] {
    double sum = 0;
    for (const Group& group : groups) sum += group.count;
    return sum;
  };
  // In small steps, so that no more is joined than has to be.
  constexpr double kFirstReach = 1, kReachStep = 1.4, kFirstRatio = 1.2, kRatioStep = 1.15;
  for (double reach = kFirstReach, ratio = kFirstRatio; covered() < kCoverage * total && std::isfinite(reach);
       reach *= kReachStep, ratio *= kRatioStep)
    groups = grouped(accounts, reach, ratio);
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.count > b.count; });
  return groups;
}

template <int D>
CostlyFeature<D> feature_of(const Domain<D>& domain, const Incidence<D>& incidence,
                            const std::vector<Account<D>>& accounts, const Group& group) {
  const Account<D>& leader = accounts[group.members.front()];
  const auto [p, q] = leader.key;
  CostlyFeature<D> feature;
  feature.kind = leader.kind;
  feature.polytopes = leader.key;
  feature.vertices = group.count;
  feature.n_pairs = group.members.size();
  switch (leader.kind) {
    case CostlyFeature<D>::Kind::kGap: {
      const Gap<D> gap = nearest_gap(domain, p, q, leader.middle());
      feature.place = gap.middle;
      feature.size = gap.size;
      break;
    }
    case CostlyFeature<D>::Kind::kAngle:
      feature.place = nearest_common_point(domain, incidence, p, q, leader.middle());
      feature.angle_deg = leader.angle_deg;
      break;
    case CostlyFeature<D>::Kind::kRepair:
      feature.place = leader.middle();
      feature.size = 2 * leader.size_there;
      break;
  }
  for (const std::size_t i : group.members)
    feature.radius = std::max(feature.radius, distance(leader.middle(), accounts[i].middle()));
  return feature;
}

}  // namespace

template <int D>
std::vector<CostlyFeature<D>> attribute(const Domain<D>& domain, const Spacing<D>& spacing,
                                        std::vector<CountedPoint<D>> points) {
  const Incidence<D> incidence(domain);
  const std::vector<Account<D>> accounts = add_up(domain, incidence, spacing, thinned(std::move(points)));
  std::vector<CostlyFeature<D>> features;
  for (const Group& group : least_grouping(accounts))
    if (group.count >= kLeastCount) features.push_back(feature_of(domain, incidence, accounts, group));
  return features;
}

template <int D>
std::vector<CostlyFeature<D>> costliest_features(const Domain<D>& domain, const Spacing<D>& spacing,
                                                 const Packing<D>& packing) {
  std::vector<CountedPoint<D>> points;
  for (const SphereId s : ids(packing.center))
    points.push_back({packing.center[s], static_cast<int>(packing.carrier[s].dimension), 1});
  return attribute(domain, spacing, std::move(points));
}

#define VOROPACK_INSTANTIATE(D)                                                                                        \
  template std::vector<CostlyFeature<D>> attribute(const Domain<D>&, const Spacing<D>&, std::vector<CountedPoint<D>>); \
  template std::vector<CostlyFeature<D>> costliest_features(const Domain<D>&, const Spacing<D>&, const Packing<D>&);
VOROPACK_INSTANTIATE(2)
VOROPACK_INSTANTIATE(3)
#undef VOROPACK_INSTANTIATE

}  // namespace voropack
