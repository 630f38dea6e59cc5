// The check `conformity`: the boundary complex in itself, and against a domain.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "certificate/checks.h"

namespace voropack::judge {

/// Faults of the check `conformity`, from derived to basic: the text shown is that of the most basic one.
enum ConformityFault : int {
  kWrongMarker = 1,
  kUnmatchedEdge,
  kFacetArea,
  kNotCovered,
  kWrongRegion,
  kOffDomain,
  kUnlisted,
  kNoFace,
  kDuplicateVertex,
  kBadList,
};

/// Counts, and the words of the most basic fault. Serial: boundaries are small.
class ConformityReport {
 public:
  void tested(std::uint64_t n = 1) { tested_ += n; }
  /// `text()` is called only if the fault is the most basic so far.
  template <class Text>
  void fault(ConformityFault kind, const Text& text, std::uint64_t count = 1) {
    violations_ += count;
    if (kind <= kind_) return;
    kind_ = kind;
    where_ = text();
  }
  [[nodiscard]] Check finish(double worst_area, const std::string& otherwise) const;

 private:
  std::uint64_t tested_ = 0;
  std::uint64_t violations_ = 0;
  int kind_ = 0;
  std::string where_;
};

/// An edge of the mesh, smaller vertex first.
using Edge = std::array<std::uint32_t, 2>;
inline Edge make_edge(std::uint32_t a, std::uint32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }

/// For each of the sorted `edges`, whether some valid simplex has it.
template <int D>
std::vector<std::uint8_t> find_mesh_edges(const Subject<D>& subject, const std::vector<Edge>& edges);

/// Compares the boundary complex with `subject.domain`. Returns the largest relative difference of facet areas.
template <int D>
double compare_with_domain(const Subject<D>& subject, ConformityReport& report);

}  // namespace voropack::judge
