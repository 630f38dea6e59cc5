#include "io/svg_contours.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <set>
#include <utility>
#include <vector>

namespace voropack::io {

namespace {

/// Labels wanted along the bar, and bands from one to the next.
constexpr double kLabels = 8;
constexpr double kBandsPerLabel = 4;

/// The colours of matplotlib's "viridis": evenly spaced to the eye, also in grey and for colour-blind readers.
constexpr std::array<std::array<double, 3>, 10> kViridis = {{{0x44, 0x01, 0x54},
                                                             {0x48, 0x28, 0x78},
                                                             {0x3e, 0x49, 0x89},
                                                             {0x31, 0x68, 0x8e},
                                                             {0x26, 0x82, 0x8e},
                                                             {0x1f, 0x9e, 0x89},
                                                             {0x35, 0xb7, 0x79},
                                                             {0x6e, 0xce, 0x58},
                                                             {0xb5, 0xde, 0x2b},
                                                             {0xfd, 0xe7, 0x25}}};

/// 1, 2 or 5 times a power of ten, at least `size`.
double round_up(double size) {
  const double power = std::pow(10.0, std::floor(std::log10(size)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= size) return factor * power;
  return 10 * power;
}

struct Corner {
  Vec<2> place;
  double value = 0;
};

/// The part of a convex polygon where sign * (value - bound) >= 0.
std::vector<Corner> clip(const std::vector<Corner>& polygon, double bound, double sign) {
  std::vector<Corner> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner& a = polygon[i];
    const Corner& b = polygon[(i + 1) % polygon.size()];
    const double above_a = sign * (a.value - bound), above_b = sign * (b.value - bound);
    if (above_a >= 0) result.push_back(a);
    if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
      // From the lower end to the upper, whoever asks: neighbors get the same point.
      const Corner &low = a.value < b.value ? a : b, &high = a.value < b.value ? b : a;
      const double part = (bound - low.value) / (high.value - low.value);
      result.push_back({low.place + part * (high.place - low.place), bound});
    }
  }
  return result;
}

/// The outline of polygons of one orientation: what two of them pass in opposite directions is inside.
class Outline {
 public:
  void add(const std::vector<Corner>& polygon, const Frame& frame) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Place a = frame.place(polygon[i].place), b = frame.place(polygon[(i + 1) % polygon.size()].place);
      if (a == b) continue;
      if (const auto opposite = edges_.find({b, a}); opposite != edges_.end())
        edges_.erase(opposite);
      else
        edges_.emplace(a, b);
    }
  }

  /// As many edges end in a place as begin there: a walk ends where it began.
  void draw(Path& path) {
    while (!edges_.empty()) {
      const Place start = edges_.begin()->first;
      path.move_to(start);
      for (Place at = take_from(start); at != start; at = take_from(at)) path.line_to(at);
      path.close();
    }
  }

 private:
  /// Removes an edge that begins there, and returns its end.
  Place take_from(const Place& place) {
    constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
    const auto edge = edges_.lower_bound({place, {kLeast, kLeast}});
    const Place end = edge->second;
    edges_.erase(edge);
    return end;
  }

  std::multiset<std::pair<Place, Place>> edges_;
};

}  // namespace

ColorScale::ColorScale(std::span<const double> values) {
  if (values.empty()) return;
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  const double range = *largest - *least;
  // What differs by rounding only is one colour.
  constexpr double kRounding = 1e-12;
  const double magnitude = std::max(std::abs(*least), std::abs(*largest));
  step_ = round_up(range > kRounding * magnitude ? range / kLabels : std::max(magnitude, 1e-300)) / kBandsPerLabel;
  first_ = std::floor(*least / step_);
  n_bands_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(*largest / step_) - first_));
}

std::size_t ColorScale::band_of(double value) const {
  const double band = std::floor(value / step_) - first_;
  return static_cast<std::size_t>(std::clamp(band, 0.0, static_cast<double>(n_bands_ - 1)));
}

std::string ColorScale::color(std::size_t band) const {
  const double part = (static_cast<double>(band) + 0.5) / static_cast<double>(n_bands_) * (kViridis.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(part), kViridis.size() - 2);
  const double t = part - static_cast<double>(i);
  std::string color = "#";
  for (std::size_t k = 0; k < 3; ++k)
    color += fmt::format("{:02x}", std::lround((1 - t) * kViridis[i][k] + t * kViridis[i + 1][k]));
  return color;
}

std::string ColorScale::label(std::size_t i) const {
  const double number = first_ + static_cast<double>(i);
  if (std::fmod(number, kBandsPerLabel) != 0) return {};
  return fmt::format("{:.6g}", number == 0 ? 0.0 : number * step_);
}

std::string contour_bands(const Mesh<2>& mesh, std::span<const double> values, const ColorScale& scale,
                          const Frame& frame) {
  std::vector<Outline> bands(scale.size());
  for (const auto& corners : mesh.simplex_vertices) {
    std::vector<Corner> triangle;
    for (const VertexId v : corners) triangle.push_back({mesh.points[v], values[v.value()]});
    const auto [low, high] = std::minmax_element(triangle.begin(), triangle.end(),
                                                 [](const Corner& a, const Corner& b) { return a.value < b.value; });
    const std::size_t first = scale.band_of(low->value), last = scale.band_of(high->value);
    for (std::size_t band = first; band <= last; ++band) {
      std::vector<Corner> polygon = triangle;
      if (band > first) polygon = clip(polygon, scale.edge(band), 1);
      if (band < last) polygon = clip(polygon, scale.edge(band + 1), -1);
      bands[band].add(polygon, frame);
    }
  }
  // A line of the same colour covers the seams between neighbours.
  std::string svg;
  for (std::size_t band = 0; band < scale.size(); ++band) {
    Path path(frame);
    bands[band].draw(path);
    if (!path.data().empty())
      svg += fmt::format("<path fill=\"{0}\" stroke=\"{0}\" stroke-width=\"8\" d=\"{1}\"/>\n", scale.color(band),
                         path.data());
  }
  return svg;
}

std::string color_bar(const std::string& name, const ColorScale& scale, const Frame& frame) {
  constexpr double kWidth = 0.03 * kPictureSize, kText = 0.026 * kPictureSize;
  const double left = frame.width + kMargin, top = kMargin + 2 * kText, bottom = frame.height - kMargin - 0.5 * kText;
  const double height = std::max(bottom - top, kText) / static_cast<double>(scale.size());
  const auto place = [&](std::size_t i) { return top + height * static_cast<double>(scale.size() - i); };
  std::string svg = fmt::format("<g id=\"scale\" font-family=\"sans-serif\" font-size=\"{:.0f}\">\n", kText);
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" fill=\"#1c2b3a\">{}</text>\n", left, kMargin + 0.8 * kText,
                     escaped(name));
  for (std::size_t i = 0; i < scale.size(); ++i)
    svg += fmt::format("<rect x=\"{:.0f}\" y=\"{:.1f}\" width=\"{:.0f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", left,
                       place(i + 1), kWidth, height + 4, scale.color(i));
  for (std::size_t i = 0; i <= scale.size(); ++i)
    if (const std::string label = scale.label(i); !label.empty())
      svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" fill=\"#1c2b3a\">{}</text>\n", left + 1.3 * kWidth,
                         place(i) + 0.35 * kText, label);
  return svg + "</g>\n";
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<')
      result += "&lt;";
    else if (c == '&')
      result += "&amp;";
    else
      result += c;
  }
  return result;
}

}  // namespace voropack::io
