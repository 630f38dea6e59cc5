// The program voropack: parse, run one command, choose the exit code.
#include <fmt/format.h>
#include <malloc.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "interrupt.h"
#include "suggest.h"
#include "version.h"
#include "voropack/error.h"

namespace {

using namespace voropack::app;

constexpr int kSignalExitBase = 128;  // As shells report a process that a signal ended.

int exit_number(ExitCode code) {
  const int signal = interrupt_signal();
  return code == ExitCode::kInterrupted && signal != 0 ? kSignalExitBase + signal : static_cast<int>(code);
}

int fail(const Failure& failure) {
  fmt::print(stderr, "voropack: error: {}\n", failure.message);
  return exit_number(failure.code);
}

std::string version_text() {
  return commit().empty() ? fmt::format("voropack {}", version())
                          : fmt::format("voropack {} ({})", version(), commit());
}

/// Has freed memory kept for the next stage. To return it to the system and to ask for zeroed pages again is work of
/// the system that no second thread shares.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

/// Runs `command` in a session of its own. Whatever it staged is gone when this returns.
int run(const Command& command, const CommonOptions& common, std::chrono::steady_clock::time_point start) {
  OutputSet outputs;
  const auto give_up = [&outputs] {
    outputs.abandon();
    fmt::print(stderr, "voropack: error: interrupted; nothing was written\n");
    _exit(exit_number(ExitCode::kInterrupted));
  };
  try {
    TerminalObserver observer(common.verbosity, give_up);
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(thread_count(common.threads)));
    Session session{common, outputs, observer, start, {}};
    if (common.report) session.staged_report = outputs.stage(*common.report);
    return exit_number(command.run(session));
  } catch (const std::exception& error) {
    Failure failure = explain(error);
    failure.message = outputs.in_users_words(std::move(failure.message));
    outputs.abandon();
    return fail(failure);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto start = std::chrono::steady_clock::now();
  keep_freed_memory();
  catch_interrupts();

  CLI::App root("Boundary-conforming Delaunay meshes and Voronoi control volumes by sphere packing", "voropack");
  root.set_version_flag("--version", version_text());
  root.require_subcommand(1);
  root.get_formatter()->column_width(34);
  root.footer(
      "Exit codes: 0 done, 1 the certificate or a check failed, 2 bad input or option, 3 a limit (vertices, memory,\n"
      "time), 4 no convergence, 70 a fault of ours, 130 interrupted.\n"
      "Example: voropack mesh part.poly -o part.vtu --size 0.1");
  CommonOptions common;
  std::vector<Command> commands;
  for (const auto add : {add_mesh_command, add_check_command, add_stats_command, add_refine_command,
                         add_coarsen_command, add_convert_command, add_plot_command, add_solve_command,
                         add_paper_command, add_figure5_command, add_figure8_command})
    commands.push_back(add(root, common));

  try {
    check_names(root, {argv + 1, argv + argc});
    root.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help and --version
    return root.exit(request);
  } catch (const CLI::ExtrasError&) {
    return fail(explain(unexpected_arguments(root)));
  } catch (const CLI::ParseError& error) {
    std::string help = "voropack";
    for (const CLI::App* app = &root; !app->get_subcommands().empty(); help += ' ' + app->get_name())
      app = app->get_subcommands().front();
    fmt::print(stderr, "voropack: error: {}\n  Fix: see {} --help.\n", error.what(), help);
    return static_cast<int>(ExitCode::kInput);
  } catch (const std::exception& error) {
    return fail(explain(error));
  }

  for (const Command& command : commands)
    if (command.app->parsed()) return run(command, common, start);
  return static_cast<int>(ExitCode::kInternal);
}
