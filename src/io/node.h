// The node list that .node, .poly and .smesh files of Triangle and TetGen begin with.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "io/text_scanner.h"
#include "voropack/vec.h"

namespace voropack::io {

/// `<points> <dimension> <attributes> <markers>`; what is left out at the end counts as 0.
struct NodeHeader {
  std::uint64_t n_points = 0;
  std::optional<int> dimension;  ///< 2 or 3.
  std::uint64_t n_attributes = 0;
  bool has_markers = false;
};

template <int D>
struct NodeList {
  std::vector<Vec<D>> points;
  std::vector<double> first_attribute;  ///< Empty if there are no attributes.
  std::vector<int> markers;             ///< Empty if there are none.
  std::uint32_t first_index = 0;        ///< 0 or 1: the number of the first point.
};

NodeHeader read_node_header(TextScanner& scanner);

/// The dimension of the header. Throws io.bad_dimension if it is absent.
int required_dimension(const NodeHeader& header, const TextScanner& scanner);

/// Reads the header's points. Throws: InputError io.truncated, io.missing_value, io.extra_value, io.bad_number,
/// io.not_finite, io.bad_index, io.bad_count.
template <int D>
NodeList<D> read_node_list(TextScanner& scanner, const NodeHeader& header);

/// "0 or 1" of a header that says whether a marker ends each line.
bool read_marker_flag(TextScanner& scanner);

/// A region's id, which these files write as a real number. Throws io.missing_value, io.bad_number, io.not_finite,
/// io.bad_region if it is no whole number of 32 bits.
int read_region_id(TextScanner& scanner, std::string_view what);

}  // namespace voropack::io
