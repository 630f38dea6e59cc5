#include "packing/segments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/box_tree.h"
#include "geom/distance.h"
#include "geom/polytope_distance.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

/// Centers of a segment that were cocircular by symmetry with others move by this much, relative to f.
constexpr double kSegmentJitter = 1e-4;
/// Far more than rounding does to values of f.
constexpr double kRounding = 1e-12;

template <int D>
LocalSpacing<1> spacing_along(const Spacing<D>& spacing, const Vec<D>& a, const Vec<D>& direction) {
  return {[&spacing, a, direction](const Vec<1>& t) { return spacing(a + t[0] * direction); },
          [&spacing, a, direction](const Box<1>& box) {
            Box<D> space;
            space.add(a + box.lo[0] * direction);
            space.add(a + box.hi[0] * direction);
            return spacing.constant_on(space);
          },
          spacing.lipschitz()};
}

/// Arc lengths of the new centers inside an untied segment of the random forms, ascending.
template <int D>
std::vector<double> pack_segment(const Domain<D>& domain, SegmentId segment,
                                 std::span<const typename KeptCenters<D>::OnSegment> kept, const Spacing<D>& spacing,
                                 const PackingOptions& options, const Observer& observer) {
  const Vec<D> a = domain.points[domain.segments[segment][0]], b = domain.points[domain.segments[segment][1]];
  const double length = distance(a, b);
  const LocalSpacing<1> along = spacing_along(spacing, a, (b - a) / length);
  PackingProblem<1> problem;
  problem.bounds = Box<1>({0.0}, {length});
  problem.fixed = {{{0.0}, along.at({0.0})}, {{length}, along.at({length})}};
  for (const auto& k : kept) problem.fixed.push_back({{k.position}, along.at({k.position})});
  problem.spacing = along;
  problem.form = options.form;
  problem.epsilon = options.epsilon;
  problem.seed = hash_words(options.seed, 1, segment.value());
  std::vector<double> positions;
  for (const Ball<1>& s : pack_interior(problem, false, observer).spheres) positions.push_back(s.center[0]);
  std::sort(positions.begin(), positions.end());
  return positions;
}

/// Exact in every coordinate that both ends share.
template <int D>
Vec<D> point_between(const Vec<D>& a, const Vec<D>& b, double t) {
  Vec<D> x;
  for (int k = 0; k < D; ++k) x[k] = a[k] == b[k] ? a[k] : (1 - t) * a[k] + t * b[k];
  return x;
}

/// What protection ties at the ends of segments.
template <int D>
std::vector<Tie> segment_ties(const Protection<D>& protection) {
  std::vector<Tie> ties;
  for (const auto& [p, groups] : protection.fans.all())
    for (const auto& segments : groups) {
      Tie tie{{}, protection.least_angle(p, segments), protection.corner_radius(p)};
      for (const SegmentId s : segments) {
        double angle = std::numbers::pi;
        for (const SegmentId t : segments)
          if (t != s)
            angle = std::min(angle,
                             angle_between(protection.incidence.direction(s, p), protection.incidence.direction(t, p)));
        tie.ends.push_back({s.value(), protection.domain().segments[s][1] == p, angle});
      }
      ties.push_back(std::move(tie));
    }
  return ties;
}

/// Whether caps make f smaller somewhere on a segment.
template <int D>
class LoweredPlaces {
 public:
  /// f is at most `most` wherever it is asked for.
  LoweredPlaces(std::span<const SpacingCap<D>> caps, double lipschitz, double most)
      : caps_(caps), lipschitz_(lipschitz) {
    std::vector<Box<D>> boxes;
    for (const SpacingCap<D>& cap : caps) {
      Box<D> box(cap.center, cap.center);
      box.inflate((cap.radius + std::max(0.0, most - cap.value) / lipschitz) * (1 + kRounding));
      boxes.push_back(box);
    }
    reach_ = BoxTree<D>(boxes);
  }

  /// On the segment f has been at most `most`. May be true where it was smaller than that.
  [[nodiscard]] bool meet(const Vec<D>& a, const Vec<D>& b, double most) const {
    Box<D> box(a, a);
    box.add(b);
    return reach_.find([&](const Box<D>& reach) { return reach.overlaps(box); },
                       [&](std::uint32_t i) {
                         const SpacingCap<D>& cap = caps_[i];
                         const double beyond = std::max(0.0, distance_to_segment(cap.center, a, b) - cap.radius);
                         return cap.value + lipschitz_ * beyond < most * (1 + kRounding);
                       });
  }

 private:
  std::span<const SpacingCap<D>> caps_;
  double lipschitz_;
  BoxTree<D> reach_;
};

}  // namespace

template <int D>
void SegmentPacker<D>::pack(const Protection<D>& protection, const Spacing<D>& spacing,
                            std::span<const SpacingCap<D>> lowered) {
  const Domain<D>& domain = protection.domain();
  find_new(protection, spacing.lipschitz(), lowered);
  update_points(domain, spacing);
  for (const SegmentId s : ids(domain.segments))
    if (is_new(s)) chains_[s.value()].kept = choose_kept(protection, spacing, s);
  strands_.pack(strands(protection, spacing), segment_ties(protection), spacing, is_new_);
  parallel_for(chains_.size(), [&](std::size_t i) {
    const SegmentId s(i);
    if (!is_new(s)) return;
    const auto [a, b] = domain.segments[s];
    Chain& chain = chains_[i];
    chain.most = 0.5 * (f_at(a) + f_at(b) + spacing.lipschitz() * distance(domain.points[a], domain.points[b]));
    chain.centers = place(domain, spacing, s);
  });
}

template <int D>
void SegmentPacker<D>::find_new(const Protection<D>& protection, double lipschitz,
                                std::span<const SpacingCap<D>> lowered) {
  const Domain<D>& domain = protection.domain();
  double most = 0;
  for (const Chain& chain : chains_) most = std::max(most, chain.most);
  const LoweredPlaces<D> places(lowered, lipschitz, most);
  is_new_ = std::move(is_doubtful_);
  is_new_.resize(domain.segments.size(), 1);
  is_doubtful_.assign(domain.segments.size(), 0);
  const std::size_t n_before = chains_.size();
  chains_.resize(domain.segments.size());
  parallel_for(chains_.size(), [&](std::size_t i) {
    const SegmentId s(i);
    const auto [a, b] = domain.segments[s];
    Chain& chain = chains_[i];
    const std::array<double, 2> rim = {protection.corner_radius(a), protection.corner_radius(b)};
    const bool is_shaken = protection.shaken.contains(s);
    if (i < n_before && rim == chain.rim && is_shaken == chain.is_shaken &&
        !places.meet(domain.points[a], domain.points[b], chain.most))
      return;
    chain.rim = rim;
    chain.is_shaken = is_shaken;
    is_new_[i] = 1;
  });
}

template <int D>
void SegmentPacker<D>::update_points(const Domain<D>& domain, const Spacing<D>& spacing) {
  constexpr double kUnknown = -1;
  f_at_point_.resize(domain.points.size(), kUnknown);
  std::vector<std::uint8_t> has_segment(domain.points.size());
  for (const SegmentId s : ids(domain.segments))
    for (const PointId p : domain.segments[s]) {
      has_segment[p.value()] = 1;
      if (is_new(s)) f_at_point_[p.value()] = kUnknown;
    }
  parallel_for(f_at_point_.size(), [&](std::size_t i) {
    if (has_segment[i] == 0 || f_at_point_[i] == kUnknown) f_at_point_[i] = spacing(domain.points[PointId(i)]);
  });
}

/// Those that fit, where not all have to stay: along each segment what leaves room for the one before and the end.
template <int D>
auto SegmentPacker<D>::choose_kept(const Protection<D>& protection, const Spacing<D>& spacing, SegmentId s) const
    -> std::vector<KeptCenter> {
  const std::span<const KeptCenter> all = protection.kept.on_segment(s);
  std::vector<KeptCenter> chosen(all.begin(), all.end());
  if (chosen.empty() || protection.kept.all_stay()) return chosen;
  const auto [a, b] = protection.domain().segments[s];
  const double length = distance(protection.domain().points[a], protection.domain().points[b]), last = f_at(b);
  double begin = 0, radius = f_at(a);
  std::erase_if(chosen, [&](const KeptCenter& k) {
    const double f = spacing(k.center);
    const bool fits = k.position - begin >= (radius + f) * (1 - kPackingSlack) &&
                      length - k.position >= (f + last) * (1 - kPackingSlack);
    if (fits) begin = k.position, radius = f;
    return !fits;
  });
  return chosen;
}

/// The segments between the corners at their ends.
template <int D>
std::vector<Strand<D>> SegmentPacker<D>::strands(const Protection<D>& protection, const Spacing<D>& spacing) const {
  const Domain<D>& domain = protection.domain();
  std::vector<Strand<D>> strands;
  for (const SegmentId s : ids(domain.segments)) {
    const Chain& chain = chains_[s.value()];
    const auto [a, b] = domain.segments[s];
    const Vec<D> start = domain.points[a], end = domain.points[b];
    const double length = distance(start, end), first = chain.rim[0];
    Strand<D> strand;
    strand.length = length - first - chain.rim[1];
    strand.at = [=](double t) { return point_between(start, end, (first + t) / length); };
    if (chain.is_shaken) strand.jitter = kSegmentJitter;
    for (const KeptCenter& k : chain.kept) strand.kept.push_back(k.position - first);
    if (options_.form != PackingForm::kVoronoi && chain.rim == std::array{0.0, 0.0})
      strand.positions = [&, s] {
        return pack_segment<D>(domain, s, chains_[s.value()].kept, spacing, options_, observer_);
      };
    strands.push_back(std::move(strand));
  }
  return strands;
}

template <int D>
auto SegmentPacker<D>::place(const Domain<D>& domain, const Spacing<D>& spacing, SegmentId s) const
    -> std::vector<Center> {
  const auto [a, b] = domain.segments[s];
  const Vec<D> start = domain.points[a], end = domain.points[b];
  const double length = distance(start, end);
  const Chain& chain = chains_[s.value()];
  const PackedStrand& strand = strands_.packed()[s.value()];
  std::vector<Center> centers;
  const auto append = [&](const Vec<D>& x, double radius) {
    const double f = spacing(x);
    centers.push_back({x, std::min(radius, f), f});
  };
  const auto append_at = [&](double t, double radius) { append(point_between(start, end, t / length), radius); };
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  if (chain.rim[0] > 0) append_at(chain.rim[0], kUnlimited);
  for (std::size_t k = 0; k < strand.position.size(); ++k) {
    if (strand.kept[k] >= 0)
      append(chain.kept[static_cast<std::size_t>(strand.kept[k])].center, strand.radius[k]);
    else
      append_at(chain.rim[0] + strand.position[k], strand.radius[k]);
  }
  if (chain.rim[1] > 0) append_at(length - chain.rim[1], kUnlimited);
  return centers;
}

template class SegmentPacker<2>;
template class SegmentPacker<3>;

}  // namespace voropack
