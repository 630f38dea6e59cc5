// Figure 3 of [Miller1996]: the control volume method beside the finite element method on meshes with slivers.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack::app {

/// The harmonic function of section 2.5, u = e^(pi x) cos(pi y / sqrt 2) sin(pi z / sqrt 2), and its gradient.
double figure3_solution(const Vec<3>& x);
Vec<3> figure3_gradient(const Vec<3>& x);

/// The figures of one mesh. Those of finite elements are NaN where their system cannot be solved.
struct Figure3 {
  double cvm_w = 0;         ///< || I_h u - u_h ||_W by control volumes.
  double fem_w = 0;         ///< The same by finite elements.
  double fem_h1 = 0;        ///< || grad(u - u_h) || in L2 by finite elements.
  double radius_ratio = 0;  ///< Largest circumradius over inradius.
  double radius_edge = 0;   ///< Largest circumradius over shortest edge.
};

/// The discrete solutions on one mesh of -Laplace u = 0 with the values of `figure3_solution` on the hull. That of
/// finite elements is NaN where rounding leaves their matrix indefinite or the iteration short of its goal: a sliver of
/// height 1e-12 h has entries 1e12 times those around it.
struct Figure3Solutions {
  ControlVolumes<3> volumes;
  IdVector<VertexId, double> cvm, fem;
};
Figure3Solutions solve_figure3(const Mesh<3>& mesh, Observer& observer);
Figure3 measure_figure3(const Mesh<3>& mesh, const Figure3Solutions& solutions);

/// Simplices with a smaller dihedral angle are slivers. On the meshes of Figure 3 no angle is near to it: slivers are
/// below 2 degrees, others above 30.
inline constexpr double kSliverDihedralDeg = 10;

/// Where the errors come from: what the text of section 2.5 says of them. The H1 errors once more without slivers.
struct Figure3Details {
  std::uint64_t n_slivers = 0;
  double cvm_max = 0, fem_max = 0;  ///< Largest error at a vertex.
  struct H1Errors {
    double fem = 0, cvm = 0, interpolant = 0;
  };
  H1Errors h1, h1_without_slivers;
  /// Theorem 2.1: || U - U1 ||_W <= || U1 - U2 ||_W. Theorem 2.3: the latter <= (1 + 4 rho^2) || D^2 u || h.
  double discrete_error = 0, consistency_error = 0, bound = 0;
};
Figure3Details measure_figure3_details(const Mesh<3>& mesh, const Figure3Solutions& solutions);

/// The columns of the paper's table, in its order.
enum class Column : std::uint8_t { kRadiusRatio, kFemH1, kFemW, kCvmW };
inline constexpr std::array<Column, 4> kColumns = {Column::kRadiusRatio, Column::kFemH1, Column::kFemW, Column::kCvmW};

/// "R_over_rho", "fem_H1", "fem_W" or "cvm_W", as in reports and CSV.
std::string name_of(Column column);
double value_of(const Figure3& figures, Column column);

/// What the paper prints for h = 1/n; nothing for other rows.
std::optional<double> paper_value(std::uint32_t n, double eps, Column column);

/// Which meshes are made.
struct Figure3Options {
  std::vector<std::uint32_t> grids = {4, 8, 16, 32, 64};  ///< n = 1/h.
  std::vector<double> perturbations = {0.01, 0.001, 0.0001};
  /// Meshes per row up to n = 16. Beyond, as many fewer as a mesh has more points, but at least one.
  std::uint32_t seeds = 24;
  std::uint64_t first_seed = 1;
};

/// The figures of all meshes of one h and one perturbation.
struct Figure3Row {
  std::uint32_t n = 0;
  double eps = 0;
  std::vector<Figure3> meshes;  ///< By seed.
};

/// Mean, deviation and range of one column of a row, over the meshes that have the figure; NaN if none has.
struct Summary {
  std::size_t n = 0;
  double mean = NAN, deviation = NAN, min = NAN, median = NAN, max = NAN;
};
Summary summarize(const Figure3Row& row, Column column);

/// Meshes are made and solved in parallel; the same rows for any number of threads.
std::vector<Figure3Row> run_figure3(const Figure3Options& options, Observer& observer);

/// The paper's figures beside ours.
std::string figure3_table(const std::vector<Figure3Row>& rows);
std::string figure3_csv(const std::vector<Figure3Row>& rows);
/// The means over h on logarithmic axes.
std::string figure3_svg(const std::vector<Figure3Row>& rows);

}  // namespace voropack::app
