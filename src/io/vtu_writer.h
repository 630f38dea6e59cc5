// Writes VTK XML unstructured grids (.vtu): arrays are made, compressed and written piece by piece.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace voropack::io {

/// One array of a .vtu file. Its values are computed in pieces when they are written, from several threads.
struct VtuArray {
  /// Writes the values [begin, begin + out.size()) to `out`.
  template <class T>
  using Fill = std::function<void(std::uint64_t begin, std::span<T> out)>;

  std::string name;
  std::uint64_t n_values = 0;  ///< Components times tuples.
  int n_components = 1;
  std::variant<Fill<double>, Fill<std::int32_t>, Fill<std::int64_t>, Fill<std::uint8_t>> fill;
};

/// A grid with one piece.
struct VtuGrid {
  std::uint64_t n_points = 0, n_cells = 0;
  VtuArray points;  ///< 3 components.
  std::vector<VtuArray> point_data, cell_data, field_data;
  std::vector<VtuArray> cells;  ///< connectivity, offsets, types; for polyhedra also faces and faceoffsets.
};

/// Writes `grid` with appended raw data, compressed by zlib; equal bytes for any number of threads. Throws: InputError
/// io.cannot_write.
void write_vtu(const VtuGrid& grid, const std::filesystem::path& path);

}  // namespace voropack::io
