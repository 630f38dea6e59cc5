// Chooses the reader or writer by the extension of the file.
#include "voropack/io.h"

#include <fmt/format.h>

#include "base/number_text.h"
#include "io/atomic_file.h"
#include "io/readers.h"
#include "io/writers.h"

namespace voropack {

namespace {

using io::FileContent;

constexpr const char* kDomainExtensions = ".poly, .smesh, .node, .off, .stl, .obj or .ply";

std::filesystem::path sibling(const std::filesystem::path& path, const char* extension) {
  std::filesystem::path result = path;
  return result.replace_extension(extension);
}

AnyMesh read_node_files(const std::filesystem::path& path, Observer& observer, FaultySimplices faulty) {
  const FileContent node = io::read_file(path);
  const std::filesystem::path ele_path = sibling(path, ".ele");
  const std::optional<FileContent> ele = io::read_file_if_present(ele_path);
  if (!ele)
    io::fail(ele_path.string(), "io.cannot_open", "cannot be read: a mesh in .node needs its simplices in this file",
             "put the .ele file beside the .node file");
  const std::optional<FileContent> face = io::read_file_if_present(sibling(path, ".face"));
  const std::optional<FileContent> edge = io::read_file_if_present(sibling(path, ".edge"));
  io::NodeMeshSources sources{node.source(), ele->source(), {}, {}, {}};
  if (face) sources.face = face->source();
  if (edge) sources.edge = edge->source();
  std::optional<FileContent> poly;
  if (!edge) poly = io::read_file_if_present(sibling(path, ".poly"));
  if (poly) sources.poly = poly->source();
  return io::parse_node_mesh(sources, observer, faulty);
}

}  // namespace

AnyDomainInput read_domain(const std::filesystem::path& path, Observer& observer) {
  const std::string extension = io::lower_extension(path);
  const auto parse = [&]() -> AnyDomainInput {
    const FileContent content = io::read_file(path);
    const io::NodeFileOpener open_node = [&] { return io::read_file(sibling(path, ".node")); };
    if (extension == ".poly") return io::parse_poly(content.source(), open_node, observer);
    if (extension == ".smesh") return io::parse_smesh(content.source(), open_node, observer);
    if (extension == ".node") return io::parse_node_domain(content.source(), observer);
    if (extension == ".off") return io::parse_off(content.source(), observer);
    if (extension == ".stl") return io::parse_stl(content.source(), observer);
    if (extension == ".obj") return io::parse_obj(content.source(), observer);
    if (extension == ".ply") return io::parse_ply(content.source(), observer);
    io::fail(content.file, "io.unknown_format",
             fmt::format("domains with the extension {} are not known", io::quote(extension)),
             fmt::format("give the domain as {}", kDomainExtensions));
  };
  return parse();
}

AnyMesh read_mesh(const std::filesystem::path& path, Observer& observer, FaultySimplices faulty) {
  const std::string extension = io::lower_extension(path);
  if (extension == ".node") return read_node_files(path, observer, faulty);
  const FileContent content = io::read_file(path);
  if (extension == ".vtu") return io::parse_vtu(content.source(), observer, faulty);
  io::fail(content.file, "io.unknown_format",
           fmt::format("meshes with the extension {} are not known", io::quote(extension)),
           "give the mesh as .node with .ele beside it, or as .vtu");
}

std::vector<double> read_point_array(const std::filesystem::path& path, const std::string& name, Observer& observer) {
  const FileContent content = io::read_file(path);
  if (io::lower_extension(path) != ".vtu")
    io::fail(content.file, "io.unknown_format", "only .vtu files have arrays with names", "give a .vtu file");
  return io::parse_vtu_point_array(content.source(), name, observer);
}

template <int D>
void write_mesh(const Mesh<D>& mesh, const std::filesystem::path& path, const MeshArrays& arrays) {
  const std::string extension = io::lower_extension(path);
  if (extension == ".vtu") return io::write_vtu_mesh(mesh, path, arrays);
  if (extension == ".node") return io::write_node_mesh(mesh, path, arrays);
  throw OptionError(Fault{.id = "io.unknown_format",
                          .message = fmt::format("no mesh format has the extension {}", io::quote(extension)),
                          .fix = "end the name with .node or .vtu",
                          .file = path.string()});
}

void write_matrix_market(std::span<const std::uint64_t> offsets, std::span<const std::uint32_t> columns,
                         std::span<const double> values, std::size_t n_columns, const std::filesystem::path& path) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 18U;
  io::AtomicFile file(path);
  std::string text = "%%MatrixMarket matrix coordinate real general\n";
  text += fmt::format("{} {} {}\n", offsets.size() - 1, n_columns, values.size());
  for (std::size_t row = 0; row + 1 < offsets.size(); ++row) {
    for (std::uint64_t k = offsets[row]; k < offsets[row + 1]; ++k) {
      append_number(text, row + 1);
      text += ' ';
      append_number(text, columns[k] + std::uint64_t{1});
      text += ' ';
      append_number(text, values[k]);
      text += '\n';
    }
    if (text.size() < kPieceBytes) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.finish();
  file.rename();
}

void write_text(const std::string& text, const std::filesystem::path& path) {
  io::AtomicFile file(path);
  file.write(text);
  file.finish();
  file.rename();
}

template void write_mesh<2>(const Mesh<2>&, const std::filesystem::path&, const MeshArrays&);
template void write_mesh<3>(const Mesh<3>&, const std::filesystem::path&, const MeshArrays&);

}  // namespace voropack
