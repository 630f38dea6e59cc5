// The facets of a sheet as one facet.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "domain/sheets.h"

namespace voropack::domain_impl {

/// How many facets have an edge between two points, by the key of Complex.
using EdgeCounts = std::unordered_map<std::uint64_t, Index>;

EdgeCounts count_edges(const Complex<3>& complex);

/// Replaces facets of a flat sheet that meet at edges with no third facet by one facet with their common outline, so
/// that thin triangles between them, which rounding may have turned over, do not matter. Facets of different markers
/// stay apart, and so do those that are folded: where a facet thicker than `thickness` lies upside down between the
/// others. Facets that became part of another one lose their points. For bare surfaces, where inside is what an odd
/// number of crossings of the outline leads to.
void join_outlines(Complex<3>& complex, const Sheet& sheet, const EdgeCounts& counts, double thickness);

}  // namespace voropack::domain_impl
