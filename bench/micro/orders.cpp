// How the error in the W norm falls with the number of vertices on packed unit cubes.
//
// Usage: orders [n_vertices ...], by default 10000 100000 1000000
#include <fmt/format.h>

#include <cstdlib>
#include <map>
#include <vector>

#include "support/convergence.h"

namespace voropack {
namespace {

struct Error {
  double n_vertices = 0;
  double value = 0;
};

/// A line for each mesh, with the order since the one before.
void run(const std::vector<double>& counts) {
  fmt::print("{:<8} {:>9}  {:<12} {:>10} {:>7} {:>14}\n", "interior", "vertices", "solution", "W error", "order",
             "error n^(1/3)");
  for (const Interior interior : {Interior::kLattice, Interior::kRandom}) {
    std::map<std::string, Error> before;
    for (const double count : counts) {
      const MeshingResult<3> result = test::packed_cube(count, interior);
      const auto n = static_cast<double>(result.mesh.points.size());
      for (const test::Manufactured& problem : test::manufactured_solutions()) {
        const double error = test::w_error(result, problem);
        const Error last = before[problem.name];
        before[problem.name] = {n, error};
        const std::string order =
            last.n_vertices > 0 ? fmt::format("{:.3f}", test::observed_order(last.n_vertices, last.value, n, error))
                                : "";
        fmt::print("{:<8} {:>9}  {:<12} {:>10.4e} {:>7} {:>14.4f}\n",
                   interior == Interior::kLattice ? "lattice" : "random", n, problem.name, error, order,
                   error * std::cbrt(n));
      }
    }
  }
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  std::vector<double> counts = {1e4, 1e5, 1e6};
  if (argc > 1) counts.clear();
  for (int i = 1; i < argc; ++i) counts.push_back(std::atof(argv[i]));
  voropack::run(counts);
}
