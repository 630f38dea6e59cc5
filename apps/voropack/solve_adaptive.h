// Solving a case on meshes made to measure: solve, estimate the error, mesh again where it is large.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "exit_code.h"
#include "meshing.h"
#include "solve_case.h"
#include "voropack/adaptivity.h"
#include "voropack/domain.h"
#include "voropack/error.h"

namespace voropack::app {

struct AdaptiveWishes {
  enum class Keep : std::uint8_t { kNone, kFitting, kAll };
  bool is_wished = false;
  std::optional<double> tolerance;  ///< On the estimated error in the W norm.
  std::optional<std::uint64_t> max_vertices;
  int max_cycles = 8;
  double growth = 2.5;  ///< Vertices of a mesh over those of the one before, at most.
  Keep keep = Keep::kNone;
  std::string field;  ///< FILE:array that takes the place of the solution. Empty: the solution.

  /// FILE of `field`. Throws OptionError cli.bad_field.
  [[nodiscard]] std::optional<std::filesystem::path> field_file() const;
};

/// --adapt and what belongs to it.
void add_adaptive_options(CLI::App& command, AdaptiveWishes& wishes);

/// The options as the report lists them.
Json options_json(const AdaptiveWishes& wishes);

/// What a case has to be for that. Throws OptionError cli.contradiction, cli.missing.
void check_adaptive(const AdaptiveWishes& wishes, const Case& given);

/// A limit of meshing with the option --max-vertices of `mesh` under the name it has in a case, where --max-vertices
/// ends an adaptive run.
LimitError in_words_of_case(const LimitError& error);

/// One solution on the way: its ErrorEstimate, and what it cost.
struct AdaptiveCycle {
  std::uint64_t n_vertices = 0;
  double estimate = 0, smooth = 0, rough = 0, truncation = 0;
  std::optional<double> error{};  ///< In the W norm, if the exact solution is known.
  std::optional<std::uint64_t> n_kept{};
  /// Most of the estimate is of what derivatives explain.
  [[nodiscard]] bool is_resolved() const { return smooth > rough; }
  bool is_trusted = true;              ///< There are enough vertices inside for an estimate.
  std::optional<bool> is_certified{};  ///< Unknown of a mesh that the user brought.
  double seconds = 0;                  ///< To mesh, solve and estimate.
};

/// Why there are no more meshes. docs/case.md has their names in the report.
enum class AdaptiveEnd : std::uint8_t {
  kTolerance,
  kNoError,  ///< Nothing is left to be estimated.
  kMaxVertices,
  kMaxCycles,
  kNoFinerMesh,
  kField,           ///< There is a mesh that follows the field.
  kNoMeshForField,  ///< With so few vertices there is none.
  kNotCertified,    ///< The next mesh is not.
  kLimit,           ///< The next mesh met one.
  kNotConverged,    ///< The solution on the next mesh has not.
};

struct AdaptiveFigures {
  std::vector<AdaptiveCycle> cycles;
  AdaptiveEnd end = AdaptiveEnd::kMaxCycles;
  std::string reason;                      ///< The message of what failed, if that is why.
  std::vector<std::string> not_estimated;  ///< What the case has that estimates do not see.
};

/// What a case has that `estimate_error` leaves out, in words.
std::vector<std::string> left_out_of_estimate(const Case& given);
std::string adaptive_table(const AdaptiveFigures& figures);
Json adaptive_json(const AdaptiveFigures& figures);
/// A tolerance that was asked for and not met is no convergence, whatever it was that ended the run.
ExitCode adaptive_exit_code(const AdaptiveFigures& figures, const AdaptiveWishes& wishes);

/// Solves on the mesh of `setting`, which is of `domain`, and on meshes that take its place there, until one of the
/// wishes is met. What is reported of a mesh is that of the last one. on_cycle is called after each solution.
template <int D>
Solved<D> solve_adaptively(Setting<D>& setting, const Domain<D>& domain, const AdaptiveWishes& wishes,
                           const std::function<void(std::size_t cycle, const SolutionArrays<D>&)>& on_cycle,
                           AdaptiveFigures& figures, Report& report, Session& session);

}  // namespace voropack::app
