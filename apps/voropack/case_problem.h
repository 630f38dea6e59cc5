// A case's formulas, compiled for meshes of dimension D, and the diffusion problem that they make up.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <variant>
#include <vector>

#include "case.h"
#include "voropack/diffusion.h"
#include "voropack/dual.h"
#include "voropack/expression.h"
#include "voropack/mesh.h"
#include "voropack/observer.h"

namespace voropack::app {

/// A number, or a compiled formula. Safe to call from many threads.
template <int D>
class CompiledFormula {
 public:
  CompiledFormula() = default;
  /// A formula that does not parse becomes 0 and a fault.
  CompiledFormula(const CaseFormula& formula, CaseFaults& faults);

  double operator()(const Vec<D>& x) const;
  [[nodiscard]] Vec<D> gradient(const Vec<D>& x) const;
  [[nodiscard]] bool is_number() const { return formula_ == nullptr; }
  [[nodiscard]] double number() const { return number_; }

 private:
  double number_ = 0;
  std::shared_ptr<const Expression> formula_;
};

template <int D>
using CompiledCoefficient =
    std::variant<CompiledFormula<D>, std::map<int, CompiledFormula<D>>, IdVector<VertexId, double>>;

template <int D>
struct CompiledCondition {
  CaseCondition::Type type = CaseCondition::Type::kDirichlet;
  CompiledFormula<D> value, transfer;
};

template <int D>
struct CompiledCase {
  CompiledCoefficient<D> conductivity, reaction, source;
  std::map<int, CompiledCondition<D>> conditions;
  std::optional<CompiledCondition<D>> other_conditions;
  std::optional<double> mean;
  std::optional<CompiledFormula<D>> exact;
  std::vector<CompiledFormula<D>> exact_gradient;  ///< Empty: that of `exact`.
};

/// Compiles what needs no mesh. Throws InputError case.formula, ..., with every fault found.
template <int D>
CompiledCase<D> compile_case(const Case& given);

/// Reads arrays and compares regions and markers with those of the mesh: afterwards `conditions` has an entry for every
/// marker that has a condition. Throws InputError case.unknown_marker, case.unknown_region, case.wrong_length.
template <int D>
void bind_case(const Case& given, const Mesh<D>& mesh, const std::set<int>& hull_markers, CompiledCase<D>& compiled,
               Observer& observer);

/// The problem; `source_integrals` are for the caller to add.
template <int D>
DiffusionProblem<D> make_problem(const CompiledCase<D>& compiled);

/// The integral of the source over each cell where that is more than volume times value at the site.
template <int D>
std::optional<IdVector<CellId, double>> integrate_source(const CompiledCase<D>& compiled, const CellShapes<D>& shapes,
                                                         const ControlVolumes<D>& volumes);

/// The exact solution and its gradient, as `norms` wants them.
template <int D>
std::function<double(const Vec<D>&)> exact_solution(const CompiledCase<D>& compiled);
template <int D>
std::function<Vec<D>(const Vec<D>&)> exact_gradient(const CompiledCase<D>& compiled);

}  // namespace voropack::app
