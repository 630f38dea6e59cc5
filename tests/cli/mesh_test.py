"""Domains to certified meshes, end to end."""
import re
import unittest

from harness import SOURCE, CommandLineTest, box_poly, box_with_plates_poly, read_table, square_poly, two_boxes_poly


class Mesh(CommandLineTest):
    def mesh(self, text, *options):
        self.write("domain.poly", text)
        self.succeed("mesh", "domain.poly", "-o", "a.node", "--report", "report.json", *options)
        report = self.report()
        self.assert_certified(report["certificate"])
        claims = [word for name in ("packing", "epsilon", "gradation") if name in report["options"]
                  for word in (f"--{name}", report["options"][name])]
        self.succeed("check", "a.node", "--domain", "domain.poly", *claims)
        return report

    def test_every_packing(self):
        for text in [square_poly(), box_poly()]:
            for packing in ["voronoi", "maximal", "filtered"]:
                with self.subTest(packing=packing, dimension=text.split()[1]):
                    report = self.mesh(text, "--size", "0.3", "--packing", packing)
                    self.assertEqual(report["options"]["packing"], packing)
                    self.assertEqual("epsilon" in report["options"], packing != "voronoi")

    def rounded_box(self, noise=0.0):
        """A box that is turned about the z axis, as text STL of six digits; one corner is moved by `noise`."""
        corners = [(0.8 * x - 0.6 * y + 0.123457, 0.6 * x + 0.8 * y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        turned = [(x, 0.28 * y - 0.96 * z, 0.96 * y + 0.28 * z) for x, y, z in corners]
        turned[7] = tuple(c + noise for c in turned[7])
        text = "solid box\n"
        for a, b, c, d in [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]:
            for triangle in [(a, b, c), (a, c, d)]:
                vertices = "".join("vertex {:.6g} {:.6g} {:.6g}\n".format(*(v / 0.7 for v in turned[i])) for i in triangle)
                text += f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n"
        return text + "endsolid box\n"

    def test_rounded_facets_are_merged_and_reported(self):
        self.write("box.stl", self.rounded_box())
        self.succeed("mesh", "box.stl", "-o", "a.node", "--size", "0.7", "--report", "report.json")
        report = self.report()
        self.assertEqual((report["input"]["points"], report["input"]["segments"], report["input"]["facets"]), (8, 12, 6))
        merge = report["input"]["merge"]
        self.assertEqual(set(merge), {"distance", "angle_deg", "moved", "largest_displacement"})
        self.assertGreater(merge["moved"], 0)
        self.assertTrue(0 < merge["largest_displacement"] <= merge["distance"])
        self.assertEqual(merge["angle_deg"], 0.1)
        self.assert_certified(report["certificate"])
        self.succeed("check", "a.node", "--domain", "box.stl", "--report", "check.json")
        self.assertEqual(self.report("check.json")["domain"]["merge"], merge)

    def test_more_noise_needs_a_larger_merge_distance(self):
        self.write("box.stl", self.rounded_box(1e-3))
        wide = ["--merge-distance", "0.01", "--merge-angle", "1"]
        self.succeed("mesh", "box.stl", "-o", "a.node", "--size", "0.7", "--report", "report.json", *wide)
        report = self.report()
        self.assertEqual(report["input"]["facets"], 6)
        self.assertGreater(report["input"]["merge"]["largest_displacement"], 1e-4)
        self.assertEqual(report["options"]["merge_distance"], 0.01)
        self.assertEqual(report["options"]["merge_angle"], 1)
        self.succeed("check", "a.node", "--domain", "box.stl", *wide)

    def test_random_interior(self):
        report = self.mesh(box_poly(), "--size", "0.3", "--interior", "random")
        self.assertEqual(report["options"]["interior"], "random")

    def test_without_a_size_the_geometry_decides(self):
        self.mesh(square_poly())
        self.mesh(box_poly())

    def test_edges_have_the_wanted_mean_length(self):
        for size in (0.1, 0.2):
            mean = self.mesh(square_poly(), "--size", size)["quality"]["edge_length"]["mean"]
            self.assertTrue(0.6 * size < mean < 1.4 * size, f"wanted {size}, got {mean}")

    def test_spacing_bounds_f(self):
        self.mesh(square_poly(), "--spacing", "0.03")
        header, rows = read_table(self.folder / "a.node")
        self.assertEqual(header[2], "1", "one attribute, the spacing")
        self.assertLessEqual(max(float(row[3]) for row in rows), 0.03)

    def test_region_size_binds_in_its_region(self):
        report = self.mesh(two_boxes_poly(), "--size", "0.5", "--region-size", "2=0.15")
        simplices = {region["id"]: region["simplices"] for region in report["regions"]}
        self.assertGreater(simplices[2], 3 * simplices[1])

    def test_marker_size_binds_on_its_facet(self):
        self.mesh(square_poly(), "--size", "0.3", "--marker-size", "1=0.05")
        _, rows = read_table(self.folder / "a.edge")
        count = {marker: sum(row[-1] == marker for row in rows) for marker in "1234"}
        self.assertGreater(count["1"], 2 * count["3"])

    def test_size_expression(self):
        self.mesh(square_poly(), "--size-expr", "0.02+0.3*x")
        _, rows = read_table(self.folder / "a.node")
        left = sum(float(row[1]) < 0.5 for row in rows)
        self.assertGreater(left, 2 * (len(rows) - left))

    def test_size_field(self):
        self.mesh(square_poly(), "--size", "0.5")
        header, rows = read_table(self.folder / "a.node")
        lines = [" ".join(header[:2] + ["1", "0"])] + [f"{row[0]} {row[1]} {row[2]} {0.02 + 0.3 * float(row[1])}" for row in rows]
        self.write("field.node", "\n".join(lines) + "\n")
        self.write("field.ele", (self.folder / "a.ele").read_text())
        self.mesh(square_poly(), "--size-field", "field.node")
        _, rows = read_table(self.folder / "a.node")
        left = sum(float(row[1]) < 0.5 for row in rows)
        self.assertGreater(left, 2 * (len(rows) - left))

    def test_size_field_faults(self):
        self.mesh(box_poly(), "--size", "0.6")
        self.write("square.poly", square_poly())
        self.fail_with(2, "mesh", "square.poly", "-o", "b.vtu", "--size-field", "a.node", words="a.node")
        self.assertNotIn("b.vtu", self.names())

    def test_gradation_limits_the_growth_of_spacing(self):
        steep = self.mesh(square_poly(), "--size", "0.3", "--marker-size", "1=0.03", "--gradation", "0.3")
        gentle = self.mesh(square_poly(), "--size", "0.3", "--marker-size", "1=0.03", "--gradation", "0.05")
        self.assertGreater(gentle["counts"]["vertices"], 1.5 * steep["counts"]["vertices"])

    def test_costliest_features_name_a_thin_place(self):
        without = self.mesh(box_with_plates_poly([0.5]))["counts"]["vertices"]
        report = self.mesh(box_with_plates_poly([0.5, 0.52]))
        slit = report["costliest_features"][0]
        self.assertEqual(slit["kind"], "gap")
        self.assertAlmostEqual(slit["size"], 0.02)
        self.assertAlmostEqual(slit["place"][2], 0.51)
        self.assertEqual(slit["polytopes"], [{"dimension": 2, "marker": 7}, {"dimension": 2, "marker": 8}])
        beyond = report["counts"]["vertices"] - without
        self.assertGreater(slit["vertices"], 0.8 * beyond)
        self.assertLess(slit["vertices"], 1.1 * beyond)
        counts = [feature["vertices"] for feature in report["costliest_features"]]
        self.assertEqual(counts, sorted(counts, reverse=True))
        self.assertLessEqual(len(counts), 10)
        self.assertLessEqual(sum(counts), report["counts"]["vertices"])

    def test_costliest_features_are_shown_where_they_matter(self):
        self.write("plates.poly", box_with_plates_poly([0.5, 0.52]))
        text = self.succeed("mesh", "plates.poly", "-o", "a.vtu").stdout
        self.assertIn("a facet of marker 7 and a facet of marker 8 are 0.02 apart near (", text)
        self.assertEqual(self.mesh(box_poly(), "--size", "0.3")["costliest_features"], [])
        self.write("box.poly", box_poly())
        text = self.succeed("mesh", "box.poly", "-o", "a.vtu", "--size", "0.3").stdout
        self.assertNotIn("Costliest features", text)

    def test_too_many_vertices_name_the_same_features(self):
        self.write("plates.poly", box_with_plates_poly([0.5, 0.52]))
        result = self.fail_with(3, "mesh", "plates.poly", "-o", "b.vtu", "--max-vertices", "500",
                                words=["packing.too_many_vertices", "the limit is 500", "raise --max-vertices to "])
        self.assertNotIn("b.vtu", self.names())
        first = result.stderr.split("Costliest features:\n")[1].split("\n")[0]
        self.assertIn("a facet of marker 7 and a facet of marker 8 are 0.02 apart near (", first)
        enough = int(re.search(r"raise --max-vertices to (\d+)", result.stderr).group(1))
        foretold = int(first.split()[0])
        report = self.mesh(box_with_plates_poly([0.5, 0.52]), "--max-vertices", str(enough))
        counted = report["costliest_features"][0]["vertices"]
        self.assertGreater(foretold, 0.5 * counted)
        self.assertLess(foretold, 2 * counted)

    def test_limits_that_cannot_be_met_recommend_no_infinite_one(self):
        self.write("box.poly", box_poly())
        for size in ["1e-6", "1e-150"]:
            result = self.fail_with(3, "mesh", "box.poly", "-o", "b.vtu", "--size", size, words="ask for larger sizes")
            self.assertNotIn("inf", result.stderr.lower())

    def test_examples(self):
        for domain in sorted((SOURCE / "examples/domains").glob("*.poly")):
            with self.subTest(domain=domain.name):
                self.succeed("mesh", domain, "-o", "example.node", "--cells", "cells.vtu", "--report", "report.json")
                self.assert_certified(self.report()["certificate"])
                self.succeed("check", "example.node", "--domain", domain)


if __name__ == "__main__":
    unittest.main()
