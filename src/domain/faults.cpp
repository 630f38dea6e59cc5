#include "domain/faults.h"

#include <fmt/format.h>

namespace voropack::domain_impl {

template <int D>
std::string Names<D>::point(std::size_t i) const {
  return fmt::format("point {}", number(i));
}

template <int D>
std::string Names<D>::segment(std::size_t i) const {
  const auto& s = input_->segments[i];
  return fmt::format("segment {} (points {} and {}{})", number(i), number(s.points[0]), number(s.points[1]),
                     s.line ? fmt::format(", line {}", *s.line) : "");
}

template <int D>
std::string Names<D>::facet(std::size_t i) const {
  const auto& f = input_->facets[i];
  std::string corners;
  if (f.polygons.size() == 1 && f.polygons[0].size() <= 4)
    for (const std::uint32_t p : f.polygons[0]) corners += fmt::format("{}{}", corners.empty() ? "" : ", ", number(p));
  if (!corners.empty()) corners = "points " + corners;
  if (f.line) corners += fmt::format("{}line {}", corners.empty() ? "" : "; ", *f.line);
  return fmt::format("facet {}{}", number(i), corners.empty() ? "" : " (" + corners + ")");
}

template <int D>
void FaultList<D>::add(const std::string& id, std::string message, std::string fix,
                       const std::optional<Vec<D>>& position, const std::optional<std::uint64_t>& line) {
  if (full()) return;
  Fault fault{.id = "domain." + id, .message = std::move(message), .fix = std::move(fix), .file = input_->file};
  fault.line = line;
  if (position) fault.position.assign(position->coord.begin(), position->coord.end());
  faults_.push_back(std::move(fault));
}

template class Names<2>;
template class Names<3>;
template class FaultList<2>;
template class FaultList<3>;

}  // namespace voropack::domain_impl
