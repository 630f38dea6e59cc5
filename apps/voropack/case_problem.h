// A case's formulas, compiled for meshes of dimension D, and the diffusion problem that they make up.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "case.h"
#include "voropack/boundary_areas.h"
#include "voropack/diffusion.h"
#include "voropack/dual.h"
#include "voropack/expression.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack::app {

/// What a formula may depend on beside the position.
struct FormulaScope {
  bool time = false, state = false;
};

/// A number, or a compiled formula in x, y, (z,) t and u. Safe to call from many threads.
template <int D>
class CompiledFormula {
 public:
  CompiledFormula() = default;
  /// A formula that does not parse becomes 0 and a fault.
  CompiledFormula(const CaseFormula& formula, FormulaScope scope, CaseFaults& faults);

  [[nodiscard]] double value(const Vec<D>& x, double t, double u = 0) const;
  /// At many points at once, which is faster.
  void values(std::span<const Vec<D>> x, double t, std::span<double> results) const;
  void gradients(std::span<const Vec<D>> x, double t, std::span<Vec<D>> results) const;
  [[nodiscard]] double derivative_by_u(const Vec<D>& x, double t, double u) const;
  [[nodiscard]] bool is_formula() const { return formula_ != nullptr; }
  [[nodiscard]] bool is_number() const { return formula_ == nullptr; }
  [[nodiscard]] bool uses_position() const;
  [[nodiscard]] bool uses_time() const { return formula_ != nullptr && formula_->uses(D); }
  [[nodiscard]] bool uses_state() const { return formula_ != nullptr && formula_->uses(D + 1); }
  [[nodiscard]] double number() const { return number_; }

 private:
  double number_ = 0;
  std::shared_ptr<const Expression> formula_;
};

template <int D>
using CompiledCoefficient =
    std::variant<CompiledFormula<D>, std::map<int, CompiledFormula<D>>, IdVector<VertexId, double>>;

/// Whether some formula of the coefficient has the property.
template <int D>
bool any_formula(const CompiledCoefficient<D>& coefficient, bool (CompiledFormula<D>::*property)() const);

template <int D>
struct CompiledCondition {
  CaseCondition::Type type = CaseCondition::Type::kDirichlet;
  CompiledFormula<D> value, transfer;
};

template <int D>
struct CompiledCase {
  CompiledCoefficient<D> conductivity, reaction, source, capacity, initial, newton_initial;
  std::map<int, CompiledCondition<D>> conditions;
  std::optional<CompiledCondition<D>> other_conditions;
  std::optional<double> mean;
  std::optional<CompiledFormula<D>> exact;
  std::vector<CompiledFormula<D>> exact_gradient;  ///< Empty: that of `exact`.
  bool is_nonlinear = false;                       ///< Conductivity or source depends on u.
};

/// Compiles what needs no mesh. Throws InputError case.formula, ..., with every fault found.
template <int D>
CompiledCase<D> compile_case(const Case& given);

/// Reads arrays, compares regions and markers with those of the mesh, and builds the boundary: afterwards `conditions`
/// has an entry for every marker that has a condition. Throws InputError case.unknown_marker, case.unknown_region,
/// case.wrong_length.
template <int D>
BoundaryAreas<D> bind_case(const Case& given, const Mesh<D>& mesh, CompiledCase<D>& compiled, Observer& observer);

/// The problem at a time; `source_integrals` are for the caller to add.
template <int D>
DiffusionProblem<D> make_problem(const CompiledCase<D>& compiled, double time);

/// A coefficient at a time, for the solver.
template <int D>
Coefficient<D> to_coefficient(const CompiledCoefficient<D>& compiled, double time);

/// The values of a coefficient that does not differ by region.
template <int D>
IdVector<VertexId, double> vertex_values(const CompiledCoefficient<D>& compiled, const Mesh<D>& mesh);

/// The integral of the source over each cell where that is more than volume times value at the site.
template <int D>
std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<D>& compiled, const CellShapes<D>& shapes,
                                                         const ControlVolumes<D>& volumes, double time);

/// The exact solution and its gradient at many points, as `norms` wants them.
template <int D>
std::function<void(std::span<const Vec<D>>, std::span<double>)> exact_solution(const CompiledCase<D>& compiled,
                                                                               double time);
template <int D>
std::function<void(std::span<const Vec<D>>, std::span<Vec<D>>)> exact_gradient(const CompiledCase<D>& compiled,
                                                                               double time);

}  // namespace voropack::app
