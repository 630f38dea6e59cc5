"""The paper's tables: Figure 3 on given and on own meshes, as text, JSON, CSV and picture."""
import csv
import itertools
import json
import os
import pathlib
import unittest
import xml.etree.ElementTree

from harness import SOURCE, CommandLineTest, box_poly, square_poly

SHARED = pathlib.Path(os.environ.get("VOROPACK_SHARED", SOURCE / ".." / "shared"))
GOLDEN = SHARED / "reference" / "golden"
COLUMNS = ["R_over_rho", "fem_H1", "fem_W", "cvm_W"]


class Figure3(CommandLineTest):
    def test_given_meshes_and_points_have_the_prototypes_figures(self):
        nodes = sorted(GOLDEN.glob("*.node"))
        if not nodes:
            self.skipTest("no shared reference data")
        for node, options in itertools.product(nodes, [[], ["--redelaunay"]]):
            self.succeed("paper", "figure3", "--mesh", node, "--report", "report.json", *options)
            report = self.report()
            self.assertEqual(report["command"], "paper figure3")
            self.assertEqual(report["input"]["file"], str(node))
            ours, golden = report["figure3"], json.loads(node.with_suffix(".json").read_text())
            for key in ["ntet", "nused", "nedges", "nbfaces", "nsliv"]:
                self.assertEqual(ours[key], golden[key], f"{node.name} {key}")
            for key, tolerance in {"cvm_W": 1e-8, "fem_W": 1e-6, "fem_H1": 1e-6, "R_over_rho": 1e-5,
                                   "radius_edge": 1e-12, "fem_H1ns": 1e-6, "cvm_H1ns": 1e-6, "int_H1ns": 1e-6,
                                   "cvm_H1": 1e-6, "int_H1": 1e-6, "cvm_max": 1e-8, "fem_max": 1e-6}.items():
                self.assertLessEqual(abs(ours[key] / golden[key] - 1), tolerance, f"{node.name} {key}")

    def test_theorems_hold_on_a_given_mesh(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "box.node", "--size", "0.2")
        self.succeed("paper", "figure3", "--mesh", "box.node", "--report", "report.json")
        figures = self.report()["figure3"]
        self.assertAlmostEqual(figures["U_minus_U1"] / figures["cvm_W"], 1, places=9)
        self.assertLess(figures["U_minus_U1"], figures["U1_minus_U2"])
        self.assertLess(figures["U1_minus_U2"], figures["bound_2_3"])

    def test_table_csv_picture_and_report_agree(self):
        result = self.succeed("paper", "figure3", "--grid", "4,6", "--eps", "0.01,0", "--seeds", "3", "--seed", "5",
                              "-o", "a.csv", "-o", "a.svg", "--report", "report.json")
        with open(self.folder / "a.csv", newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        rows = self.report()["figure3"]["rows"]
        self.assertEqual([(row["n"], row["eps"], row["seeds"]) for row in rows],
                         [(4, 0.01, 3), (4, 0, 3), (6, 0.01, 3), (6, 0, 3)])
        self.assertEqual(len(table), 16)
        lines = result.stdout.splitlines()[1:]
        self.assertEqual(len(lines), 16)
        for k, (cells, line) in enumerate(zip(table, lines)):
            figures = rows[k // 4][cells["col"]]
            self.assertEqual(cells["col"], COLUMNS[k % 4])
            self.assertEqual("paper" in figures, k < 4, "the paper has 1/4 and 0.01 only")
            for key in ["mean", "sd", "min", "median", "max"]:
                self.assertEqual(float(cells[key]), figures[key])
            self.assertLessEqual(figures["min"], figures["median"])
            self.assertLessEqual(figures["median"], figures["max"])
            self.assertIn(cells["col"], line)
            self.assertAlmostEqual(float(line.split()[-4]) / figures["mean"], 1, places=4)
        self.assertEqual(float(table[0]["paper"]), 1126)
        for k in [7, 15]:
            self.assertEqual(float(table[k]["sd"]), 0, "without perturbation all meshes are one")
        root = xml.etree.ElementTree.parse(self.folder / "a.svg").getroot()
        text = "".join(root.itertext())
        for word in ["1/4", "1/8", "FEM, H1", "CVM, W", "eps 0.01"]:
            self.assertIn(word, text)

    def test_slivers_too_flat_for_finite_elements_leave_control_volumes(self):
        self.succeed("paper", "figure3", "--grid", "4", "--eps", "1e-8,1e-12,1e-15,0", "--seeds", "3", "--report",
                     "report.json")
        self.assertNotIn("null", (self.folder / "report.json").read_text())
        for row in self.report()["figure3"]["rows"]:
            self.assertEqual(row["cvm_W"]["meshes"], 3)
            for key in ["min", "mean", "max"]:
                self.assertAlmostEqual(row["cvm_W"][key], 0.2410636191, places=7)
            self.assertEqual("mean" in row["fem_W"], row["fem_W"]["meshes"] > 0)

    def test_seeds_matter_and_repeat(self):
        run = ["paper", "figure3", "--grid", "4", "--eps", "0.01", "--seeds", "2"]
        one = self.succeed(*run).stdout
        self.assertEqual(one, self.succeed(*run, "--threads", "1").stdout)
        self.assertNotEqual(one, self.succeed(*run, "--seed", "9").stdout)

    def test_help(self):
        self.assertIn("figure3", self.succeed("paper", "--help").stdout)
        text = self.succeed("paper", "figure3", "--help").stdout
        for word in ["--mesh", "--grid", "--eps", "--seeds", "--report", "Example: voropack paper figure3"]:
            self.assertIn(word, text)


class WrongUse(CommandLineTest):
    def fails(self, *arguments, words):
        before = self.names()
        self.assertEqual(self.fail_with(2, "paper", *arguments, words=words).stdout, "")
        self.assertEqual(self.names(), before, "nothing is left behind")

    def test_names(self):
        self.fails("figur3", words="did you mean 'figure3'")
        self.fails("figure3", "--sed", "4", words="did you mean '--seed'")
        self.fails(words="subcommand")

    def test_values(self):
        for option, value in [("--grid", "1"), ("--grid", "4,x"), ("--eps", "0.5"), ("--eps", "-1"), ("--seeds", "0")]:
            self.fails("figure3", option, value, words=option)
        self.fails("figure3", "-o", "a.png", words=".csv or .svg")
        self.fails("figure3", "--mesh", "a.node", "--grid", "4", words="--grid")

    def test_meshes(self):
        self.write("square.poly", square_poly())
        self.succeed("mesh", "square.poly", "-o", "square.node")
        self.fails("figure3", "--mesh", "square.node", words=["2D", "3D mesh"])
        self.write("flat.node", "5 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 0 1\n")
        self.write("flat.ele", "2 4\n1 1 2 3 5\n2 1 2 3 4\n")
        self.fails("figure3", "--mesh", "flat.node", words="mesh.flat_simplex")

    def test_flat_simplices_go_away_with_new_ones(self):
        points = [(x, y, z) for x in (0, 0.5, 1) for y in (0, 0.5, 1) for z in (0, 0.5, 1)]
        self.write("flat.node", "27 3\n" + "".join(f"{i} {x} {y} {z}\n" for i, (x, y, z) in enumerate(points)))
        self.write("flat.ele", "2 4\n0 0 1 3 9\n1 0 1 3 4\n")
        self.fails("figure3", "--mesh", "flat.node", words="mesh.flat_simplex")
        self.succeed("paper", "figure3", "--mesh", "flat.node", "--redelaunay", "--report", "report.json")
        figures = self.report()["figure3"]
        self.assertEqual([figures[key] for key in ["nused", "nbfaces"]], [27, 48])
        self.assertEqual(figures["nedges"], figures["ntet"] + 24 + 27 - 1, "Euler")
        self.assertGreater(figures["zero_areas"], 0, "the diagonals of the grid's squares")
        self.fails("figure3", "--redelaunay", words="--mesh")
        self.fails("figure3", "--redelaunay", "--mesh", "flat.vtu", words=".node")

    def test_a_mesh_of_another_box(self):
        self.write("box.poly", box_poly(hi=(1, 1, 2)))
        self.succeed("mesh", "box.poly", "-o", "box.node", "--size", "0.4")
        self.succeed("paper", "figure3", "--mesh", "box.node", "--report", "report.json")
        figures = self.report()["figure3"]
        self.assertGreater(figures["cvm_W"], 0)
        self.assertLess(figures["radius_edge"], 2.5)


class Figure5(CommandLineTest):
    def test_repeated_independent_sets_decay_and_coarsen_does_not(self):
        self.succeed("paper", "figure5", "--size", "0.02", "--levels", "3", "-o", "five.csv", "-o",
                     "five.svg", "--report", "report.json")
        for method in ("mis", "literal", "graded"):
            self.assertTrue((self.folder / f"five-{method}.svg").exists())
        rows = self.report()["levels"]
        with open(self.folder / "five.csv", newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        self.assertEqual([(row["method"], int(row["level"]), int(row["vertices"])) for row in table],
                         [(row["method"], row["level"], row["vertices"]) for row in rows])
        shapes = {(row["method"], row["level"]): row["radius_edge"] for row in rows}
        for level in (1, 2, 3):
            for method in ("literal", "graded"):
                self.assertLess(shapes[method, level], 2)
        self.assertGreater(shapes["mis", 3], max(shapes["literal", 3], shapes["graded", 3]))


class Figure8(CommandLineTest):
    def test_levels_are_in_proportion_to_the_papers(self):
        self.write("box.poly", square_poly())
        self.succeed("mesh", "box.poly", "-o", "box.node", "--size", "0.05", "--quiet")
        self.succeed("paper", "figure8", "--mesh", "box.node", "-o", "eight.csv", "-o", "eight.svg", "--report",
                     "report.json")
        with open(self.folder / "eight.csv", newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        nodes = {(row["source"], int(row["level"])): int(row["nodes"]) for row in table}
        paper = [nodes["paper", k] for k in range(5)]
        self.assertEqual(paper, [4253, 1039, 416, 217, 86])
        for source in ("packed", "improved"):
            for k in range(1, 5):
                self.assertLessEqual(nodes[source, k], paper[k] * nodes["computed", 0] / paper[0])
        for level in self.report()["levels"]:
            self.assertLessEqual(level["area_change"], 0.02)
            if level["source"] == "packed":
                self.assertEqual(level["largest_overlap"], 0)
        for k in range(1, 5):
            root = xml.etree.ElementTree.parse(self.folder / f"eight-{k}.svg").getroot()
            self.assertTrue(root.tag.endswith("svg"))

    def test_a_mesh_in_space_is_refused(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "box.node", "--size", "0.3", "--quiet")
        self.fail_with(2, "paper", "figure8", "--mesh", "box.node", words="cli.dimension")


if __name__ == "__main__":
    unittest.main()
