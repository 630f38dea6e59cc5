#include "print.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <system_error>

#include "terminal_observer.h"
#include "voropack/error.h"

namespace voropack::app {

namespace {

constexpr int kBarWidth = 40;
constexpr std::size_t kMaxBins = 12;

std::string number(double value) { return fmt::format("{:.4g}", value); }

std::string spread_row(std::string_view name, const QualityReport::Spread& s) {
  return fmt::format("{:<18}{:>12}{:>12}{:>12}{:>12}\n", name, number(s.min), number(s.mean), number(s.p99),
                     number(s.max));
}

/// Neighboring bins joined until at most kMaxBins are left, without the empty ones at both ends.
Histogram condensed(const Histogram& histogram) {
  const std::size_t n = histogram.bins.size();
  std::size_t first = 0, last = n;
  while (first < last && histogram.bins[first] == 0) ++first;
  while (last > first && histogram.bins[last - 1] == 0) --last;
  const double width = (histogram.hi - histogram.lo) / static_cast<double>(std::max<std::size_t>(n, 1));
  const std::size_t step = std::max<std::size_t>(1, (last - first + kMaxBins - 1) / kMaxBins);
  Histogram result;
  result.lo = histogram.lo + width * static_cast<double>(first);
  for (std::size_t begin = first; begin < last; begin += step) {
    std::uint64_t sum = 0;
    for (std::size_t i = begin; i < std::min(begin + step, n); ++i) sum += histogram.bins[i];
    result.bins.push_back(sum);
  }
  result.hi = result.lo + width * static_cast<double>(step * result.bins.size());
  return result;
}

std::string histogram_text(std::string_view name, const Histogram& full) {
  const Histogram histogram = condensed(full);
  if (histogram.bins.empty()) return {};
  const std::uint64_t largest = *std::max_element(histogram.bins.begin(), histogram.bins.end());
  const double width = (histogram.hi - histogram.lo) / static_cast<double>(histogram.bins.size());
  std::string text = fmt::format("\n{}\n", name);
  for (std::size_t i = 0; i < histogram.bins.size(); ++i) {
    const double lo = histogram.lo + width * static_cast<double>(i);
    const double part = static_cast<double>(histogram.bins[i]) / static_cast<double>(largest);
    const int length = histogram.bins[i] == 0 ? 0 : std::max(1, static_cast<int>(std::lround(part * kBarWidth)));
    text += fmt::format("{:>10} .. {:<10}{:>14}  {:#<{}}\n", number(lo), number(lo + width), grouped(histogram.bins[i]),
                        "", length);
  }
  return text;
}

std::string_view verdict(const Certificate::Check& check) {
  if (!check.ok) return "FAILED";
  return check.tested > 0 ? "ok" : "not tested";
}

}  // namespace

std::string count_table(const QualityReport& quality) {
  std::string text;
  const auto row = [&](std::string_view name, std::uint64_t count) {
    text += fmt::format("{:<18}{:>12}\n", name, grouped(count));
  };
  row("vertices", quality.n_vertices);
  row("simplices", quality.n_simplices);
  row("boundary simplices", quality.n_boundary_simplices);
  row("cells", quality.n_cells);
  row("dual faces", quality.n_dual_faces);
  text += '\n' + fmt::format("{:<18}{:>12}{:>12}\n", "region", "simplices", "volume");
  for (const QualityReport::Region& region : quality.regions)
    text += fmt::format("{:<18}{:>12}{:>12}\n", region.id, grouped(region.n_simplices), number(region.volume));
  return text;
}

std::string quality_table(const QualityReport& quality) {
  std::string text = fmt::format("{:<18}{:>12}{:>12}{:>12}{:>12}\n", "quality", "min", "mean", "99 %", "max");
  text += spread_row("radius/edge", quality.radius_edge);
  text += spread_row("angle, deg", quality.angle_deg);
  if (quality.dihedral_deg) text += spread_row("dihedral, deg", *quality.dihedral_deg);
  text += spread_row("edge length", quality.edge_length);
  text += spread_row("cell aspect R/r", quality.cell_aspect);
  text += fmt::format("{:<18}{:>12}\n", "cell volume", number(quality.min_cell_volume));
  if (quality.n_negative_faces > 0)
    text += fmt::format("{:<18}{:>12}   of negative area\n", "dual faces", grouped(quality.n_negative_faces));
  return text;
}

std::string histograms(const QualityReport& quality) {
  std::string text = histogram_text("radius/edge of simplices", quality.radius_edge.histogram);
  text += histogram_text("angles, deg", quality.angle_deg.histogram);
  if (quality.dihedral_deg) text += histogram_text("dihedral angles, deg", quality.dihedral_deg->histogram);
  text += histogram_text("edge lengths", quality.edge_length.histogram);
  text += histogram_text("cell aspects R/r", quality.cell_aspect.histogram);
  return text;
}

std::string certificate_table(const Certificate& certificate) {
  std::string text =
      fmt::format("{:<20}{:<11}{:>14}{:>12}{:>12}  {}\n", "check", "", "tested", "violations", "worst", "where");
  for (const Certificate::Check& check : certificate.checks) {
    std::string row =
        fmt::format("{:<20}{:<11}{:>14}{:>12}{:>12}  {}", check.name, verdict(check), grouped(check.tested),
                    grouped(check.violations), check.worst ? number(*check.worst) : std::string(), check.where);
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + '\n';
  }
  return text + (certificate.ok ? "certificate: ok\n" : "certificate: FAILED\n");
}

void print_to_stdout(const std::string& text) {
  errno = 0;
  std::fwrite(text.data(), 1, text.size(), stdout);
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  if (!failed || errno == EPIPE) return;
  throw InputError(
      Fault{.id = "cli.stdout",
            .message = fmt::format("cannot write to standard output: {}", std::generic_category().message(errno)),
            .fix = "let standard output go to a place with room, or use --quiet."});
}

}  // namespace voropack::app
