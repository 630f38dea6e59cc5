// Heaps of tetrahedra with small angles: what the certificate says of 200 arrangements, ordered by their least angle.
//
// Usage: heaps [first end [cpu_seconds]], by default 0 200 90. Even numbers are random tetrahedra that share corners
// and edges; odd ones are picked from a Delaunay triangulation of random points, and share facets, too.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "support/sharp_domains.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Stops after so many seconds of all threads together.
class Deadline : public Observer {
 public:
  explicit Deadline(double seconds) : end_(cpu_seconds() + seconds) {}
  [[nodiscard]] bool cancelled() const override { return cpu_seconds() > end_; }

 private:
  double end_;
};

test::Case<3> heap(bool is_delaunay, std::uint64_t seed, double least_deg) {
  if (!is_delaunay) return test::sharp::tetrahedra(2 + seed % 4, least_deg, seed);
  return test::sharp::heap<3>(5 + seed % 8, 0.4, seed);
}

void run(const test::Case<3>& c, double seconds, double least_deg) {
  const double angle = test::sharp::least_angle_deg(c.input), begin = cpu_seconds();
  if (angle < least_deg) return;
  std::string result, failed;
  try {
    Deadline deadline(seconds);
    const MeshingResult<3> r = make_mesh(c.input, {}, deadline);
    for (const Certificate::Check& check : r.certificate.checks)
      if (!check.ok)
        failed += fmt::format(" {} {} worst {:.4g}", check.name, check.violations, check.worst.value_or(0));
    result = fmt::format("{:>4} | {:>7} | {:>2} | {:>8.2f}", failed.empty() ? "yes" : "no", r.mesh.points.size(),
                         r.repair_rounds, r.quality.radius_edge.max);
  } catch (const Error& error) {
    result = fmt::format("{:>4} | {:>7} | {:>2} | {:>8}", "no", "", "", "");
    failed = " " + error.id();
  }
  fmt::print("| {:<16} | {:>5.2f} | {} | {:>6.2f} |{}\n", c.name, angle, result, cpu_seconds() - begin, failed);
  std::fflush(stdout);
}

}  // namespace
}  // namespace voropack

int main(int argc, char** argv) {
  const bool is_delaunay = argc > 1 && std::string(argv[1]) == "delaunay";
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  const std::uint64_t end = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 200;
  const double seconds = argc > 4 ? std::atof(argv[4]) : 90, least_deg = argc > 5 ? std::atof(argv[5]) : 0;
  for (std::uint64_t seed = first; seed < end; ++seed)
    voropack::run(voropack::heap(is_delaunay, seed, least_deg), seconds, least_deg);
}
