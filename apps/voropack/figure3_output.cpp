// Figure 3 as table, CSV and picture.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string_view>

#include "figure3.h"

namespace voropack::app {

namespace {

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.7g}", value) : "-"; }

/// All digits; nothing if it is no number.
std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

std::string figure3_table(const std::vector<Figure3Row>& rows) {
  std::string text = fmt::format("{:<6}{:<9}{:<12}{:>14}{:>14}{:>14}{:>14}{:>8}\n", "h", "eps", "", "paper", "mean",
                                 "min", "max", "meshes");
  for (const Figure3Row& row : rows) {
    std::string h = fmt::format("1/{}", row.n), eps = fmt::format("{:g}", row.eps);
    for (const Column column : kColumns) {
      const Summary ours = summarize(row, column);
      const std::optional<double> paper = paper_value(row.n, row.eps, column);
      text += fmt::format("{:<6}{:<9}{:<12}{:>14}{:>14}{:>14}{:>14}{:>8}\n", h, eps, name_of(column),
                          paper ? number(*paper) : "", number(ours.mean), number(ours.min), number(ours.max), ours.n);
      h.clear();
      eps.clear();
    }
  }
  return text;
}

std::string figure3_csv(const std::vector<Figure3Row>& rows) {
  std::string text = "n,eps,seeds,col,paper,mean,sd,min,median,max\n";
  for (const Figure3Row& row : rows)
    for (const Column column : kColumns) {
      const Summary s = summarize(row, column);
      const std::optional<double> paper = paper_value(row.n, row.eps, column);
      text += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", row.n, row.eps, s.n, name_of(column),
                          paper ? cell(*paper) : "", cell(s.mean), cell(s.deviation), cell(s.min), cell(s.median),
                          cell(s.max));
    }
  return text;
}

namespace {

constexpr double kWidth = 720, kHeight = 560, kLeft = 80, kRight = 200, kTop = 30, kBottom = 60;

/// Colours that colour-blind readers tell apart (Paul Tol's "bright" scheme), and dashes by perturbation.
constexpr std::array<std::string_view, 3> kColours = {"#ee6677", "#ccbb44", "#4477aa"};
constexpr std::array<Column, 3> kCurves = {Column::kFemH1, Column::kFemW, Column::kCvmW};
constexpr std::array<std::string_view, 3> kCurveNames = {"FEM, H1", "FEM, W", "CVM, W"};
constexpr std::array<std::string_view, 4> kDashes = {"none", "8 4", "2 3", "8 3 2 3"};

/// Logarithmic axes over whole powers of two (h) and ten (errors).
class LogFrame {
 public:
  explicit LogFrame(const std::vector<Figure3Row>& rows) {
    for (const Figure3Row& row : rows) {
      const double x = std::log2(row.n);
      x_lo_ = std::min(x_lo_, std::floor(x));
      x_hi_ = std::max(x_hi_, std::ceil(x));
      for (const Column column : kCurves) {
        const double mean = summarize(row, column).mean;
        if (!(mean > 0) || !std::isfinite(mean)) continue;
        y_lo_ = std::min(y_lo_, std::floor(std::log10(mean)));
        y_hi_ = std::max(y_hi_, std::ceil(std::log10(std::max(mean, paper_value(row.n, row.eps, column).value_or(0)))));
      }
    }
    if (!std::isfinite(y_lo_)) y_lo_ = y_hi_ = 0;  // Nothing to draw.
    if (x_hi_ <= x_lo_) x_hi_ = x_lo_ + 1;
    if (y_hi_ <= y_lo_) y_hi_ = y_lo_ + 1;
  }
  [[nodiscard]] double x(double n) const {
    return kLeft + (std::log2(n) - x_lo_) / (x_hi_ - x_lo_) * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double error) const {
    return kTop + (y_hi_ - std::log10(error)) / (y_hi_ - y_lo_) * (kHeight - kTop - kBottom);
  }
  /// Lines and labels at the powers.
  [[nodiscard]] std::string axes() const {
    std::string text;
    for (double p = x_lo_; p <= x_hi_; ++p) {
      const double at = x(std::exp2(p));
      text += fmt::format("<path class=\"grid\" d=\"M{:.1f} {}V{}\"/>\n", at, kTop, kHeight - kBottom);
      text += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">1/{:.0f}</text>\n", at,
                          kHeight - kBottom + 20, std::exp2(p));
    }
    for (double p = y_lo_; p <= y_hi_; ++p) {
      const double at = y(std::pow(10, p));
      text += fmt::format("<path class=\"grid\" d=\"M{} {:.1f}H{}\"/>\n", kLeft, at, kWidth - kRight);
      text += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n", kLeft - 8, at + 4,
                          std::pow(10, p));
    }
    text += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">h</text>\n", (kLeft + kWidth - kRight) / 2,
                        kHeight - 15);
    return text;
  }

 private:
  double x_lo_ = INFINITY, x_hi_ = -INFINITY, y_lo_ = INFINITY, y_hi_ = -INFINITY;
};

std::string curve(const LogFrame& frame, const std::vector<const Figure3Row*>& rows, Column column,
                  std::string_view colour, std::string_view dash) {
  std::string line, dots;
  for (const Figure3Row* row : rows) {
    const double mean = summarize(*row, column).mean;
    if (!(mean > 0) || !std::isfinite(mean)) continue;
    const double x = frame.x(row->n), y = frame.y(mean);
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? 'M' : 'L', x, y);
    if (const auto paper = paper_value(row->n, row->eps, column))
      dots += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8\" height=\"8\" fill=\"none\" stroke=\"{}\"/>\n",
                          x - 4, frame.y(*paper) - 4, colour);
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\" fill=\"{}\"/>\n", x, y, colour);
  }
  return fmt::format("<path class=\"curve\" stroke=\"{}\" stroke-dasharray=\"{}\" d=\"{}\"/>\n", colour, dash, line) +
         dots;
}

std::string legend_entry(std::size_t place, std::string_view name, double eps, std::string_view colour,
                         std::string_view dash) {
  const double x = kWidth - kRight + 15, y = kTop + 10 + 20 * static_cast<double>(place);
  return fmt::format("<path class=\"curve\" stroke=\"{}\" stroke-dasharray=\"{}\" d=\"M{} {}h30\"/>\n", colour, dash, x,
                     y) +
         fmt::format("<text x=\"{}\" y=\"{}\">{}, eps {:g}</text>\n", x + 38, y + 4, name, eps);
}

}  // namespace

std::string figure3_svg(const std::vector<Figure3Row>& rows) {
  const LogFrame frame(rows);
  std::map<double, std::vector<const Figure3Row*>, std::greater<>> by_eps;
  for (const Figure3Row& row : rows) by_eps[row.eps].push_back(&row);
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<style>text{{font:13px sans-serif}}.grid{{stroke:#ddd;fill:none}}.curve{{fill:none;stroke-width:1.5}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      kWidth, kHeight);
  text += frame.axes();
  std::size_t place = 0;
  for (std::size_t c = 0; c < kCurves.size(); ++c) {
    std::size_t dash = 0;
    for (const auto& [eps, row] : by_eps) {
      text += curve(frame, row, kCurves[c], kColours[c], kDashes[dash]);
      text += legend_entry(place++, kCurveNames[c], eps, kColours[c], kDashes[dash]);
      dash = (dash + 1) % kDashes.size();
    }
  }
  text += fmt::format("<text x=\"{}\" y=\"{}\">squares: the paper</text>\n", kWidth - kRight + 15,
                      kTop + 24 + 20 * static_cast<double>(place));
  return text + "</svg>\n";
}

}  // namespace voropack::app
