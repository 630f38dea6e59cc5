// How the error in the W norm falls with the number of vertices on packed unit cubes.
//
// Usage: orders [n_vertices ...], by default six between 10^4 and 10^6
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "support/convergence.h"

namespace voropack {
namespace {

void run(const std::vector<double>& counts) {
  const std::vector<test::Manufactured> solutions = test::manufactured_solutions();
  for (const Interior interior : {Interior::kLattice, Interior::kRandom}) {
    fmt::print("{}\n{:>9}", interior == Interior::kLattice ? "lattice" : "random", "vertices");
    for (const auto& solution : solutions) fmt::print(" {:>12}", solution.name);
    fmt::print("\n");
    std::vector<test::ErrorHistory> histories(solutions.size());
    for (const double count : counts) {
      const MeshingResult<3> result = test::packed_cube(count, interior);
      const std::vector<double> errors = test::w_errors(result);
      fmt::print("{:>9}", result.mesh.points.size());
      for (std::size_t k = 0; k < errors.size(); ++k) {
        histories[k].n_vertices.push_back(static_cast<double>(result.mesh.points.size()));
        histories[k].errors.push_back(errors[k]);
        fmt::print(" {:>12.4e}", errors[k]);
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
    fmt::print("{:>9}", "order");
    for (const auto& history : histories) fmt::print(" {:>12.3f}", history.order());
    fmt::print("\n{:>9}", "error / h");
    for (const auto& history : histories) fmt::print(" {:>12.4f}", history.constant());
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  std::vector<double> counts = {1e4, 2e4, 5e4, 1e5, 3e5, 1e6};
  if (argc > 1) counts.clear();
  for (int i = 1; i < argc; ++i) counts.push_back(std::atof(argv[i]));
  voropack::run(counts);
}
