// The cells of a quadtree or octree in which there may still be room for an f-sphere, and the two ways to fill them:
// lattice points where nothing is in the way, darts elsewhere. See Ebeida et al., CGF 31 (2012), for the dart throwing;
// radii vary here.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "spheres/lattice.h"
#include "spheres/packing_problem.h"

namespace voropack {

/// The region of a center that is on the boundary, or that was there from the start.
inline constexpr int kNoRegion = -1;

template <int K>
class ActiveCells {
 public:
  /// Finds the cells that the fixed spheres and balls of the problem leave open, each at most 2 f / sqrt(K) wide, so
  /// that it can hold the center of one sphere. With `lattice`, fills what is far from all obstacles with lattice
  /// points.
  ActiveCells(const PackingProblem<K>& problem, bool lattice, const Observer& observer);

  /// One dart into each active cell, in random order: those that are admissible and do not conflict with an earlier one
  /// join.
  /// Stops early, not having tried all cells, when less than `least_yield` of the darts join.
  void throw_darts(double least_yield = 0);
  /// The same with the centers of the cells.
  void try_centers();
  /// Splits every active cell and drops the children that are covered or outside.
  void split();

  [[nodiscard]] std::size_t size() const { return cells_.size(); }
  /// Largest of (1 + b) r / f(m) over the cells: how far from a blocked point a point of a cell can be, relative to f.
  [[nodiscard]] double openness() const;

  /// All spheres: the problem's fixed ones, its foreign ones, then those that joined.
  [[nodiscard]] const SphereSet<K>& spheres() const { return spheres_; }
  SphereSet<K>& spheres() { return spheres_; }
  [[nodiscard]] const BallSet<K>& balls() const { return balls_; }
  /// By sphere that joined: its region.
  [[nodiscard]] const std::vector<int>& regions() const { return regions_; }
  std::vector<int>& regions() { return regions_; }
  [[nodiscard]] std::size_t first_new() const { return problem_.fixed.size() + problem_.foreign.size(); }

 private:
  static constexpr std::int32_t kMixed = -2;
  struct Cell {
    std::array<std::int32_t, K> index;
    std::int32_t level;
    std::int32_t region;  ///< kMixed if a wall may pass through.
    double constant = 0;  ///< The value of f where the cell is within the bounds, if it is constant there; else 0.
    double least = 0;     ///< A lower bound of f in the cell.
    [[nodiscard]] bool is_mixed() const { return region == kMixed; }
  };
  /// A sphere that would like to join.
  struct Candidate {
    Ball<K> sphere;
    int region;
    std::uint64_t priority;
  };
  struct LatticePoint {
    Vec<K> position;
    int cls;
    int region;       ///< kNoRegion if not known.
    bool free;        ///< Nothing but points of other classes can be in the way.
    double constant;  ///< As in Cell.
  };
  ActiveCells(const PackingProblem<K>& problem, bool lattice, double largest, const Observer& observer);

  /// A place in Obstacles.
  struct Mark {
    std::size_t spheres, balls;
    bool operator==(const Mark&) const = default;
  };
  /// Two stacks of what is in the way: behind that of a cell comes, again, what matters for its child.
  struct Obstacles {
    std::vector<Ball<K>> spheres, balls;
    [[nodiscard]] Mark mark() const { return {spheres.size(), balls.size()}; }
    /// Pushes those from `parent` on that can matter in the box, where f <= f_max.
    void push_near(const Mark& parent, const Box<K>& box, double f_max);
    void pop_to(const Mark& m) {
      spheres.resize(m.spheres);
      balls.resize(m.balls);
    }
    [[nodiscard]] Obstacles from(const Mark& m) const {
      return {{spheres.begin() + static_cast<std::ptrdiff_t>(m.spheres), spheres.end()},
              {balls.begin() + static_cast<std::ptrdiff_t>(m.balls), balls.end()}};
    }
  };
  /// f at the center of a cell, and bounds of it.
  struct Range {
    double center, lo, hi;
  };
  struct Harvest {
    std::vector<Cell> cells;
    std::vector<LatticePoint> points;
  };

  [[nodiscard]] Box<K> box_of(const Cell& cell) const;
  [[nodiscard]] double side(int level) const;
  /// f at the point of the bounds nearest to x: cells stick out of the bounds.
  [[nodiscard]] double spacing_near(const Vec<K>& x) const;
  /// f(x), where `constant` is its value if known, else 0.
  [[nodiscard]] double spacing_at(const Vec<K>& x, double constant) const {
    return constant > 0 ? constant : problem_.spacing.at(x);
  }
  [[nodiscard]] static std::array<Cell, std::size_t{1} << K> children(const Cell& cell);
  void locate(Cell& cell, const Box<K>& box) const;
  void subdivide(const Cell& cell, Obstacles& obstacles, const Mark& parent, Harvest& out) const;
  void open(const Cell& cell, const Box<K>& box, const Range& f, Obstacles& obstacles, const Mark& mine,
            Harvest& out) const;
  [[nodiscard]] std::optional<int> class_beside_plateau(const Box<K>& box) const;
  [[nodiscard]] bool is_covered(const Obstacles& obstacles, const Mark& begin, const Vec<K>& m, double r,
                                double f) const;
  /// Tightens the cell's lower bound of f.
  [[nodiscard]] bool is_covered(Cell& cell) const;
  [[nodiscard]] int region_at(const Cell& cell, const Vec<K>& x) const;
  void place_lattice(const std::vector<LatticePoint>& points);
  template <class Position>
  void try_in_cells(std::uint32_t n_groups, double least_yield, Position&& position);
  [[nodiscard]] std::uint64_t hash_of(const Cell& cell) const;
  [[nodiscard]] Candidate candidate_at(const Cell& cell, const Vec<K>& x, std::uint64_t priority) const;
  void join(const std::vector<Candidate>& candidates);

  const PackingProblem<K>& problem_;
  const Observer& observer_;
  Vec<K> origin_;
  double side_ = 0;
  std::optional<LatticeFamily<K>> lattice_;
  SphereSet<K> spheres_;
  BallSet<K> balls_;
  std::vector<Cell> cells_;
  std::vector<int> regions_;
  std::uint64_t round_ = 0;
};

}  // namespace voropack
