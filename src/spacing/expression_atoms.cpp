// Sampling of a size formula.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "base/parallel.h"
#include "spacing/wishes.h"
#include "voropack/expression.h"

namespace voropack {

namespace {

/// A cell is fine enough when the largest value sampled in it exceeds the least by no more than this part, or when the
/// Lipschitz condition alone lets f vary by no more across it.
constexpr double kOscillation = 0.1;
/// Every cell is halved this often at first, so that a narrow dip is not overlooked.
constexpr int kFirstLevels = 4;
/// Halvings along each axis at most, and cells in all: bounds time and memory for formulas that jump.
constexpr int kLastLevel = 12;
constexpr std::size_t kMaxCells = 60'000;

template <int D>
struct Cell {
  Box<D> box;
  double least = std::numeric_limits<double>::infinity();
  double largest = 0;
  bool is_outside = false;               // Does not meet the domain.
  std::optional<Vec<D>> bad_point = {};  // The first in the domain where the value is no size.
};

template <int D>
class Sampler {
 public:
  Sampler(const std::string& text, const Expression& formula, double edge_per_spacing, const RegionLocator<D>& locator)
      : text_(text), formula_(formula), edge_per_spacing_(edge_per_spacing), locator_(locator) {}

  /// Evaluates on the 3^D grid of corners, midpoints and center.
  void sample(Cell<D>& cell) const {
    const Vec<D> center = cell.box.center();
    if (!locator_.meets_any_wall(center, 0.5 * cell.box.diagonal()) && !locator_.in_domain(center)) {
      cell.is_outside = true;
      return;
    }
    int n = 1;
    for (int k = 0; k < D; ++k) n *= 3;
    for (int i = 0; i < n; ++i) {
      Vec<D> x;
      for (int k = 0, rest = i; k < D; ++k, rest /= 3) {
        const int step = rest % 3;
        x[k] = step == 0 ? cell.box.lo[k] : step == 1 ? center[k] : cell.box.hi[k];
      }
      const double value = formula_(x.coord) / edge_per_spacing_;
      if (std::isfinite(value) && value > 0) {
        cell.least = std::min(cell.least, value);
        cell.largest = std::max(cell.largest, value);
      } else if (!cell.bad_point && locator_.in_domain(x)) {
        cell.bad_point = x;
      }
    }
  }

  /// Not from the parallel loop, so that it is always the same point that is refused.
  [[noreturn]] void refuse(const Vec<D>& x) const {
    const double value = formula_(x.coord);
    const std::string place =
        D == 2 ? fmt::format("({}, {})", x[0], x[1]) : fmt::format("({}, {}, {})", x[0], x[1], x[D - 1]);
    throw OptionError(Fault{.id = "spacing.expression",
                            .message = fmt::format("the size formula '{}' is {} at {}", text_, value, place),
                            .fix = "make it positive throughout the domain, for example with max(0.01, ...)",
                            .position = {x.coord.begin(), x.coord.end()}});
  }

 private:
  const std::string& text_;
  const Expression& formula_;
  double edge_per_spacing_;
  const RegionLocator<D>& locator_;
};

template <int D>
void split(const Cell<D>& cell, std::vector<Cell<D>>& out) {
  const Vec<D> center = cell.box.center();
  for (unsigned child = 0; child < (1U << D); ++child) {
    Cell<D> c;
    c.box = cell.box;
    for (int k = 0; k < D; ++k) ((child >> k & 1U) != 0 ? c.box.lo[k] : c.box.hi[k]) = center[k];
    out.push_back(c);
  }
}

/// The largest distance from a point of `from` to the box `to`: attained at a corner, since it is convex.
template <int D>
double largest_distance(const Box<D>& from, const Box<D>& to) {
  double sum = 0;
  for (int k = 0; k < D; ++k) {
    const double d = std::max({to.lo[k] - from.lo[k], 0.0, from.hi[k] - to.hi[k]});
    sum += d * d;
  }
  return std::sqrt(sum);
}

/// Leaves out cells that another makes useless: least_j + slope * d(y, box_j) <= least_i for all y in box_i.
template <int D>
void add_undominated(const std::vector<Cell<D>>& cells, SizeAtoms<D>& atoms) {
  std::vector<Box<D>> boxes;
  std::vector<double> values;
  for (const Cell<D>& cell : cells) {
    boxes.push_back(cell.box);
    values.push_back(cell.least);
  }
  const BoxTree<D> tree(boxes, values);
  const double slope = atoms.slope();
  std::vector<char> keep(cells.size(), 1);
  parallel_for(cells.size(), [&](std::size_t i) {
    const double best = tree.minimize(boxes[i].center(), slope, values[i], [&](std::uint32_t j) {
      return values[j] < values[i] ? values[j] + slope * largest_distance(boxes[i], boxes[j]) : values[i];
    });
    keep[i] = best < values[i] ? 0 : 1;
  });
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (keep[i] != 0) atoms.add_box(values[i], boxes[i]);
}

Expression parse(const std::string& text, int dimension) {
  const std::vector<std::string> names = {"x", "y", "z"};
  try {
    return Expression(text, std::span<const std::string>(names).first(static_cast<std::size_t>(dimension)));
  } catch (const ExpressionError& error) {
    throw OptionError(Fault{.id = "spacing.expression",
                            .message = fmt::format("the size formula is wrong: {}", error.what()),
                            .fix = dimension == 2 ? "write a formula in x and y, such as 0.05+0.1*hypot(x,y)"
                                                  : "write a formula in x, y and z, such as 0.05+0.1*hypot(x,y)"});
  }
}

}  // namespace

template <int D>
void add_expression(const std::string& text, double edge_per_spacing, const Domain<D>& domain,
                    const RegionLocator<D>& locator, SizeAtoms<D>& atoms, Observer& observer) {
  const Expression formula = parse(text, D);
  const Sampler<D> sampler(text, formula, edge_per_spacing, locator);
  std::vector<Cell<D>> done;
  std::vector<Cell<D>> level(1);
  level[0].box = domain.box;
  for (int depth = 0; !level.empty(); ++depth) {
    observer.check_cancelled();
    parallel_for(
        level.size(), [&](std::size_t i) { sampler.sample(level[i]); }, 16);
    std::vector<Cell<D>> next;
    for (const Cell<D>& cell : level) {
      if (cell.is_outside) continue;
      if (cell.bad_point) sampler.refuse(*cell.bad_point);
      const double variation = std::min(cell.largest - cell.least, atoms.slope() * cell.box.diagonal());
      const bool is_smooth = variation <= kOscillation * cell.least;
      const bool may_split = depth < kLastLevel && done.size() + next.size() + (1U << D) < kMaxCells;
      if (may_split && (depth < kFirstLevels || !is_smooth))
        split(cell, next);
      else if (cell.least < std::numeric_limits<double>::infinity())
        done.push_back(cell);
    }
    level = std::move(next);
  }
  if (done.size() + (1U << D) >= kMaxCells)
    observer.log(LogLevel::kWarning, "the size formula varies more than could be sampled; sizes are on the safe side");
  add_undominated(done, atoms);
}

template void add_expression<2>(const std::string&, double, const Domain<2>&, const RegionLocator<2>&, SizeAtoms<2>&,
                                Observer&);
template void add_expression<3>(const std::string&, double, const Domain<3>&, const RegionLocator<3>&, SizeAtoms<3>&,
                                Observer&);

}  // namespace voropack
