#include "command.h"

#include <tbb/info.h>

#include "interrupt.h"
#include "print.h"
#include "voropack/delaunay.h"
#include "voropack/error.h"

namespace voropack::app {

void add_redelaunay_option(CLI::App& app, bool& redelaunay) {
  app.add_flag("--redelaunay", redelaunay,
               "Triangulate the mesh's vertices anew: flat simplices go away, regions and markers\n"
               "stay, or the mesh is refused");
}

AnyMesh read_mesh_or_triangulate(const std::filesystem::path& path, bool redelaunay, Observer& observer) {
  if (!redelaunay) return read_mesh(path, observer);
  return std::visit([&](const auto& mesh) { return AnyMesh(retriangulate(mesh, observer)); },
                    read_mesh(path, observer, FaultySimplices::kAccept));
}

int thread_count(int wanted) { return wanted > 0 ? wanted : tbb::info::default_concurrency(); }

void Session::finish(Report& report, const std::string& text) {
  observer.finish();
  report.threads = thread_count(common.threads);
  report.times["total"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (common.report) write_text(to_json(report).dump(2) + '\n', staged_report);
  if (!common.verbosity.quiet) print_to_stdout(text);
  // The last moment to stop: what follows is a few renames.
  observer.check_cancelled();
  outputs.publish();
}

}  // namespace voropack::app
