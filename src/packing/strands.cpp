#include "packing/strands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "base/parallel.h"
#include "base/random.h"
#include "spheres/pack_interior.h"

namespace voropack {

namespace {

/// Of a strand that is tied at both ends, each tie gets this part if it wants it, and what the other one leaves.
constexpr double kShare = 0.45;
/// Room in f that a tie leaves to the far end of a strand that goes on alone.
constexpr double kLeftover = 2.5;
/// Kept centers of different strands at distances that differ by less than this, relative to f, are the same shell.
constexpr double kSameShell = 0.1;
/// A step of a tie is at most so long, in f.
constexpr double kNextShell = 5.5;
/// Strands whose lengths differ by less than this part of them end at the same distance.
constexpr double kSameLength = 1e-9;

}  // namespace

template <int D>
class StrandPacker<D>::Round {
 public:
  Round(StrandPacker& packer, const std::vector<Strand<D>>& strands, const Spacing<D>& spacing)
      : strands_(strands), spacing_(spacing), jitter_(packer.jitter_), seed_(packer.seed_), ends_(packer.ends_) {}

  void find_wanted(const Tie& tie) {
    const std::vector<double> reach = wanted_reach(tie);
    for (std::size_t m = 0; m < reach.size(); ++m) own(tie.ends[m]).wanted = reach[m];
  }

  void find_shells(const Tie& tie) {
    for (const StrandEnd& e : tie.ends) {
      own(e).shells.clear();
      own(e).is_full = false;
    }
    add_shells(tie);
  }

  [[nodiscard]] PackedStrand pack(std::uint32_t index) const {
    const Strand<D>& strand = strands_[index];
    std::array<std::vector<Shell>, 2> shells = {ends_[index][0].shells, ends_[index][1].shells};
    const bool is_full = ends_[index][0].is_full || ends_[index][1].is_full;
    const bool is_free = shells[0].empty() && shells[1].empty() && !is_full;
    if (is_free && strand.positions) return packed(index, given_places(strand), {});
    // Where two ties leave no room between them, the longer one gives way.
    const auto last = [](const std::vector<Shell>& s) { return s.empty() ? Shell{0, 0} : s.back(); };
    const std::array<double, 2> at_end = {spacing_(strand.at(0)), spacing_(strand.at(strand.length))};
    while (!shells[0].empty() || !shells[1].empty()) {
      const double room = strand.length - last(shells[0]).position - last(shells[1]).position;
      double needed = 0;
      for (std::size_t i = 0; i < 2; ++i) needed += shells[i].empty() ? at_end[i] : shells[i].back().radius;
      if (room >= needed || is_full) break;
      shells[last(shells[0]).position >= last(shells[1]).position ? 0 : 1].pop_back();
    }
    const double begin = last(shells[0]).position, end = strand.length - last(shells[1]).position;
    std::vector<Shell> places = shells[0];
    if (!is_full)
      for (const Shell& s : middle(index, shells, begin, end, {last(shells[0]).radius, last(shells[1]).radius}))
        places.push_back(s);
    for (auto s = shells[1].rbegin(); s != shells[1].rend(); ++s)
      places.push_back({strand.length - s->position, s->radius, s->kept});
    return packed(index, places, {begin, strand.length - end});
  }

 private:
  End& own(const StrandEnd& e) { return ends_[e.strand][e.is_far ? 1 : 0]; }
  [[nodiscard]] const End& own(const StrandEnd& e) const { return ends_[e.strand][e.is_far ? 1 : 0]; }
  /// Of the strand's other end.
  [[nodiscard]] const End& other(const StrandEnd& e) const { return ends_[e.strand][e.is_far ? 0 : 1]; }

  [[nodiscard]] Vec<D> at(const StrandEnd& e, double t) const {
    const Strand<D>& s = strands_[e.strand];
    return s.at(e.is_far ? s.length - t : t);
  }

  /// f as far as steps depend on it.
  [[nodiscard]] double half_step(std::uint32_t strand, const Vec<D>& x) const {
    return std::max(spacing_(x), 0.5 * strands_[strand].least_step);
  }

  [[nodiscard]] double length(const StrandEnd& e) const { return strands_[e.strand].length; }

  /// How far each strand is nearer to others of the tie than it may be alone: at most its length. There is room for a
  /// shell, or the strand is apart from the start.
  [[nodiscard]] std::vector<double> wanted_reach(const Tie& tie) const {
    constexpr double kLeastStep = 0.25, kFirstShell = 2.7;  // In f.
    double first = std::numeric_limits<double>::infinity();
    for (const StrandEnd& e : tie.ends) first = std::min(first, half_step(e.strand, at(e, 0)));
    std::vector<double> reach(tie.ends.size(), -1);
    for (double t = 0; std::ranges::count(reach, -1.0) > 0;) {
      double largest = 0, least = std::numeric_limits<double>::infinity(), step = least;
      for (std::size_t m = 0; m < reach.size(); ++m) {
        const StrandEnd& e = tie.ends[m];
        if (reach[m] < 0 && t >= length(e)) reach[m] = length(e);
        if (reach[m] >= 0) continue;
        const double f = spacing_(at(e, t));
        largest = std::max(largest, f);
        least = std::min(least, std::max(f, 0.5 * strands_[e.strand].least_step));
      }
      for (std::size_t m = 0; m < reach.size(); ++m) {
        if (reach[m] >= 0) continue;
        const double slope = std::sin(std::min(tie.ends[m].angle, std::numbers::pi / 2));
        // f grows by its Lipschitz constant at most: so long it is not apart.
        const double missing = kTieApart * largest - (tie.start + t) * slope;
        if (missing <= 0) reach[m] = t == 0 ? 0 : std::min(length(tie.ends[m]), std::max(t, kFirstShell * first));
        step = std::min({step, missing / (slope + kTieApart * spacing_.lipschitz()), length(tie.ends[m]) - t});
      }
      t += std::max(step, kLeastStep * least);
    }
    return reach;
  }

  /// How far a tie may reach along a strand of its own, of which the one at the other end wants a part.
  [[nodiscard]] static double allowed_reach(double length, double own, double other) {
    const double share = kShare * length;
    return own <= share ? own : std::max(share, length - other);
  }

  /// How far the strands of a tie carry common distances, by end of the tie.
  struct Reach {
    std::vector<double> own;   ///< From here on the strand is apart from all others: the next shell is its last one.
    std::vector<double> most;  ///< But none of its shells is beyond this; so far its f counts for the shells.
    double end = 0;            ///< Of the tie: two strands go on up to here.
  };

  /// f as far as steps depend on it, at distance t on the tied strand where it is least.
  [[nodiscard]] double least(const Tie& tie, const Reach& reach, double t) const {
    double f = std::numeric_limits<double>::infinity();
    for (std::size_t m = 0; m < tie.ends.size(); ++m)
      if (t <= reach.most[m]) f = std::min(f, half_step(tie.ends[m].strand, at(tie.ends[m], t)));
    return f;
  }

  /// A distance from a tie's common point where strands have kept centers.
  struct Break {
    double position;
    std::vector<int> kept;  ///< By end of the tie: index into Strand::kept, or -1.
  };

  [[nodiscard]] std::vector<Break> find_breaks(const Tie& tie, const Reach& reach) const {
    struct Kept {
      double position;
      std::size_t end;
      int index;
    };
    std::vector<Kept> all;
    for (std::size_t m = 0; m < tie.ends.size(); ++m) {
      const Strand<D>& strand = strands_[tie.ends[m].strand];
      for (std::size_t k = 0; k < strand.kept.size(); ++k)
        all.push_back({tie.ends[m].is_far ? strand.length - strand.kept[k] : strand.kept[k], m, static_cast<int>(k)});
    }
    std::ranges::sort(all, {}, [](const Kept& k) { return std::pair(k.position, k.end); });
    std::vector<Break> breaks;
    for (const Kept& k : all) {
      const bool is_same =
          !breaks.empty() && breaks.back().kept[k.end] < 0 &&
          k.position - breaks.back().position <= kSameShell * least(tie, reach, std::min(k.position, reach.end));
      if (!is_same) breaks.push_back({k.position, std::vector<int>(tie.ends.size(), -1)});
      breaks.back().kept[k.end] = k.index;
    }
    return breaks;
  }

  /// True if the strand is near to others up to its other end, where nothing ties it.
  [[nodiscard]] bool is_near_throughout(const StrandEnd& e) const {
    return other(e).wanted == 0 && own(e).wanted >= length(e);
  }

  [[nodiscard]] Reach find_reach(const Tie& tie) const {
    Reach reach;
    std::vector<double> allowed;
    for (const StrandEnd& e : tie.ends) {
      const double wanted = own(e).wanted, from_there = other(e).wanted;
      const double next =
          wanted == 0 ? 0 : std::min(length(e), wanted + kNextShell * half_step(e.strand, at(e, wanted)));
      reach.own.push_back(wanted);
      reach.most.push_back(from_there > 0 ? allowed_reach(length(e), next, from_there) : next);
      allowed.push_back(std::min(wanted, reach.most.back()));
    }
    std::ranges::sort(allowed, std::greater<>());
    reach.end = allowed[1];
    for (std::size_t m = 0; m < tie.ends.size(); ++m) {
      const StrandEnd& e = tie.ends[m];
      const bool is_last = other(e).wanted == 0 && !ends_at(e, reach.end);
      if (is_last)
        reach.most[m] =
            std::min(reach.most[m], length(e) - kLeftover * spacing_(at(e, std::min(reach.most[m], reach.end))));
    }
    double longest = 0;
    for (std::size_t m = 0; m < tie.ends.size(); ++m)
      longest = std::max(longest, std::min(reach.own[m], reach.most[m]));
    reach.end = std::min(reach.end, longest);
    return reach;
  }

  /// True if the strand is tied to others all along, up to `end`, where it ends.
  [[nodiscard]] bool ends_at(const StrandEnd& e, double end) const {
    return is_near_throughout(e) && std::abs(length(e) - end) <= kSameLength * length(e);
  }

  /// Where a tie ends that should end at `end`: at kept centers that are too near for that.
  [[nodiscard]] double fitted_end(const Tie& tie, const Reach& reach, const std::vector<Break>& breaks) const {
    const double f = least(tie, reach, reach.end);
    double shortest = std::numeric_limits<double>::infinity(), nearest = reach.end;
    for (std::size_t m = 0; m < tie.ends.size(); ++m)
      if (reach.most[m] >= reach.end) shortest = std::min(shortest, length(tie.ends[m]));
    for (const Break& b : breaks)
      if (b.position <= shortest - f && std::abs(b.position - reach.end) < 2 * f &&
          (nearest == reach.end || std::abs(b.position - reach.end) < std::abs(nearest - reach.end)))
        nearest = b.position;
    return nearest;
  }

  /// Common distances up to the end: those of kept centers, and equal steps of the measure ds / f between them.
  [[nodiscard]] std::vector<Break> common_distances(const Tie& tie, const Reach& reach,
                                                    const std::vector<Break>& breaks) const {
    std::vector<Break> result;
    const std::vector<int> none(tie.ends.size(), -1);
    double from = 0;
    const auto step_to = [&](double to) {
      const LocalSpacing<1> along{[&](const Vec<1>& x) { return least(tie, reach, std::min(from + x[0], reach.end)); },
                                  {},
                                  spacing_.lipschitz()};
      for (const double t : equidistribute(to - from, along)) result.push_back({from + t, none});
    };
    for (const Break& b : breaks) {
      if (b.position > reach.end) break;
      step_to(b.position);
      result.push_back(b);
      from = b.position;
    }
    if (from < reach.end) step_to(reach.end);
    if (reach.end - from >= least(tie, reach, from) + least(tie, reach, reach.end)) result.push_back({reach.end, none});
    return result;
  }

  /// The first center of the end's strand that is kept and beyond t.
  [[nodiscard]] double next_kept(const StrandEnd& e, double t) const {
    double next = std::numeric_limits<double>::infinity();
    for (const double own : strands_[e.strand].kept) {
      const double position = e.is_far ? length(e) - own : own;
      if (position > t) next = std::min(next, position);
    }
    return next;
  }

  void add_shells(const Tie& tie) {
    Reach reach = find_reach(tie);
    if (!(reach.end > 0)) return;
    const std::vector<Break> breaks = find_breaks(tie, reach);
    const bool any_ends = std::ranges::any_of(tie.ends, [&](const StrandEnd& e) { return ends_at(e, reach.end); });
    if (!any_ends) reach.end = fitted_end(tie, reach, breaks);
    const std::vector<Break> common = common_distances(tie, reach, breaks);
    for (std::size_t m = 0; m < tie.ends.size(); ++m) {
      const StrandEnd& e = tie.ends[m];
      const bool ends_here = ends_at(e, reach.end);
      if (ends_here) own(e).is_full = true;
      const double beyond = next_kept(e, std::min(reach.most[m], reach.end));
      for (std::size_t k = 0; k < common.size(); ++k) {
        const double t = common[k].position;
        const bool has_left = (k == 0 ? 0 : common[k - 1].position) >= reach.own[m];
        if (has_left || t > reach.most[m] || (ends_here && t == reach.end)) break;
        const double f = least(tie, reach, t);
        const int kept = common[k].kept[m];
        if (kept >= 0) {
          const double own = strands_[e.strand].kept[static_cast<std::size_t>(kept)];
          add_shell(e, {e.is_far ? length(e) - own : own, f, kept});
        } else if (beyond - t >= 2 * f) {
          add_shell(e, wobbled(tie, e, k, t, f));
        }
      }
    }
  }

  void add_shell(const StrandEnd& e, const Shell& shell) { own(e).shells.push_back(shell); }

  /// Two equal distances t leave room for moves of t^2 (1 - cos angle) / f.
  [[nodiscard]] Shell wobbled(const Tie& tie, const StrandEnd& e, std::size_t k, double t, double f) const {
    const double t_over_f = (tie.start + t) / f;
    const double wobble = jitter_ * std::min(1.0, (1 - std::cos(tie.angle)) * t_over_f * t_over_f);
    const double noise = 2 * to_unit(hash_words(seed_, e.strand, e.is_far, k)) - 1;
    return {t + wobble * f * noise, f * (1 - 2 * wobble)};
  }

  [[nodiscard]] std::vector<Shell> given_places(const Strand<D>& strand) const {
    std::vector<Shell> places;
    for (const double t : strand.positions()) places.push_back({t, -1});
    for (std::size_t k = 0; k < strand.kept.size(); ++k) places.push_back({strand.kept[k], -1, static_cast<int>(k)});
    std::ranges::sort(places, {}, &Shell::position);
    return places;
  }

  /// The kept centers of a strand between its shells, and new ones. `tied`: the radii of the last tied spheres, or 0.
  [[nodiscard]] std::vector<Shell> middle(std::uint32_t index, const std::array<std::vector<Shell>, 2>& shells,
                                          double begin, double end, std::array<double, 2> tied) const {
    const Strand<D>& strand = strands_[index];
    std::vector<std::uint8_t> is_placed(strand.kept.size(), 0);
    for (const auto& side : shells)
      for (const Shell& s : side)
        if (s.kept >= 0) is_placed[static_cast<std::size_t>(s.kept)] = 1;
    std::vector<Shell> places;
    for (std::size_t k = 0; k < strand.kept.size(); ++k) {
      if (is_placed[k] != 0) continue;
      add_steps(index, begin, strand.kept[k], {tied[0], 0}, places);
      tied[0] = 0;
      places.push_back({strand.kept[k], -1, static_cast<int>(k)});
      begin = strand.kept[k];
    }
    add_steps(index, begin, end, tied, places);
    return places;
  }

  /// Equal steps in the measure ds / f, where f does not grow faster from tied spheres at the ends than it may
  /// anywhere: their radii are those of other strands.
  void add_steps(std::uint32_t index, double begin, double end, std::array<double, 2> tied,
                 std::vector<Shell>& places) const {
    const Strand<D>& strand = strands_[index];
    const double b = spacing_.lipschitz();
    const auto half = [&](const Vec<1>& x) {
      double f = half_step(index, strand.at(begin + x[0]));
      if (tied[0] > 0) f = std::min(f, std::max(tied[0] + b * x[0], 0.5 * strand.least_step));
      if (tied[1] > 0) f = std::min(f, std::max(tied[1] + b * (end - begin - x[0]), 0.5 * strand.least_step));
      return f;
    };
    const LocalSpacing<1> along{half, {}, b};
    std::vector<double> positions = equidistribute(end - begin, along);
    const double least_parts = std::ceil((end - begin) / strand.longest_step - 1e-9);
    if (static_cast<double>(positions.size() + 1) < least_parts) {
      positions.clear();
      for (double i = 1; i < least_parts; ++i) positions.push_back((end - begin) * i / least_parts);
    }
    for (double t : positions) {
      t += begin;
      if (strand.jitter > 0)
        t += strand.jitter * spacing_(strand.at(t)) * (2 * to_unit(hash_words(seed_, index, places.size())) - 1);
      places.push_back({t, -1});
    }
  }

  [[nodiscard]] PackedStrand packed(std::uint32_t index, const std::vector<Shell>& places,
                                    std::array<double, 2> tied) const {
    PackedStrand result;
    for (const Shell& s : places) {
      result.position.push_back(s.position);
      result.radius.push_back(s.radius < 0 ? spacing_(strands_[index].at(s.position)) : s.radius);
      result.kept.push_back(s.kept);
    }
    result.tied_begin = tied[0];
    result.tied_end = tied[1];
    return result;
  }

  const std::vector<Strand<D>>& strands_;
  const Spacing<D>& spacing_;
  double jitter_;
  std::uint64_t seed_;
  std::vector<std::array<End, 2>>& ends_;
};

template <int D>
void StrandPacker<D>::pack(const std::vector<Strand<D>>& strands, const std::vector<Tie>& ties,
                           const Spacing<D>& spacing, std::vector<std::uint8_t>& is_new) {
  ends_.resize(strands.size());
  packed_.resize(strands.size());
  const auto any_new = [&](const Tie& tie, const std::vector<std::uint8_t>& which) {
    return std::ranges::any_of(tie.ends, [&](const StrandEnd& e) { return which[e.strand] != 0; });
  };
  // An end of a strand is in one tie at most.
  std::vector<std::uint8_t> has_changed(ties.size());
  for (std::size_t i = 0; i < ties.size(); ++i) {
    const StrandEnd& first = ties[i].ends.front();
    const int before = ends_[first.strand][first.is_far ? 1 : 0].tie;
    has_changed[i] = before < 0 || any_new(ties[i], is_new) || !(ties[i] == ties_[static_cast<std::size_t>(before)]);
  }
  Round round(*this, strands, spacing);
  const auto for_each_changed = [&](const auto& change) {
    parallel_for(
        ties.size(),
        [&](std::size_t i) {
          if (has_changed[i] != 0) change(ties[i]);
        },
        1);
    for (std::size_t i = 0; i < ties.size(); ++i)
      if (has_changed[i] != 0)
        for (const StrandEnd& e : ties[i].ends) is_new[e.strand] = 1;
  };
  for_each_changed([&](const Tie& tie) { round.find_wanted(tie); });
  // What a tie wants of a strand is of interest to the tie at the strand's other end.
  for (std::size_t i = 0; i < ties.size(); ++i) has_changed[i] = any_new(ties[i], is_new);
  for_each_changed([&](const Tie& tie) { round.find_shells(tie); });
  parallel_for(
      strands.size(),
      [&](std::size_t i) {
        if (is_new[i] != 0) packed_[i] = round.pack(static_cast<std::uint32_t>(i));
      },
      1);
  ties_ = ties;
  for (std::size_t i = 0; i < ties.size(); ++i)
    for (const StrandEnd& e : ties[i].ends) ends_[e.strand][e.is_far ? 1 : 0].tie = static_cast<int>(i);
}

template <int D>
std::vector<PackedStrand> pack_strands(const std::vector<Strand<D>>& strands, const std::vector<Tie>& ties,
                                       const Spacing<D>& spacing, double jitter, std::uint64_t seed) {
  StrandPacker<D> packer(jitter, seed);
  std::vector<std::uint8_t> is_new(strands.size(), 1);
  packer.pack(strands, ties, spacing, is_new);
  return packer.packed();
}

template class StrandPacker<2>;
template class StrandPacker<3>;
template std::vector<PackedStrand> pack_strands(const std::vector<Strand<2>>&, const std::vector<Tie>&,
                                                const Spacing<2>&, double, std::uint64_t);
template std::vector<PackedStrand> pack_strands(const std::vector<Strand<3>>&, const std::vector<Tie>&,
                                                const Spacing<3>&, double, std::uint64_t);

}  // namespace voropack
