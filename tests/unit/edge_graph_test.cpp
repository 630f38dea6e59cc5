// The edge graph of a mesh, Lipschitz functions along it, and trees whose values change, against obvious versions.
#include "mesh/edge_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/parallel.h"
#include "base/random.h"
#include "geom/box_tree.h"
#include "geom/hilbert.h"
#include "support/allow_threads.h"
#include "support/domains.h"
#include "voropack/pipeline.h"

namespace voropack {
namespace {

template <int D>
Mesh<D> a_mesh() {
  MeshingOptions<D> options;
  options.wishes.size = D == 2 ? 0.01 : 0.06;  // More than one block of vertices.
  return make_mesh(domains::unit_box<D>(), options).mesh;
}

IdVector<VertexId, double> some_values(std::size_t n) {
  Random random(7);
  IdVector<VertexId, double> f(n);
  for (double& value : f) value = random.unit() < 0.01 ? 0.01 : 1 + random.unit();
  return f;
}

template <int D>
void edges_are_those_of_simplices() {
  const Mesh<D> mesh = a_mesh<D>();
  ASSERT_GT(mesh.points.size(), 4096U);
  const EdgeGraph graph = build_edge_graph(mesh);
  std::vector<std::set<VertexId>> wanted(mesh.points.size());
  for (const auto& corners : mesh.simplex_vertices)
    for (const VertexId v : corners)
      for (const VertexId w : corners)
        if (v != w) wanted[v.value()].insert(w);
  for (const VertexId v : ids(mesh.points)) {
    const auto row = graph.neighbors[v];
    ASSERT_TRUE(std::equal(row.begin(), row.end(), wanted[v.value()].begin(), wanted[v.value()].end()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      const double length = distance(mesh.points[v], mesh.points[row[i]]);
      ASSERT_LE(graph.lengths(v)[i], length);
      ASSERT_GE(graph.lengths(v)[i], length * (1 - 1.2e-7));
    }
  }
}
TEST(EdgeGraph, EdgesAreThoseOfSimplicesInThePlane) { edges_are_those_of_simplices<2>(); }
TEST(EdgeGraph, EdgesAreThoseOfSimplicesInSpace) { edges_are_those_of_simplices<3>(); }

template <int D>
void values_fall_to_the_largest_lipschitz_function() {
  const EdgeGraph graph = build_edge_graph(a_mesh<D>());
  const double lipschitz = 0.2;
  const IdVector<VertexId, double> f = some_values(graph.neighbors.size());
  IdVector<VertexId, double> wanted = f;
  for (bool changed = true; changed;) {
    changed = false;
    for (const VertexId v : ids(wanted))
      for (std::size_t i = 0; i < graph.neighbors[v].size(); ++i) {
        const double most = wanted[graph.neighbors[v][i]] + lipschitz * static_cast<double>(graph.lengths(v)[i]);
        if (most < wanted[v]) wanted[v] = most, changed = true;
      }
  }
  ASSERT_NE(wanted, f);
  const test::AllowThreads allow(8);
  for (const int threads : {1, 2, 8}) {
    IdVector<VertexId, double> found = f;
    run_with_threads(threads, [&] { make_lipschitz(graph, lipschitz, found); });
    EXPECT_EQ(found, wanted) << threads << " threads";
  }
}
TEST(EdgeGraph, ValuesFallToTheLargestLipschitzFunctionInThePlane) {
  values_fall_to_the_largest_lipschitz_function<2>();
}
TEST(EdgeGraph, ValuesFallToTheLargestLipschitzFunctionInSpace) { values_fall_to_the_largest_lipschitz_function<3>(); }

template <int D>
void grows_as_level_by_level() {
  const EdgeGraph graph = build_edge_graph(a_mesh<D>());
  const std::size_t n = graph.neighbors.size();
  IdVector<VertexId, double> smooth(n, 0.01), rough(n);
  Random random(8);
  for (double& value : rough) value = 0.001 * std::pow(10.0, random.unit());
  for (std::size_t i = 0; i < n; i += 1000) smooth[VertexId(i)] = 0.002;
  const test::AllowThreads allow(8);
  for (const IdVector<VertexId, double>& f : {smooth, rough, some_values(n)})
    for (const double growth : {1.0, 1.3, 2.0}) {
      std::vector<IdVector<VertexId, double>> wanted;
      IdVector<VertexId, double> level = f;
      for (int k = 0; k < 6; ++k) {
        for (double& value : level) value *= growth;
        make_lipschitz(graph, 0.2, level);
        wanted.push_back(level);
      }
      for (const int threads : {1, 8})
        run_with_threads(threads, [&] { EXPECT_EQ(grown_lipschitz(graph, 0.2, f, growth, 6), wanted); });
    }
}
TEST(EdgeGraph, FunctionsGrowAsLevelByLevelInThePlane) { grows_as_level_by_level<2>(); }
TEST(EdgeGraph, FunctionsGrowAsLevelByLevelInSpace) { grows_as_level_by_level<3>(); }

void expect_answers(BoxTree<3> tree, const std::vector<Box<3>>& boxes) {
  Random random(3);
  std::vector<double> values;
  for (std::size_t i = 0; i < boxes.size(); ++i) values.push_back(random.unit());
  tree.set_values(values);
  for (int k = 0; k < 100; ++k) {
    const Vec<3> x = {random.unit(), random.unit(), random.unit()};
    const auto value_at = [&](std::uint32_t i) { return values[i] + 0.5 * distance(x, boxes[i].lo); };
    double least = 10;
    for (std::uint32_t i = 0; i < values.size(); ++i) least = std::min(least, value_at(i));
    EXPECT_EQ(tree.minimize(x, 0.5, 10, value_at), least);
    std::set<std::uint32_t> wanted, found;
    for (std::uint32_t i = 0; i < values.size(); ++i)
      if (distance(x, boxes[i].lo) < 0.5 - values[i]) wanted.insert(i);
    tree.for_each_below([&](const auto& node) { return std::sqrt(node.box.distance_sq(x)) < 0.5 - node.value; },
                        [&](std::uint32_t i) {
                          if (distance(x, boxes[i].lo) < 0.5 - values[i]) found.insert(i);
                        });
    EXPECT_EQ(found, wanted);
  }
}

TEST(BoxTree, ValuesMayChange) {
  Random random(4);
  std::vector<Vec<3>> points;
  std::vector<Box<3>> boxes;
  for (int i = 0; i < 500; ++i) {
    points.push_back({random.unit(), random.unit(), random.unit()});
    boxes.emplace_back(points.back(), points.back());
  }
  expect_answers(BoxTree<3>(boxes, std::vector<double>(boxes.size(), 5.0)), boxes);
  expect_answers(BoxTree<3>::along_curve(hilbert_order<3>(points), boxes), boxes);
}

}  // namespace
}  // namespace voropack
