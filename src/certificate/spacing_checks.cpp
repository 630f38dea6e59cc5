// Checks `packing` and `spacing_lipschitz`: the spheres at the vertices do not overlap, their radii vary slowly.
#include <algorithm>

#include "base/parallel.h"
#include "base/random.h"
#include "certificate/checks.h"
#include "geom/tolerance.h"

namespace voropack::judge {

namespace {

enum PackingFault : int { kSpheresOverlap = 1, kBadSpacing };

/// Pairs that are farther apart than this many times the sum of their radii are not looked at.
constexpr double kNearPair = 1.05;

/// Two vertices this near, relative to the diagonal of the box, are one point given twice.
constexpr double kSamePlace = 1e-12;

/// A mesh whose spheres all overlap must not cost n^2: a leaf gives up after so many pairs, once it has a violation.
constexpr std::uint64_t kPairBudget = 100'000;

struct PairTallies {
  Tally packing;
  Tally duplicates;
  PairTallies& operator+=(const PairTallies& other) {
    packing += other.packing;
    duplicates += other.duplicates;
    return *this;
  }
};

/// All pairs of a vertex in `leaf` and one after it in the tree's order.
template <int D>
PairTallies test_leaf(const Subject<D>& subject, std::size_t leaf) {
  const VertexTree<D>& vertices = subject.vertices;
  const BoxTree<D>& tree = vertices.tree;
  const std::size_t begin = tree.leaf_begin(leaf);
  const std::size_t end = tree.leaf_begin(leaf + 1);
  const Box<D>& box = tree.leaf_box(leaf);
  const double weight = tree.leaf_weight(leaf);
  const double same = kSamePlace * subject.topology.box().diagonal();
  PairTallies result;
  std::uint64_t n_pairs = 0;
  double best_ratio_sq = kNearPair * kNearPair;
  if (subject.has_spacing) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t v = vertices.id[i];
      if (vertices.spacing[i] > 0)
        ++result.packing.tested;
      else
        result.packing.violation(kBadSpacing, kNoFigure, v, v);
    }
  }
  const Box<D>* entered = nullptr;  // The last node of the tree that was of interest; `pairs` gets its items.
  double entered_weight = 0;
  const auto enter = [&](const Box<D>& other, double other_weight) {
    entered = &other;
    entered_weight = other_weight;
    if (n_pairs > kPairBudget && result.packing.violations + result.duplicates.violations > 0) return false;
    const double reach = std::max(kNearPair * (weight + other_weight), same);
    return distance_sq(box, other) <= reach * reach;
  };
  const auto pairs = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = begin; i < end; ++i) {
      // As `enter`, for one vertex of the leaf.
      const double reach = std::max(kNearPair * (vertices.spacing[i] + entered_weight), same);
      if (entered->distance_sq(vertices.point[i]) > reach * reach) {
        n_pairs += last - std::min(last, std::max(first, i + 1));
        continue;
      }
      for (std::size_t j = std::max(first, i + 1); j < last; ++j) {
        ++n_pairs;
        const double gap_sq = distance_sq(vertices.point[i], vertices.point[j]);
        if (gap_sq <= same * same && subject.topology.used(vertices.id[i]) && subject.topology.used(vertices.id[j]))
          result.duplicates.fault(1, -gap_sq, vertices.id[i], vertices.id[j]);
        const double sum = vertices.spacing[i] + vertices.spacing[j];
        if (!(gap_sq < best_ratio_sq * sum * sum) && !(gap_sq < sum * sum)) continue;
        const double ratio = std::sqrt(gap_sq) / sum;
        if (ratio < 1 - kPackingCheckSlack && subject.sharp.carrier_angle(vertices.id[i], vertices.id[j])) {
          ++result.packing.excepted;
          continue;
        }
        best_ratio_sq = std::min(best_ratio_sq, ratio * ratio);
        const Finding finding{.kind = ratio < 1 - kPackingCheckSlack ? kSpheresOverlap : 0,
                              .figure = -ratio,
                              .ids = {vertices.id[i], vertices.id[j], 0},
                              .present = true};
        if (finding.kind > 0) ++result.packing.violations;
        result.packing.note(finding);
      }
    }
  };
  tree.visit(enter, pairs, leaf);
  return result;
}

template <int D>
std::string describe_packing(const Subject<D>& subject, const Tally& tally) {
  const Finding& worst = tally.worst;
  if (tally.tested == 0) return {};
  if (!worst.present) return "no two spheres are near to touching";
  if (worst.kind == kBadSpacing)
    return "the spacing of " + subject.vertex_text(worst.ids[0]) + " is not positive and finite";
  const std::string pair = subject.vertex_text(worst.ids[0]) + " and " + subject.vertex_text(worst.ids[1]);
  std::string text = (worst.kind == kSpheresOverlap ? "overlap: " : "nearest to overlap: ") + pair;
  if (tally.excepted > 0)
    text += "; excepted: " + std::to_string(tally.excepted) + " pairs, each on two polytopes of one sharp feature";
  return text;
}

/// Slope of f between two vertices, squared, as a fraction that needs no division to compare.
struct Slope {
  double rise_sq = 0;
  double run_sq = 1;
  std::array<std::uint32_t, 2> ids{};

  void take(const Slope& s) {
    if (s.rise_sq * run_sq > rise_sq * s.run_sq) *this = s;
  }
};

struct SlopeTally {
  Slope steepest;
  std::uint64_t tested = 0;
  std::uint64_t violations = 0;
};

template <int D>
void test_slope(const Subject<D>& subject, std::uint32_t v, std::uint32_t w, SlopeTally& tally) {
  const double f = subject.spacing(v);
  const double g = subject.spacing(w);
  const double rise = f - g;
  ++tally.tested;
  if (rise == 0) return;  // Neither steeper than anything nor steeper than allowed.
  const Slope slope{rise * rise, distance_sq(subject.point(v), subject.point(w)), {v, w}};
  tally.steepest.take(slope);
  if (!subject.options.gradation) return;
  const double b = *subject.options.gradation;
  if (slope.rise_sq <= b * b * slope.run_sq) return;
  // Slack for the rounding of f itself and of the distance.
  const double allowed = (1 + 1e-9) * b * std::sqrt(slope.run_sq) + 1e-12 * (f + g);
  if (!(std::abs(rise) <= allowed)) ++tally.violations;
}

}  // namespace

template <int D>
Check check_packing(const Subject<D>& subject, Duplicates& duplicates) {
  const PairTallies tallies = parallel_reduce_ordered(
      subject.vertices.tree.n_leaves(), 64, PairTallies{},
      [&](std::size_t begin, std::size_t end) {
        subject.observer.check_cancelled();
        PairTallies block;
        for (std::size_t leaf = begin; leaf < end; ++leaf) block += test_leaf(subject, leaf);
        return block;
      },
      [](PairTallies a, const PairTallies& b) { return a += b; });
  duplicates.tally = tallies.duplicates;
  Tally tally = tallies.packing;
  if (!subject.has_spacing) tally = {};
  return make_check("packing", tally, describe_packing(subject, tally), -1);
}

template <int D>
Check check_spacing_lipschitz(const Subject<D>& subject, double& measured) {
  measured = 0;
  if (!subject.has_spacing) return make_check("spacing_lipschitz", {}, {});
  const std::size_t n_simplices = subject.mesh.simplex_vertices.size();
  const std::size_t n_vertices = subject.mesh.points.size();
  const auto combine = [](SlopeTally a, const SlopeTally& b) {
    a.steepest.take(b.steepest);
    a.tested += b.tested;
    a.violations += b.violations;
    return a;
  };
  SlopeTally total = parallel_reduce_ordered(
      n_simplices, kBlock, SlopeTally{},
      [&](std::size_t begin, std::size_t end) {
        subject.observer.check_cancelled();
        SlopeTally block;
        for (std::size_t s = begin; s < end; ++s) {
          if (!subject.topology.valid(s)) continue;
          const auto& v = subject.mesh.simplex_vertices[SimplexId(s)];
          for (std::size_t i = 0; i < D; ++i)
            for (std::size_t j = i + 1; j <= D; ++j) test_slope(subject, v[i].value(), v[j].value(), block);
        }
        return block;
      },
      combine);
  const std::size_t n_pairs = n_vertices < 2 ? 0 : std::min<std::size_t>(100'000, 10 * n_vertices);
  for (std::size_t k = 0; k < n_pairs; ++k) {
    const auto v = static_cast<std::uint32_t>(hash_words(k, 1U) % n_vertices);
    const auto w = static_cast<std::uint32_t>(hash_words(k, 2U) % n_vertices);
    if (v != w && subject.topology.finite(v) && subject.topology.finite(w)) test_slope(subject, v, w, total);
  }
  const Slope& steepest = total.steepest;
  measured = std::sqrt(steepest.rise_sq / steepest.run_sq);
  Tally tally;
  tally.tested = total.tested;
  tally.violations = total.violations;
  // Nothing was claimed, but with b >= 1 spheres may swallow each other and no lemma holds.
  if (!subject.options.gradation && !(measured < 1)) tally.violations = 1;
  if (tally.tested > 0) tally.note({.kind = 0, .figure = measured, .present = true});
  std::string where;
  if (tally.tested > 0 && steepest.ids[0] == steepest.ids[1])
    where = "the spacing is the same everywhere";
  else if (tally.tested > 0)
    where = "steepest: " + subject.vertex_text(steepest.ids[0]) + " and " + subject.vertex_text(steepest.ids[1]);
  return make_check("spacing_lipschitz", tally, where);
}

template Check check_packing(const Subject<2>&, Duplicates&);
template Check check_packing(const Subject<3>&, Duplicates&);
template Check check_spacing_lipschitz(const Subject<2>&, double&);
template Check check_spacing_lipschitz(const Subject<3>&, double&);

}  // namespace voropack::judge
