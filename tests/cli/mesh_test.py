"""Domains to certified meshes, end to end."""
import unittest

from harness import SOURCE, CommandLineTest, box_poly, read_table, square_poly, two_boxes_poly


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

    def test_examples(self):
        for domain in sorted((SOURCE / "examples/domains").glob("*.poly")):
            with self.subTest(domain=domain.name):
                self.succeed("mesh", domain, "-o", "example.node", "--cells", "cells.vtu", "--report", "report.json")
                self.assert_certified(self.report()["certificate"])
                self.succeed("check", "example.node", "--domain", domain)


if __name__ == "__main__":
    unittest.main()
