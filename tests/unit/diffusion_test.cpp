// The control volume method on problems that are worked out by hand, and what it refuses.
#include "voropack/diffusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "support/faults.h"
#include "support/strip_volumes.h"

namespace voropack {
namespace {

using test::fault_of;
using test::Strip;
using test::strip;

const VertexId v0(0), v1(1), v2(2);
constexpr double kRounding = 1e-14;

DiffusionProblem<2> between(double left, double right) {
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Dirichlet<2>{left}}, {2, Dirichlet<2>{right}}};
  return problem;
}

TEST(Diffusion, ConductsBetweenTwoEnds) {
  const Strip s = strip(3);
  const auto u = solve(s.volumes, s.boundary, between(0, 2));
  EXPECT_NEAR(u.values[v1], 1, kRounding);
  ASSERT_EQ(u.fluxes.size(), 2U);
  EXPECT_NEAR(u.fluxes[0].inflow, -1, kRounding);
  EXPECT_NEAR(u.fluxes[1].inflow, 1, kRounding);
  EXPECT_TRUE(u.matrix.is_m_matrix);
  EXPECT_EQ(u.linear.n_unknowns, 1U);
}

TEST(Diffusion, MaterialsInSeriesShareTheFlux) {
  const Strip s = strip(3, 1);
  DiffusionProblem<2> problem = between(0, 4);
  problem.conductivity = std::map<int, double>{{1, 1.0}, {2, 3.0}};
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_NEAR(u.values[v1], 3, kRounding);  // 1 (u - 0) = 3 (4 - u)
  EXPECT_NEAR(u.fluxes[1].inflow, 3, kRounding);
  ASSERT_EQ(u.balances.size(), 2U);
  EXPECT_NEAR(u.balances[0].interface_inflow, 3, kRounding);
  EXPECT_NEAR(u.balances[1].interface_inflow, -3, kRounding);
  EXPECT_NEAR(u.balances[0].boundary_inflow, -3, kRounding);
}

TEST(Diffusion, VaryingConductivityTakesTheHarmonicMean) {
  const Strip s = strip(2);
  DiffusionProblem<2> problem = between(0, 1);
  problem.conductivity = IdVector<VertexId, double>(std::vector<double>{1, 3});
  EXPECT_NEAR(assemble(s.volumes, s.boundary, problem).matrix.values[0], 1.5, kRounding);
  problem.conductivity = [](const Vec<2>& x, int) { return 1 + 2 * x[0]; };
  EXPECT_NEAR(solve(s.volumes, s.boundary, problem).fluxes[1].inflow, 1.5, kRounding);
}

TEST(Diffusion, SourceAndReactionActOnVolumes) {
  // Cells 1/2, 1, 1/2 without conditions: u = f / sigma.
  const Strip s = strip(3);
  DiffusionProblem<2> problem;
  problem.reaction = 2.0;
  problem.source = 6.0;
  const auto u = solve(s.volumes, s.boundary, problem);
  for (const double value : u.values) EXPECT_NEAR(value, 3, kRounding);
  EXPECT_NEAR(u.balances[0].source, 12, kRounding);
  EXPECT_NEAR(u.balances[0].absorbed, 12, 10 * kRounding);
  // The same source by its integrals, twice as much in the first cell: u differs there, the sum shows it.
  problem.source_integrals = IdVector<CellId, double>(std::vector<double>{6, 6, 3});
  EXPECT_NEAR(solve(s.volumes, s.boundary, problem).balances[0].source, 15, kRounding);
}

TEST(Diffusion, RobinTransfersFromOutside) {
  // 2 (10 - u0) = u0 - u1 and u1 = 0 at the right end: u0 = 20/3.
  const Strip s = strip(2);
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Robin<2>{2.0, 10.0}}, {2, Dirichlet<2>{0.0}}};
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_NEAR(u.values[v0], 20.0 / 3, 10 * kRounding);
  EXPECT_NEAR(u.fluxes[0].inflow, 20.0 / 3, 10 * kRounding);
}

TEST(Diffusion, NeumannInflowLeavesThroughTheOtherEnd) {
  const Strip s = strip(3);
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Neumann<2>{5.0}}, {2, Dirichlet<2>{1.0}}};
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_NEAR(u.values[v0], 11, 10 * kRounding);
  EXPECT_NEAR(u.fluxes[1].inflow, -5, 10 * kRounding);
}

TEST(Diffusion, PureNeumannTakesTheMean) {
  const Strip s = strip(3);
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Neumann<2>{1.0}}, {2, Neumann<2>{-1.0}}};
  problem.mean = 7;
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_NEAR(u.values[v0], 8, 10 * kRounding);
  EXPECT_NEAR(u.values[v1], 7, 10 * kRounding);
  EXPECT_NEAR(u.values[v2], 6, 10 * kRounding);
  EXPECT_EQ(u.compensation, 0);
  EXPECT_FALSE(solve(s.volumes, s.boundary, between(0, 1)).linear.residuals.empty());
}

TEST(Diffusion, SmallGainsOfPureNeumannAreSpreadOverTheVolume) {
  const Strip s = strip(3);
  DiffusionProblem<2> problem;
  problem.conditions = {{1, Neumann<2>{1.0}}, {2, Neumann<2>{-0.999}}};
  problem.mean = 0;
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_NEAR(u.compensation, 0.001, kRounding);
  EXPECT_NEAR(u.balances[0].source, -0.001, kRounding);
  EXPECT_NEAR(u.balances[0].imbalance, 0, kRounding);
}

TEST(Diffusion, TheSmallestMarkerWinsWhereDirichletValuesDiffer) {
  Strip s = strip(2);
  s.boundary.patch_vertex.push_back(v1);
  s.boundary.patch_marker.push_back(3);
  s.boundary.patch_region.push_back(1);
  s.boundary.patch_area.push_back(3);
  s.boundary.patch_centroid.push_back(s.volumes.sites[v1]);
  DiffusionProblem<2> problem = between(0, 4);
  problem.conditions[3] = Dirichlet<2>{9.0};
  const auto u = solve(s.volumes, s.boundary, problem);
  EXPECT_EQ(u.values[v1], 4);
  EXPECT_NEAR(u.fluxes[1].inflow, 1, kRounding);  // In proportion to areas.
  EXPECT_NEAR(u.fluxes[2].inflow, 3, kRounding);
}

TEST(Diffusion, RefusesAMarkerThatNoBoundaryHas) {
  const Strip s = strip(2);
  DiffusionProblem<2> problem = between(0, 1);
  problem.conditions[4] = Dirichlet<2>{0.0};
  const Fault fault = fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); });
  EXPECT_EQ(fault.id, "solve.unknown_marker");
  EXPECT_NE(fault.message.find("marker 4"), std::string::npos);
  EXPECT_NE(fault.fix.find("did you mean 2?"), std::string::npos) << fault.fix;
}

TEST(Diffusion, RefusesRegionsThatAreNotThereOrLeftOut) {
  const Strip s = strip(3, 1);
  DiffusionProblem<2> problem = between(0, 1);
  problem.conductivity = std::map<int, double>{{1, 1.0}, {2, 1.0}, {5, 1.0}};
  EXPECT_EQ(fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); }).id, "solve.unknown_region");
  problem.conductivity = std::map<int, double>{{1, 1.0}};
  const Fault fault = fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); });
  EXPECT_EQ(fault.id, "solve.unknown_region");
  EXPECT_NE(fault.message.find("region 2"), std::string::npos);
}

TEST(Diffusion, RefusesBadCoefficients) {
  const Strip s = strip(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto id_of = [&](auto&& change) {
    DiffusionProblem<2> problem = between(0, 1);
    change(problem);
    return fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); }).id;
  };
  EXPECT_EQ(id_of([](auto& p) { p.conductivity = 0.0; }), "solve.bad_conductivity");
  EXPECT_EQ(id_of([](auto& p) { p.conductivity = std::map<int, double>{{1, -1.0}}; }), "solve.bad_conductivity");
  EXPECT_EQ(id_of([](auto& p) { p.reaction = -1.0; }), "solve.bad_reaction");
  EXPECT_EQ(id_of([&](auto& p) { p.source = [nan](const Vec<2>&, int) { return nan; }; }), "solve.bad_source");
  EXPECT_EQ(id_of([&](auto& p) { p.conditions[1] = Dirichlet<2>{nan}; }), "solve.bad_condition");
  EXPECT_EQ(id_of([&](auto& p) { p.conditions[1] = Robin<2>{-1.0, 0.0}; }), "solve.bad_condition");
  EXPECT_EQ(id_of([&](auto& p) { p.source = IdVector<VertexId, double>(3); }), "solve.wrong_length");
  EXPECT_EQ(id_of([&](auto& p) { p.source_integrals = IdVector<CellId, double>(1); }), "solve.wrong_length");
}

TEST(Diffusion, RefusesAProblemThatNothingHolds) {
  const Strip s = strip(2);
  DiffusionProblem<2> problem;
  const Fault fault = fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); });
  EXPECT_EQ(fault.id, "solve.no_condition");
  EXPECT_NE(fault.message.find("region 1"), std::string::npos);
  problem.mean = 0;
  problem.source = 1.0;
  EXPECT_EQ(fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); }).id, "solve.incompatible");
  problem.source = 0.0;
  problem.conditions = {{1, Dirichlet<2>{0.0}}};
  EXPECT_EQ(fault_of<InputError>([&] { solve(s.volumes, s.boundary, problem); }).id, "solve.mean_not_free");
}

TEST(Diffusion, RefusesVolumesThatDoNotFitTogether) {
  const auto id_of = [&](auto&& change) {
    Strip s = strip(3, 1);
    change(s);
    return fault_of<InputError>([&] { solve(s.volumes, s.boundary, between(0, 1)); }).id;
  };
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.face_area.push_back(1); }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.cell_volume[CellId(0)] = 0; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.cell_vertex[CellId(1)] = v2; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.face_region[DualFaceId(0)] = 2; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.face_vertices[DualFaceId(1)] = {v0, v1}; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.face_edge_length[DualFaceId(1)] = 0; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.boundary.patch_region[PatchId(0)] = 2; }), "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) {
              s.boundary.patch_vertex[PatchId(1)] = v0;
              s.boundary.patch_marker[PatchId(1)] = 0;
            }),
            "solve.bad_volumes");
  EXPECT_EQ(id_of([](Strip& s) { s.volumes.sites.push_back({9.0, 9.0}); }), "solve.bad_volumes");
}

}  // namespace
}  // namespace voropack
