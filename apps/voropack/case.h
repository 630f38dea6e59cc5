// What a case file says: mesh or domain, equation, conditions, solvers, outputs. docs/case.md describes the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "case_file.h"
#include "meshing.h"
#include "voropack/linear_system.h"
#include "voropack/nonlinear.h"
#include "voropack/transient.h"

namespace voropack::app {

/// A number, or the text of a formula in x, y, z, t and u.
struct CaseFormula {
  std::variant<double, std::string> value = 0.0;
  std::string name;  ///< Such as "equation.source".
  CasePlace place;
};

/// An array of point data of a .vtu file.
struct CaseArray {
  std::string name;
  std::optional<std::filesystem::path> file;  ///< The mesh's own if absent.
  /// How values come from another mesh of the domain.
  enum class Transfer : std::uint8_t { kNone, kInterpolate, kConserve };
  Transfer transfer = Transfer::kNone;
};

/// A coefficient: one for all regions, one for each, or an array.
struct CaseCoefficient {
  std::variant<CaseFormula, std::map<int, CaseFormula>, CaseArray> value;
  std::string name;
  CasePlace place;
};

struct CaseCondition {
  enum class Type : std::uint8_t { kDirichlet, kNeumann, kRobin, kRate };
  Type type = Type::kDirichlet;
  CaseFormula value;     ///< Dirichlet: u. Neumann: the inflow. Robin: u outside. Rate: the total.
  CaseFormula transfer;  ///< Robin.
  CasePlace place;
};

struct CaseTime {
  TimeOptions options;
  CaseCoefficient initial;
};

struct CaseExact {
  CaseFormula u;
  std::vector<CaseFormula> gradient;  ///< Empty: that of u.
};

enum class CasePreconditioner : std::uint8_t {
  kAutomatic,  ///< Multigrid for large systems; else incomplete Cholesky, with finite elements diagonal.
  kMultigrid,
  kIncompleteCholesky,
  kDiagonal,
};

enum class CaseMethod : std::uint8_t { kControlVolumes, kFiniteElements };

struct CaseOutputs {
  std::vector<std::filesystem::path> meshes;  ///< .vtu with the array u at points.
  std::optional<std::filesystem::path> cells;
  std::optional<std::filesystem::path> fluxes;  ///< .csv
  std::optional<double> every;                  ///< Time between states of a series; without it the end alone.
};

struct Case {
  std::filesystem::path file;
  CaseMethod method = CaseMethod::kControlVolumes;

  std::optional<std::filesystem::path> mesh;  ///< Either this or `domain`.
  std::optional<std::filesystem::path> domain;
  MeshingWishes wishes;

  CaseCoefficient conductivity, reaction, source, capacity;
  std::optional<double> mean;
  std::map<int, CaseCondition> conditions;
  std::optional<CaseCondition> other_conditions;  ///< Of markers of the hull that `conditions` does not list.
  std::optional<CaseExact> exact;

  std::optional<CaseTime> time;  ///< Absent: stationary.
  NewtonOptions newton;          ///< Its `linear` holds for linear problems as well.
  std::optional<CaseCoefficient> newton_initial;
  CasePreconditioner preconditioner = CasePreconditioner::kAutomatic;
  std::vector<std::filesystem::path> levels;  ///< Coarser meshes for multigrid, the finest first; none: it makes them.
  CaseOutputs outputs;
};

/// Reads and checks what can be checked without the mesh. Throws InputError with every fault found: case.syntax,
/// case.unknown_key, case.unknown_name, case.wrong_type, case.missing_key, case.contradiction.
Case read_case(const std::filesystem::path& path);

// Parts of it.
CaseFormula take_formula(CaseTable& table, const std::string& key, double otherwise);
CaseCoefficient take_coefficient(CaseTable& table, const std::string& key, double otherwise);
void read_conditions(CaseTable& file, Case& result);

/// The whole number that a key is, or a fault.
std::optional<int> id_of_key(const CaseTable& table, const std::string& key, const std::string& what);

}  // namespace voropack::app
