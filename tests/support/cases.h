// The domains that tests of the whole mesher run over, with what is known about each.
#pragma once

#include <string>
#include <vector>

#include "support/domains.h"
#include "voropack/pipeline.h"

namespace voropack::test {

template <int D>
struct Case {
  std::string name;
  DomainInput<D> input;
  double measure;                    ///< Area or volume of the whole.
  std::vector<double> regions = {};  ///< Of each region, ascending by id; empty: one region.
  double min_angle_deg = 60;
};

/// Every kind of polytope and of neighborhood: corners of all signs, holes, interfaces, polytopes inside regions.
template <int D>
std::vector<Case<D>> all_cases() {
  namespace d = domains;
  std::vector<Case<D>> cases = {
      {"unit_box", d::unit_box<D>(), 1},
      {"box_with_hole", d::box_with_hole<D>(), D == 2 ? 8.0 : 26.0},
      {"l_shape", d::l_shape<D>(), 3},
      {"two_material_box", d::two_material_box<D>(), 2, {1, 1}},
      {"box_with_internal_wall", d::box_with_internal_wall<D>(), 1},
      {"box_with_dangling_segment", d::box_with_dangling_segment<D>(), 1},
      {"box_with_isolated_point", d::box_with_isolated_point<D>(), 1},
      {"regular_simplex", d::regular_simplex<D>(), D == 2 ? std::sqrt(3.0) / 4 : 1 / std::sqrt(72.0), {}, 50},
  };
  if constexpr (D == 3) {
    cases.push_back({"box_with_through_hole", d::box_with_through_hole(), 24});
    cases.push_back({"box_with_marked_facet", d::box_with_marked_facet(), 1});
    cases.push_back({"tessellated_cube", d::tessellated_cube(2), 1});
  }
  return cases;
}

/// A mesh with edges of about this length.
template <int D>
Mesh<D> mesh_of(const DomainInput<D>& input, double size, Interior interior = Interior::kLattice) {
  MeshingOptions<D> options;
  options.wishes.size = size;
  options.packing.interior = interior;
  return make_mesh(input, options).mesh;
}

/// One way to fill a domain.
struct Filling {
  std::string name;
  PackingForm form;
  Interior interior;
};

inline std::vector<Filling> all_fillings() {
  return {{"lattice", PackingForm::kVoronoi, Interior::kLattice},
          {"random", PackingForm::kVoronoi, Interior::kRandom},
          {"maximal", PackingForm::kMaximal, Interior::kRandom},
          {"filtered", PackingForm::kFiltered, Interior::kRandom}};
}

template <int D>
MeshingOptions<D> meshing_options(const Filling& filling, std::optional<double> size = {}) {
  MeshingOptions<D> options;
  options.packing.form = filling.form;
  options.packing.interior = filling.interior;
  options.wishes.size = size;
  return options;
}

/// The spacing function with which `make_mesh` made this result, its repairs included.
template <int D>
Spacing<D> spacing_of(const MeshingResult<D>& result, const MeshingOptions<D>& options, double edge_per_spacing = 3) {
  const SpacingOptions how{options.gradation, options.feature_factor, edge_per_spacing};
  return build_spacing(result.domain, options.wishes, how).with_caps(result.repairs);
}

}  // namespace voropack::test
