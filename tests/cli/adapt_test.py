"""`solve --adapt` meets tolerances and budgets, writes every mesh of the way, and goes on from mesh to mesh."""
import pathlib
import shutil
import unittest
import xml.etree.ElementTree

import meshio
import numpy

from harness import CommandLineTest, box_poly, square_poly, two_boxes_poly

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
LAYER = "tanh((x-0.5)/0.05)"
CASE = f"""
[domain]
file = "square.poly"
size = 0.2
[equation]
source = "2*{LAYER}*(1-{LAYER}^2)/0.05^2"
[boundary.others]
type = "dirichlet"
value = "{LAYER}"
[exact]
u = "{LAYER}"
"""


class AdaptTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("square.poly", square_poly())
        self.write("layer.toml", CASE)

    def adapt(self, *options, case="layer.toml", code=0):
        result = self.run_program("solve", case, "--adapt", "--report", "report.json", *options)
        self.assertEqual(result.returncode, code, result.stderr)
        self.output = result.stdout
        return self.report()["solve"]["adaptivity"]

    def test_a_tolerance_is_met(self):
        figures = self.adapt("--tolerance", "0.2", "-o", "layer.vtu")
        self.assertEqual(figures["end"], "tolerance")
        cycles = figures["cycles"]
        self.assertLessEqual(cycles[-1]["estimate"], 0.2)
        self.assertLess(cycles[-1]["error"], 0.4)
        for cycle in cycles[2:]:
            self.assertTrue(0.5 < cycle["effectivity"] < 2, cycle)
            self.assertTrue(cycle["certified"])
        self.assert_certified(self.report()["certificate"])
        series = xml.etree.ElementTree.parse(self.folder / "layer.pvd").findall(".//DataSet")
        self.assertEqual(len(series), len(cycles))
        for data_set, cycle in zip(series, cycles):
            mesh = meshio.read(self.folder / data_set.get("file"))
            self.assertEqual(len(mesh.points), cycle["vertices"])
            self.assertEqual(len(mesh.point_data["u"]), cycle["vertices"])
        fine = mesh.point_data["spacing"]
        away = abs(mesh.points[:, 0] - 0.5)
        self.assertLess(3 * numpy.median(fine[away < 0.05]), numpy.median(fine[away > 0.3]))

    def test_fields_that_cannot_be_followed(self):
        self.write("half.poly", square_poly(0.5))
        for domain, name in (("half.poly", "half"), ("square.poly", "whole")):
            self.write("case.toml", CASE.replace("square.poly", domain))
            self.succeed("solve", "case.toml", "-o", f"{name}.vtu", "--quiet")
        self.fail_with(2, "solve", "layer.toml", "--adapt", "--max-vertices", "500", "--adapt-field", "half.vtu:u", "-o",
                       "no.vtu", words=["half.vtu", "transfer.not_covered", "same domain"])
        mesh = meshio.read(self.folder / "whole.vtu")
        mesh.point_data["u"][3] = numpy.nan
        mesh.write(self.folder / "nan.vtu")
        self.fail_with(2, "solve", "layer.toml", "--adapt", "--max-vertices", "500", "--adapt-field", "nan.vtu:u", "-o",
                       "no.vtu", words=["nan.vtu", 'array "u" is nan at vertex 3', "adapt.not_finite"])
        for transfer in ("interpolate", "conserve"):
            self.write("on.toml", CASE + f'''
[time]
end = 0.1
step = 0.05
initial = {{array = "u", file = "half.vtu", transfer = "{transfer}"}}
''')
            self.fail_with(2, "solve", "on.toml", "-o", "no.vtu",
                           words=["on.toml", "half.vtu", "does not reach", "transfer.not_covered"])
        # Values from a larger domain cover this one, but their integral is another.
        self.write("on.toml", CASE.replace("square.poly", "half.poly") + '''
[time]
end = 0.1
step = 0.05
initial = {array = "u", file = "whole.vtu", transfer = "conserve"}
''')
        self.fail_with(2, "solve", "on.toml", "-o", "no.vtu", words="transfer.not_covered")
        self.assertFalse((self.folder / "no.vtu").exists())

    def test_a_budget_is_kept(self):
        for keep in ("none", "fitting", "all"):
            figures = self.adapt("--max-vertices", "2000", "--keep", keep, "-o", "layer.vtu")
            counts = [cycle["vertices"] for cycle in figures["cycles"]]
            self.assertEqual(figures["end"], "max_vertices")
            self.assertTrue(1000 < counts[-1] <= 2000, counts)
            self.assertLess(figures["cycles"][-1]["error"], figures["cycles"][0]["error"] / 5)
            if keep == "none":
                continue
            last = set(map(tuple, meshio.read(self.folder / f"layer_{len(counts) - 1:04}.vtu").points))
            before = set(map(tuple, meshio.read(self.folder / f"layer_{len(counts) - 2:04}.vtu").points))
            self.assertEqual(len(last & before), figures["cycles"][-1]["kept"])
            if keep == "all":
                self.assertLess(before, last)

    def test_a_shorter_series_takes_the_place_of_a_longer_one(self):
        self.adapt("--cycles", "3", "-o", "layer.vtu")
        (self.folder / "layer_extra.vtu").write_text("of the user's")
        (self.folder / "layer_00002.vtu").write_text("of the user's")
        self.adapt("--cycles", "1", "-o", "layer.vtu")
        self.assertIn("state 2, 3 of an earlier series", self.output)
        self.assertEqual(sorted(path.name for path in self.folder.glob("layer*.vtu")),
                         ["layer_0000.vtu", "layer_00002.vtu", "layer_0001.vtu", "layer_extra.vtu"])
        self.adapt("--cycles", "2", "-o", "layer.vtu")
        self.assertNotIn("earlier series", self.output)

    def test_a_state_that_is_read_stays(self):
        self.adapt("--cycles", "3", "-o", "layer.vtu")
        self.fail_with(2, "solve", "layer.toml", "--adapt", "--max-vertices", "100", "--adapt-field", "layer_0003.vtu:u",
                       "-o", "layer.vtu", words=["cli.overwrites_input", "layer_0003.vtu"])
        self.assertTrue((self.folder / "layer_0003.vtu").exists())

    def test_time_is_refused_with_the_way_around(self):
        self.write("time.toml", CASE + "[time]\nend = 0.1\nstep = 0.05\ninitial = 0\n")
        self.fail_with(2, "solve", "time.toml", "--adapt", words=["cli.contradiction", "--adapt-field", "transfer"])

    def test_a_tolerance_that_is_not_met(self):
        figures = self.adapt("--tolerance", "1e-6", "--cycles", "2", "-o", "layer.vtu", code=4)
        self.assertEqual((figures["end"], len(figures["cycles"])), ("max_cycles", 3))
        self.assertTrue((self.folder / "layer.pvd").exists())

    def test_a_mesh_instead_of_a_domain_and_two_materials(self):
        self.write("two.poly", two_boxes_poly())
        self.succeed("mesh", "two.poly", "-o", "two.vtu", "--size", "0.4", "--quiet")
        self.write("two.toml", '[mesh]\nfile = "two.vtu"\n[equation]\nconductivity = {1 = 1.0, 2 = 100}\nsource = "x*y"\n'
                               '[boundary.others]\ntype = "dirichlet"\nvalue = 0\n')
        figures = self.adapt("--max-vertices", "3000", case="two.toml")
        self.assertLess(figures["cycles"][-1]["estimate"], 0.7 * figures["cycles"][0]["estimate"])
        self.assertNotIn("error", figures["cycles"][0])
        self.assert_certified(self.report()["certificate"])
        for balance in self.report()["solve"]["balances"]:
            self.assertLess(abs(balance["imbalance"]), 1e-12 * balance["throughput"])

    def test_a_field_of_the_users(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "field.vtu", "--size", "0.1", "--quiet")
        field = meshio.read(self.folder / "field.vtu")
        field.point_data = {"bend": numpy.exp(-50 * numpy.sum((field.points - 0.5)**2, axis=1))}
        field.write(self.folder / "field.vtu")
        self.write("box.toml", '[domain]\nfile = "box.poly"\nsize = 0.4\n[boundary.others]\ntype = "dirichlet"\nvalue = "x"\n')
        figures = self.adapt("--adapt-field", "field.vtu:bend", "--max-vertices", "2000", "-o", "box.vtu", case="box.toml")
        self.assertEqual(len(figures["cycles"]), 2)
        mesh = meshio.read(self.folder / "box_0001.vtu")
        radius = numpy.linalg.norm(mesh.points - 0.5, axis=1)
        spacing = mesh.point_data["spacing"]
        self.assertLess(1.5 * numpy.median(spacing[radius < 0.15]), numpy.median(spacing[radius > 0.6]))

    def test_time_goes_on_on_another_mesh(self):
        case = ('[domain]\nfile = "square.poly"\nsize = {size}\n[boundary.others]\ntype = "dirichlet"\nvalue = 0\n'
                '[time]\nend = 0.01\nstep = 0.005\ninitial = {initial}\n')
        self.write("first.toml", case.format(size=0.1, initial='"sin(pi*x)*sin(pi*y)"'))
        self.succeed("solve", "first.toml", "-o", "first.vtu", "--cells", "first_cells.vtu")
        for way in ("interpolate", "conserve"):
            self.write("second.toml", case.format(
                size=0.07, initial=f'{{array = "u", file = "first_0001.vtu", transfer = "{way}"}}'))
            self.succeed("solve", "second.toml", "-o", "second.vtu", "--cells", "second_cells.vtu")
            before, after = (meshio.read(self.folder / name) for name in ("first_0001.vtu", "second_0000.vtu"))
            self.assertLess(abs(before.point_data["u"].max() - after.point_data["u"].max()), 0.05)
            if way == "conserve":
                self.assertAlmostEqual(self.integral("first_cells_0001.vtu"), self.integral("second_cells_0000.vtu"),
                                       places=12)
        self.write("second.toml", case.format(size=0.07, initial='{array = "u", file = "first_0001.vtu"}'))
        result = self.run_program("solve", "second.toml")
        self.assertEqual(result.returncode, 2)
        self.assertIn('transfer = "interpolate"', result.stderr)

    def integral(self, name):
        cells = meshio.read(self.folder / name).cell_data
        return numpy.concatenate(cells["u"]) @ numpy.concatenate(cells["volume"])

    def test_a_limit_leaves_what_was_there_before(self):
        self.write("small.toml", CASE.replace("size = 0.2", "size = 0.2\nmax_vertices = 400"))
        figures = self.adapt("--cycles", "6", "-o", "small.vtu", case="small.toml", code=3)
        self.assertEqual(figures["end"], "limit")
        self.assertIn("max_vertices under [domain]", figures["reason"])
        self.assertNotIn("--max-vertices", figures["reason"])
        self.assertTrue((self.folder / f"small_{len(figures['cycles']) - 1:04}.vtu").exists())
        result = self.run_program("solve", "layer.toml", "--adapt", "--max-vertices", "10", "-o", "none.vtu")
        self.assertEqual(result.returncode, 3)
        self.assertIn("larger size", result.stderr)

    def test_a_mesh_with_nothing_inside_is_not_believed(self):
        self.write("tiny.toml", CASE.replace("size = 0.2", "size = 3"))
        cycles = self.adapt("--tolerance", "0.5", case="tiny.toml")["cycles"]
        self.assertGreater(len(cycles), 2)
        self.assertLess(cycles[-1]["error"], 1)

    def test_what_estimates_do_not_see_is_told(self):
        self.write("varied.toml", CASE.replace("[equation]", '[equation]\nconductivity = "1 + x"\nreaction = 2'))
        figures = self.adapt("--cycles", "1", case="varied.toml")
        self.assertNotIn("not_estimated", figures)
        self.assertNotIn("not in the estimate", self.output)
        self.succeed("mesh", "square.poly", "-o", "other.vtu", "--size", "0.2", "--quiet")
        self.write("array.toml", CASE.replace("[equation]", '[equation]\nreaction = {array = "spacing", '
                                              'file = "other.vtu", transfer = "interpolate"}'))
        figures = self.adapt("--cycles", "1", case="array.toml")
        self.assertEqual(figures["not_estimated"], ["equation.reaction between the vertices of its array"])
        self.assertIn("not in the estimate", self.output)

    def test_examples_are_adapted(self):
        shutil.copytree(EXAMPLES, self.folder / "examples")
        for name, fall in (("corner", 0.6), ("edge", 0.8), ("exponential", 0.75), ("layer", 0.5)):
            cycles = self.adapt("--cycles", "2", "--growth", "3", "-o", f"{name}.vtu",
                                case=f"examples/cases/{name}.toml")["cycles"]
            self.assertEqual(len(cycles), 3)
            self.assertLess(cycles[-1]["error"] / cycles[0]["error"], fall ** 2, name)
            self.assertTrue(0.5 < cycles[-1]["effectivity"] < 2, (name, cycles[-1]))

    def test_what_is_refused(self):
        in_time = CASE + '[time]\nend = 1.0\n'
        by_elements = 'method = "fem"\n' + CASE
        for text, options, words in ((in_time, [], "[time]"), (by_elements, [], "cvm"),
                                     (CASE, ["--adapt-field", "layer.vtu"], "FILE:array"),
                                     (CASE, ["--adapt-field", "layer.vtu:u"], "--max-vertices"),
                                     (CASE, ["--keep", "some"], "--keep"), (CASE, ["--tolerance", "0"], "--tolerance")):
            self.write("case.toml", text)
            result = self.run_program("solve", "case.toml", "--adapt", *options, "-o", "out.vtu")
            self.assertEqual(result.returncode, 2, words)
            self.assertIn(words, result.stderr)
            self.assertEqual(list(self.folder.glob("out*")), [])
        result = self.run_program("solve", "layer.toml", "--tolerance", "1")
        self.assertEqual(result.returncode, 2)
        self.assertIn("--adapt", result.stderr)


if __name__ == "__main__":
    unittest.main()
