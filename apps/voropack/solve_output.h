// The files that the command solve writes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "case.h"
#include "output_set.h"
#include "solve_case.h"

namespace voropack::app {

/// The files of a run, in their hidden places. A series is a .pvd file, with the .vtu files of its states beside it.
struct StagedSolution {
  std::vector<std::filesystem::path> names;  ///< As the user knows them.
  std::vector<std::filesystem::path> meshes;
  std::optional<std::filesystem::path> cells, fluxes;
  bool is_series = false;
  std::set<std::size_t> earlier;  ///< Numbers of the states that an earlier series left under these names.

  /// Which of those go when a series of so many states appears, as a line for the user; or nothing.
  [[nodiscard]] std::string stale_line(std::size_t n_states) const;
};

/// A series takes the place of an earlier one of the same name with all its states.
/// Throws OptionError io.unknown_format, and as OutputSet::stage and OutputSet::replace.
StagedSolution stage(const CaseOutputs& outputs, bool is_series, OutputSet& set);

/// Writes states of the solution on the mesh (point arrays `u` and, with an exact solution, `error`) and on the control
/// volumes (cell arrays of the same names).
template <int D>
class SolutionWriter {
 public:
  SolutionWriter(const Setting<D>& setting, const StagedSolution& staged) : setting_(setting), staged_(staged) {}
  void add(double time, const SolutionArrays<D>& arrays);
  /// Of a series, writes the list of its files.
  void finish() const;
  [[nodiscard]] std::size_t n_states() const { return times_.size(); }

 private:
  /// Where the next state of an output goes.
  [[nodiscard]] std::filesystem::path place(const std::filesystem::path& staged) const;

  const Setting<D>& setting_;
  const StagedSolution& staged_;
  std::vector<double> times_;
};

}  // namespace voropack::app
