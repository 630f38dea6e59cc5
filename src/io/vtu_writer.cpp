#include "io/vtu_writer.h"

#include <fmt/format.h>
#include <zlib.h>

#include "base/parallel.h"
#include "io/atomic_file.h"
#include "voropack/error.h"

namespace voropack::io {

namespace {

/// Uncompressed size of a block: large enough for good compression, small enough to keep all threads at work.
constexpr std::uint64_t kBlockBytes = std::uint64_t{1} << 18U;
/// Blocks that are in memory at the same time.
constexpr std::uint64_t kBlocksInFlight = 64;
/// Level 1 costs a third of the time of the default 6 and makes meshes about 10 percent larger.
constexpr int kCompressionLevel = 1;
/// The digits of the largest offset; the place of each is kept open until the data is written.
constexpr std::size_t kOffsetDigits = 20;

template <class T>
constexpr const char* kTypeName = nullptr;
template <>
constexpr const char* kTypeName<double> = "Float64";
template <>
constexpr const char* kTypeName<std::int32_t> = "Int32";
template <>
constexpr const char* kTypeName<std::int64_t> = "Int64";
template <>
constexpr const char* kTypeName<std::uint8_t> = "UInt8";

template <class T>
std::string compress_block(const VtuArray::Fill<T>& fill, std::uint64_t begin, std::uint64_t n) {
  std::vector<T> values(n);
  fill(begin, values);
  uLongf size = compressBound(static_cast<uLong>(n * sizeof(T)));
  std::string block(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(block.data()), &size,
                               reinterpret_cast<const Bytef*>(values.data()), n * sizeof(T), kCompressionLevel);
  if (status != Z_OK)
    throw InternalError(Fault{.id = "internal.zlib", .message = fmt::format("compress2 returned {}", status)});
  block.resize(size);
  return block;
}

void append_header_words(std::string& bytes, std::span<const std::uint64_t> words) {
  bytes.append(reinterpret_cast<const char*>(words.data()), words.size_bytes());
}

/// [number of blocks] [size of a block] [size of the last block, 0 if full] [compressed size of each block] [blocks]
template <class T>
void write_array(const VtuArray& array, const VtuArray::Fill<T>& fill, AtomicFile& file) {
  const std::uint64_t values_per_block = kBlockBytes / sizeof(T);
  const std::uint64_t n_blocks = (array.n_values + values_per_block - 1) / values_per_block;
  std::vector<std::uint64_t> header(3 + n_blocks, 0);
  header[0] = n_blocks;
  header[1] = kBlockBytes;
  header[2] = array.n_values % values_per_block * sizeof(T);
  const std::uint64_t header_position = file.position();
  std::string bytes;
  append_header_words(bytes, header);
  file.write(bytes);
  for (std::uint64_t first = 0; first < n_blocks; first += kBlocksInFlight) {
    const std::uint64_t n = std::min(kBlocksInFlight, n_blocks - first);
    std::vector<std::string> blocks(n);
    parallel_for(
        n,
        [&](std::size_t i) {
          const std::uint64_t begin = (first + i) * values_per_block;
          blocks[i] = compress_block(fill, begin, std::min(values_per_block, array.n_values - begin));
        },
        1);
    for (std::uint64_t i = 0; i < n; ++i) {
      file.write(blocks[i]);
      header[3 + first + i] = blocks[i].size();
    }
  }
  bytes.clear();
  append_header_words(bytes, header);
  file.overwrite(header_position, bytes);
}

/// The XML up to the appended data. `offsets` are in the order of all_arrays, or empty while they are not known.
class XmlHead {
 public:
  explicit XmlHead(std::span<const std::uint64_t> offsets) : offsets_(offsets) {}

  std::string make(const VtuGrid& grid) {
    text_ =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\">\n"
        "  <UnstructuredGrid>\n";
    if (!grid.field_data.empty()) add_section("FieldData", grid.field_data, true);
    text_ += fmt::format("    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", grid.n_points, grid.n_cells);
    add_section("PointData", grid.point_data, false);
    add_section("CellData", grid.cell_data, false);
    add_section("Points", std::span(&grid.points, 1), false);
    add_section("Cells", grid.cells, false);
    text_ +=
        "    </Piece>\n"
        "  </UnstructuredGrid>\n"
        "  <AppendedData encoding=\"raw\">\n"
        "   _";
    return std::move(text_);
  }

 private:
  void add_section(std::string_view tag, std::span<const VtuArray> arrays, bool is_field) {
    text_ += fmt::format("      <{}>\n", tag);
    for (const VtuArray& array : arrays) add_array(array, is_field);
    text_ += fmt::format("      </{}>\n", tag);
  }

  void add_array(const VtuArray& array, bool is_field) {
    const char* type = std::visit([]<class T>(const VtuArray::Fill<T>&) { return kTypeName<T>; }, array.fill);
    text_ += fmt::format("        <DataArray type=\"{}\" Name=\"{}\"", type, array.name);
    if (array.n_components > 1) text_ += fmt::format(" NumberOfComponents=\"{}\"", array.n_components);
    if (is_field)
      text_ += fmt::format(" NumberOfTuples=\"{}\"", array.n_values / static_cast<std::uint64_t>(array.n_components));
    const std::string offset = offsets_.empty() ? "0" : std::to_string(offsets_[next_++]);
    // The attribute is padded behind its quotes: some readers compare offsets as text.
    text_ += fmt::format(" format=\"appended\" offset=\"{}\"{}/>\n", offset,
                         std::string(kOffsetDigits - offset.size(), ' '));
  }

  std::span<const std::uint64_t> offsets_;
  std::size_t next_ = 0;
  std::string text_;
};

/// In the order in which XmlHead lists them.
std::vector<const VtuArray*> all_arrays(const VtuGrid& grid) {
  std::vector<const VtuArray*> arrays;
  for (const VtuArray& array : grid.field_data) arrays.push_back(&array);
  for (const VtuArray& array : grid.point_data) arrays.push_back(&array);
  for (const VtuArray& array : grid.cell_data) arrays.push_back(&array);
  arrays.push_back(&grid.points);
  for (const VtuArray& array : grid.cells) arrays.push_back(&array);
  return arrays;
}

}  // namespace

void write_vtu(const VtuGrid& grid, const std::filesystem::path& path) {
  AtomicFile file(path);
  file.write(XmlHead({}).make(grid));
  const std::uint64_t data_position = file.position();
  // The last one first: meshio 5.0 gives arrays other offsets one by one, and takes the first one in the head that has
  // the offset that comes next. So those that it is done with come last there.
  const std::vector<const VtuArray*> arrays = all_arrays(grid);
  std::vector<std::uint64_t> offsets(arrays.size());
  for (std::size_t i = arrays.size(); i-- > 0;) {
    offsets[i] = file.position() - data_position;
    const VtuArray& array = *arrays[i];
    std::visit([&]<class T>(const VtuArray::Fill<T>& fill) { write_array(array, fill, file); }, array.fill);
  }
  file.write("\n  </AppendedData>\n</VTKFile>\n");
  file.overwrite(0, XmlHead(offsets).make(grid));
  file.finish();
  file.rename();
}

}  // namespace voropack::io
