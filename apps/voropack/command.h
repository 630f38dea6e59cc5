// What the subcommands share: how one is declared, and what it has at hand when it runs.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <variant>

#include "exit_code.h"
#include "output_set.h"
#include "parameters.h"
#include "report.h"
#include "terminal_observer.h"
#include "voropack/io.h"

namespace voropack::app {

/// What a running command has at hand.
struct Session {
  const CommonOptions& common;
  OutputSet& outputs;
  TerminalObserver& observer;
  std::chrono::steady_clock::time_point start;
  std::filesystem::path staged_report;  ///< Where the report is written before it appears. Empty without --report.

  /// Completes `report`, prints `text` to standard output, and lets the outputs appear.
  void finish(Report& report, const std::string& text);
};

using Run = std::function<ExitCode(Session&)>;

/// A subcommand declares its options on a CLI::App of its own and returns what to run once they are parsed.
struct Command {
  CLI::App* app = nullptr;
  Run run;
};

Command add_mesh_command(CLI::App& root, CommonOptions& common);
Command add_check_command(CLI::App& root, CommonOptions& common);
Command add_stats_command(CLI::App& root, CommonOptions& common);
Command add_refine_command(CLI::App& root, CommonOptions& common);
Command add_coarsen_command(CLI::App& root, CommonOptions& common);
Command add_convert_command(CLI::App& root, CommonOptions& common);
Command add_plot_command(CLI::App& root, CommonOptions& common);
Command add_solve_command(CLI::App& root, CommonOptions& common);
Command add_paper_command(CLI::App& root, CommonOptions& common);
// Further figures of the subcommand `paper`, which is added first.
Command add_figure5_command(CLI::App& root, CommonOptions& common);
Command add_figure8_command(CLI::App& root, CommonOptions& common);

/// --redelaunay of the commands that read a mesh.
void add_redelaunay_option(CLI::App& app, bool& redelaunay);

/// Reads a mesh; with `redelaunay`, triangulates its vertices anew and keeps its regions and markers.
AnyMesh read_mesh_or_triangulate(const std::filesystem::path& path, bool redelaunay, Observer& observer);

/// The threads that a run uses: `wanted`, or as many as the machine has.
int thread_count(int wanted);

/// Runs `work` and adds its wall-clock seconds to `times[name]`.
template <class Work>
auto timed(StageTimes& times, const char* name, Work&& work) {
  struct Timer {
    double& seconds;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Timer() { seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
  } timer{times[name]};
  return work();
}

/// The dimension of a domain input, a mesh or any other class template over it.
template <template <int> class T, int D>
constexpr int dimension_of(const T<D>&) {
  return D;
}

}  // namespace voropack::app
