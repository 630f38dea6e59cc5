"""voropack solve: exact solutions through the whole command, files, report, and cases that are refused."""
import csv
import hashlib
import itertools
import math
import re
import sys
import unittest
import xml.etree.ElementTree

import meshio
import numpy

from harness import SOURCE, CommandLineTest, box_poly, square_poly, two_boxes_poly

HALVES_POLY = """6 2 0 0
1 0 0
2 1 0
3 2 0
4 2 1
5 1 1
6 0 1
7 1
1 1 2 1
2 2 3 1
3 3 4 2
4 4 5 1
5 5 6 1
6 6 1 3
7 2 5 4
0
2
1 0.5 0.5 1
2 1.5 0.5 2
"""

# A square with a well in the middle, as a point of marker 9.
WELL_POLY = """5 2 0 1
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0.5 0.5 9
4 1
1 1 2 1
2 2 3 2
3 3 4 3
4 4 1 4
0
"""


class SolveTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("square.poly", square_poly())
        self.write("box.poly", box_poly())
        self.write("halves.poly", HALVES_POLY)
        self.write("boxes.poly", two_boxes_poly())

    def case(self, text, domain="square.poly", size=0.2, name="case.toml"):
        return self.write(name, f'{text}\n[domain]\nfile = "{domain}"\nsize = {size}\n' if domain else text)

    def solve(self, text, *options, domain="square.poly", size=0.2):
        """The report's object `solve`."""
        self.case(text, domain, size)
        self.output = self.succeed("solve", "case.toml", "--report", "report.json", *options).stdout
        return self.report()["solve"]

    def flattest(self):
        """The smallest dihedral angle of the mesh, in radians."""
        return math.radians(self.report()["quality"]["dihedral_deg"]["min"])

    def assert_balanced(self, figures):
        for balance in figures["balances"]:
            self.assertLess(abs(balance["imbalance"]), 1e-12 * max(balance["throughput"], 1e-300))


class ExactSolutions(SolveTest):
    LINEAR = {"square.poly": "1 + 2*x - 3*y", "box.poly": "1 + 2*x - 3*y + z"}

    def test_linear_functions_are_exact(self):
        for (domain, u), method in itertools.product(self.LINEAR.items(), ["cvm", "fem"]):
            with self.subTest(domain=domain, method=method):
                figures = self.solve(f'method = "{method}"\n[equation]\nconductivity = 3.0\n'
                                     f'[boundary.others]\ntype = "dirichlet"\nvalue = "{u}"\n[exact]\nu = "{u}"',
                                     domain=domain)
                for norm in ["W", "L2", "H1", "max"]:
                    flat = method == "fem" and domain == "box.poly" or norm == "H1" and domain == "box.poly"
                    self.assertLess(figures["errors"][norm], 1e-15 / self.flattest() if flat else 1e-12, norm)
                self.assertEqual(figures["method"], method)
                self.assertEqual([flux["marker"] for flux in figures["fluxes"]],
                                 [1, 2, 3, 4] if domain == "square.poly" else [1, 2, 3, 4, 5, 6])
                self.assert_balanced(figures)
                if method == "cvm":
                    self.assertTrue(figures["matrix"]["m_matrix"])
                    self.assertAlmostEqual(sum(flux["inflow"] for flux in figures["fluxes"]), 0, places=11)

    def test_neumann_and_robin_conditions_are_exact_too(self):
        for method in ["cvm", "fem"]:
            figures = self.solve(f'method = "{method}"\n[equation]\nconductivity = 2\n'
                                 '[boundary.1]\ntype = "neumann"\ninflow = 6\n'
                                 '[boundary.2]\ntype = "robin"\ntransfer = 4\noutside = "1 + 3*x - 3*y"\n'
                                 '[boundary.3]\ntype = "dirichlet"\nvalue = "-2 + 2*x"\n'
                                 '[boundary.4]\ntype = "rate"\ntotal = -4\n'
                                 '[exact]\nu = "1 + 2*x - 3*y"')
            self.assertLess(figures["errors"]["max"], 1e-12)
            fluxes = {flux["marker"]: flux["inflow"] for flux in figures["fluxes"]}
            for marker, inflow in {1: 6, 2: 4, 3: -6, 4: -4}.items():
                self.assertAlmostEqual(fluxes[marker], inflow, places=11)
                self.assert_balanced(figures)

    def test_two_materials_are_exact(self):
        u = "if(x < 1, 4*x, 4 + (x-1))"
        markers = {"halves.poly": (3, 2), "boxes.poly": (1, 3)}
        for (domain, (left, right)), method in itertools.product(markers.items(), ["cvm", "fem"]):
            with self.subTest(domain=domain, method=method):
                figures = self.solve(f'method = "{method}"\n[equation]\nconductivity = {{1 = 1.0, 2 = "4 + 0*x"}}\n'
                                     f'[boundary.{left}]\ntype = "dirichlet"\nvalue = 0.0\n'
                                     f'[boundary.{right}]\ntype = "dirichlet"\nvalue = 5\n[exact]\nu = "{u}"',
                                     domain=domain, size=0.3)
                # What rounding does to finite elements grows like 1 over the angle of the flattest sliver.
                tolerance = 1e-12 if method == "cvm" or domain == "halves.poly" else 1e-15 / self.flattest()
                self.assertLess(figures["errors"]["max"], tolerance)
                if method == "cvm":
                    self.assert_balanced(figures)
                    for balance, inflow in zip(figures["balances"], [4, -4]):
                        self.assertAlmostEqual(balance["interface_inflow"], inflow, places=11)

    def test_smooth_solutions_converge(self):
        text = ('[equation]\nconductivity = "1 + x"\nreaction = 1.0\n'
                'source = "sin(pi*x)*sin(pi*y)*(1 + 2*pi^2*(1+x)) - pi*cos(pi*x)*sin(pi*y)"\n'
                '[boundary.others]\ntype = "dirichlet"\nvalue = 0\n[exact]\nu = "sin(pi*x)*sin(pi*y)"')
        for method in ["cvm", "fem"]:
            coarse, fine = (self.solve(f'method = "{method}"\n{text}', size=size)["errors"] for size in (0.1, 0.025))
            self.assertLess(fine["max"], coarse["max"] / 8, method)
            self.assertLess(fine["L2"], coarse["L2"] / 8, method)
            self.assertLess(fine["H1"], coarse["H1"] / 3, method)

    def test_a_given_gradient_is_the_derived_one(self):
        text = ('[boundary.others]\ntype = "dirichlet"\nvalue = "exp(x)*sin(y)"\n'
                '[exact]\nu = "exp(x)*sin(y)"\n')
        derived = self.solve(text)["errors"]["H1"]
        given = self.solve(text + 'gradient = ["exp(x)*sin(y)", "exp(x)*cos(y)"]\n')["errors"]["H1"]
        self.assertAlmostEqual(derived / given, 1, places=12)
        self.assertGreater(self.solve(text + 'gradient = ["exp(x)*sin(y)", 0]\n')["errors"]["H1"], 10 * given)

    def test_pure_neumann_takes_the_mean(self):
        for method in ["cvm", "fem"]:
            figures = self.solve(f'method = "{method}"\n[equation]\nmean = 7.0\n'
                                 '[boundary.2]\ntype = "neumann"\ninflow = 2\n'
                                 '[boundary.4]\ntype = "neumann"\ninflow = -2\n[exact]\nu = "6 + 2*x"')
            self.assertLess(figures["errors"]["max"], 1e-11)

    def test_arrays_are_read(self):
        self.succeed("mesh", "square.poly", "-o", "mesh.vtu", "--size", "0.2")
        self.solve('[mesh]\nfile = "mesh.vtu"\n[boundary.others]\ntype = "dirichlet"\nvalue = "3 + x"', "-o", "k.vtu",
                   domain=None)
        head = '[mesh]\nfile = "k.vtu"\n[boundary.others]\ntype = "dirichlet"\nvalue = "x + 2*y"\n[equation]\n'
        array = self.solve(head + 'conductivity = {array = "u"}', domain=None)
        formula = self.solve(head + 'conductivity = "3 + x"', domain=None)
        for ours, theirs in zip(array["fluxes"], formula["fluxes"]):
            self.assertAlmostEqual(ours["inflow"], theirs["inflow"], places=10)
        other = self.solve(head.replace("k.vtu", "mesh.vtu") + 'conductivity = {array = "u", file = "k.vtu"}',
                           domain=None)
        self.assertEqual(array["fluxes"], other["fluxes"])


class NonlinearAndTransient(SolveTest):
    def test_conductivity_that_depends_on_u(self):
        # kappa = 1 + u on [0, 1] from 0 to 1: u + u^2/2 = 3/2 x.
        text = ('[equation]\nconductivity = "1 + u"\n[boundary.2]\ntype = "dirichlet"\nvalue = 1\n'
                '[boundary.4]\ntype = "dirichlet"\nvalue = 0\n[exact]\nu = "sqrt(1 + 3*x) - 1"\n')
        coarse, fine = (self.solve(text, size=size) for size in (0.1, 0.025))
        self.assertLess(fine["errors"]["max"], coarse["errors"]["max"] / 8)
        self.assert_balanced(fine)
        self.assertIn("Newton", self.output)
        residuals = [step["residual"] for step in fine["newton"]["steps"]]
        self.assertLess(residuals[-1], 1e-12)
        self.assertLess(len(residuals), 10)

    def test_the_first_guess_chooses(self):
        # -u'' = -u^3 + u has the solutions 0, 1 and -1 with insulated walls.
        text = '[equation]\nsource = "u - u^3"\n[newton]\ninitial = '
        for guess, u in [("0.8", 1), ('"-0.9 + 0*x"', -1)]:
            figures = self.solve(text + guess)
            self.assertAlmostEqual(figures["solution"]["min"], u, places=10)
            self.assertAlmostEqual(figures["solution"]["max"], u, places=10)

    def test_no_convergence_is_exit_code_4(self):
        self.case('[equation]\nsource = "-exp(3*u) + 50"\n[boundary.others]\ntype = "dirichlet"\nvalue = 0\n'
                  '[newton]\nmax_steps = 1\n[output]\nmesh = "u.vtu"')
        before = self.names()
        self.fail_with(4, "solve", "case.toml", words="solve.not_converged")
        self.case('[boundary.others]\ntype = "dirichlet"\nvalue = "exp(x)"\n[output]\nmesh = "u.vtu"\n'
                  '[linear]\nmethod = "conjugate-gradients"\nmax_iterations = 2', size=0.05)
        self.fail_with(4, "solve", "case.toml", words="solve.not_converged")
        self.assertEqual(self.names(), before)

    def test_decay_in_time_with_both_schemes(self):
        # u = exp(-2 pi^2 t) sin(pi x) sin(pi y) in a fine mesh; order in time on one and the same mesh.
        u = "exp(-2*pi^2*t)*sin(pi*x)*sin(pi*y)"
        for scheme, ratio in [("backward-euler", 1.8), ("crank-nicolson", 3)]:
            worst = []
            for step in (0.02, 0.01, 0.0005):
                figures = self.solve(
                    '[boundary.others]\ntype = "dirichlet"\nvalue = 0\n[time]\nend = 0.1\nstartup_steps = 0\n'
                    f'step = {step}\nscheme = "{scheme}"\ninitial = "sin(pi*x)*sin(pi*y)"\n[exact]\nu = "{u}"', size=0.1)
                worst.append(figures["solution"]["max"])
                self.assertEqual(figures["time"]["steps"], round(0.1 / step))
                for row in figures["time"]["series"]:
                    self.assert_balanced(row)
            self.assertGreater(abs(worst[0] - worst[2]) / abs(worst[1] - worst[2]), ratio, scheme)
            self.assertLess(abs(worst[2] - math.exp(-0.2 * math.pi**2)), 0.02)

    def test_linear_growth_in_time_is_exact_and_written(self):
        figures = self.solve('[equation]\ncapacity = 2.0\nsource = 6\n'
                             '[boundary.others]\ntype = "dirichlet"\nvalue = "x + 3*t"\n'
                             '[time]\nend = 2\nstep = 0.25\ninitial = "x"\n[exact]\nu = "x + 3*t"\n'
                             '[output]\nmesh = "out/u.vtu"\ncells = "out/cells.vtu"\nfluxes = "f.csv"\nevery = 0.5')
        self.assertLess(figures["errors"]["max"], 1e-12)
        files = [dataset.get("file")
                 for dataset in xml.etree.ElementTree.parse(self.folder / "out/u.pvd").getroot().iter("DataSet")]
        self.assertEqual(files, [f"u_{i:04}.vtu" for i in range(5)])
        self.assertIn("u.pvd, 5 states", self.output)
        for i, file in enumerate(files):
            mesh = meshio.read(self.folder / "out" / file)
            numpy.testing.assert_allclose(mesh.point_data["u"], mesh.points[:, 0] + 1.5 * i, atol=1e-12)
        with open(self.folder / "f.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual({row["time"] for row in rows}, {str(row["time"]).removesuffix(".0")
                                                         for row in figures["time"]["series"]})
        self.assertEqual(sorted(path.name for path in (self.folder / "out").iterdir()),
                         sorted(files + ["u.pvd", "cells.pvd"] + [f"cells_{i:04}.vtu" for i in range(5)]))

    def test_states_are_written_where_they_are_due(self):
        text = ('[boundary.others]\ntype = "dirichlet"\nvalue = 0\n'
                '[time]\nend = 1\nstartup_steps = 0\nstep = {}\ninitial = 1\n[output]\nmesh = "u.vtu"\n{}')
        for step, every, times in [(0.1, "every = 0.1", [k / 10 for k in range(11)]),
                                   (0.25, "every = 0.3", [0, 0.5, 0.75, 1]), (0.1, "every = 3", [0, 1]),
                                   (0.1, "", [0, 1])]:
            self.solve(text.format(step, every))
            root = xml.etree.ElementTree.parse(self.folder / "u.pvd").getroot()
            numpy.testing.assert_allclose([float(dataset.get("timestep")) for dataset in root.iter("DataSet")], times,
                                          rtol=1e-12)

    def test_adaptive_steps_grow(self):
        figures = self.solve('[boundary.others]\ntype = "dirichlet"\nvalue = 0\n'
                             '[time]\nend = 1\nstep = 1e-4\ntolerance = 1e-4\ninitial = "x*(1-x)*y*(1-y)"')
        self.assertGreater(figures["time"]["longest_step"], 10 * figures["time"]["shortest_step"])

    def test_a_well_inside_takes_its_rate(self):
        self.write("well.poly", WELL_POLY)
        figures = self.solve('[boundary.2]\ntype = "dirichlet"\nvalue = 1\n[boundary.9]\ntype = "rate"\ntotal = -3',
                             domain="well.poly", size=0.1)
        fluxes = {flux["marker"]: flux["inflow"] for flux in figures["fluxes"]}
        self.assertAlmostEqual(fluxes[9], -3, places=12)
        self.assertAlmostEqual(fluxes[2], 3, places=10)


class MultigridCases(SolveTest):
    ITERATE = '[linear]\nmethod = "conjugate-gradients"\npreconditioner = "{}"\n'
    PROBLEMS = {
        "jumps": '[equation]\nconductivity = {{1 = 1.0, 2 = {jump}}}\nsource = "x*y"\n'
                 '[boundary.{left}]\ntype = "dirichlet"\nvalue = "1 + y"\n'
                 '[boundary.{right}]\ntype = "robin"\ntransfer = 2\noutside = 5\n',
        "neumann": '[equation]\nmean = 7.0\n'
                   '[boundary.{left}]\ntype = "neumann"\ninflow = -2\n'
                   '[boundary.{right}]\ntype = "neumann"\ninflow = 2\n',
        "nonlinear": '[equation]\nconductivity = "1 + u^2"\n'
                     '[boundary.{left}]\ntype = "dirichlet"\nvalue = 0\n'
                     '[boundary.{right}]\ntype = "dirichlet"\nvalue = 1\n',
        "time": '[time]\nend = 1\nstep = 0.5\n'
                '[boundary.{left}]\ntype = "dirichlet"\nvalue = 0\n'
                '[boundary.{right}]\ntype = "dirichlet"\nvalue = 1\n'}
    DOMAINS = {"halves.poly": (3, 2, 0.03), "boxes.poly": (1, 3, 0.15)}

    def test_solutions_are_those_of_other_preconditioners(self):
        for (name, text), (domain, (left, right, size)) in itertools.product(self.PROBLEMS.items(),
                                                                            self.DOMAINS.items()):
            with self.subTest(name=name, domain=domain):
                text = text.format(left=left, right=right, jump=1e6)
                plain = self.solve(text + self.ITERATE.format("incomplete-cholesky"), domain=domain, size=size)
                self.assertNotIn("multigrid", plain)
                figures = self.solve(text + self.ITERATE.format("multigrid"), domain=domain, size=size)
                self.assertGreaterEqual(len(figures["multigrid"]["unknowns"]), 2)
                self.assertLess(figures["multigrid"]["operator_complexity"], 2)
                if name != "nonlinear":  # The derivative of its conductivity makes the matrix unsymmetric.
                    self.assertNotIn("refused", figures["multigrid"])
                    self.assertEqual(figures["linear"]["preconditioner"], "multigrid")
                    self.assertLessEqual(figures["linear"]["iterations"], 20)
                    self.assertIn("multigrid         ", self.output)
                self.assertLessEqual({"coarsen", "multigrid", "solve"}, set(self.report()["timing_s"]))
                if name != "jumps":  # Where values have the digits, see test_conductivities_that_jump.
                    self.assert_balanced(figures)
                for end in ("min", "max"):
                    self.assertAlmostEqual(figures["solution"][end], plain["solution"][end], places=6)

    def test_it_takes_levels_of_the_users_own(self):
        left, right, size = self.DOMAINS["halves.poly"]
        self.succeed("mesh", "halves.poly", "-o", "coarse.vtu", "--size", str(size))
        self.succeed("refine", "coarse.vtu", "-o", "refined.vtu")
        self.succeed("coarsen", "coarse.vtu", "--levels", "1", "-o", "coarser")
        text = ('[mesh]\nfile = "refined.vtu"\n' + self.PROBLEMS["jumps"].format(left=left, right=right, jump=1e6) +
                '[linear]\nmethod = "conjugate-gradients"\nLINES\n')
        plain = self.solve(text.replace("LINES", 'preconditioner = "incomplete-cholesky"'), domain=None)
        figures = self.solve(text.replace("LINES", 'levels = ["coarse.vtu", "coarser/level-1.node"]'), domain=None)
        self.assertEqual(figures["linear"]["preconditioner"], "multigrid")
        self.assertEqual(len(figures["multigrid"]["unknowns"]), 3)
        self.assertLessEqual(figures["linear"]["iterations"], 20)
        self.assertNotIn("coarsen", self.report()["timing_s"])
        for end in ("min", "max"):
            self.assertAlmostEqual(figures["solution"][end], plain["solution"][end], places=6)
        own = 'levels = ["coarse.vtu"]'
        for change, words in (('levels = ["coarser/level-1.node", "coarse.vtu"]', "not in the next finer mesh"),
                              ('levels = ["nowhere.vtu"]', "nowhere.vtu"),
                              ("levels = []", "array of files"),
                              ("levels = [3]", "array of files"),
                              (own + '\npreconditioner = "diagonal"', "is not multigrid")):
            with self.subTest(change=change):
                self.case(text.replace("LINES", change), domain=None)
                self.fail_with(2, "solve", "case.toml", "-o", "never.vtu", words=[words])
        self.case(text.replace("LINES", own).replace('[mesh]\nfile = "refined.vtu"', ""), "halves.poly", size)
        self.fail_with(2, "solve", "case.toml", words=["linear.levels", "still to be made"])
        self.assertNotIn("never.vtu", self.names())

    def test_finite_elements_take_it_too(self):
        text = 'method = "fem"\n[boundary.others]\ntype = "dirichlet"\nvalue = "1 + x - z"\n[exact]\nu = "1 + x - z"\n'
        figures = self.solve(text + self.ITERATE.format("multigrid"), domain="box.poly", size=0.1)
        self.assertEqual(figures["linear"]["preconditioner"], "multigrid")
        self.assertLess(figures["errors"]["max"], 1e-9)

    def test_large_systems_take_it_unasked(self):
        text = '[boundary.others]\ntype = "dirichlet"\nvalue = "x"\n[exact]\nu = "x"\n'
        large = self.solve(text, size=0.01)
        self.assertGreater(large["linear"]["unknowns"], 10000)
        self.assertEqual(large["linear"]["preconditioner"], "multigrid")
        self.assertLess(large["errors"]["max"], 1e-9)
        self.assertEqual(self.solve(text, size=0.014)["linear"]["preconditioner"], "incomplete Cholesky")
        self.assertEqual(self.solve(text + '[linear]\npreconditioner = "diagonal"\n', size=0.01)["linear"]
                         ["preconditioner"], "diagonal")

    def test_meshes_that_cannot_be_coarsened_take_another(self):
        self.write("square.node", "4 2\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n")
        self.write("square.ele", "2 3\n1 1 2 3\n2 1 3 4\n")
        figures = self.solve('[mesh]\nfile = "square.node"\n[boundary.others]\ntype = "robin"\ntransfer = 1\n'
                             'outside = 3\n' + self.ITERATE.format("multigrid"), domain=None)
        self.assertIn("allows no coarser one", figures["multigrid"]["refused"])
        self.assertIn("multigrid         not used: the boundary", self.output)
        self.assertEqual(figures["linear"]["preconditioner"], "incomplete Cholesky")
        self.assertAlmostEqual(figures["solution"]["min"], 3, places=12)


class Outputs(SolveTest):
    TEXT = '[boundary.others]\ntype = "dirichlet"\nvalue = "x^2 + y"\n[equation]\nsource = "exp(x)"\n'

    def test_files_hold_the_solution(self):
        self.solve(self.TEXT + '[exact]\nu = "x"\n[output]\nmesh = "u.vtu"\ncells = "c.vtu"\nfluxes = "f.csv"')
        mesh, cells = meshio.read(self.folder / "u.vtu"), meshio.read(self.folder / "c.vtu")
        u, error = mesh.point_data["u"], mesh.point_data["error"]
        numpy.testing.assert_array_equal(error, u - mesh.points[:, 0])
        site = numpy.concatenate(cells.cell_data["site"])
        numpy.testing.assert_array_equal(numpy.concatenate(cells.cell_data["u"]), u[site])
        figures = self.report()["solve"]
        self.assertEqual((figures["solution"]["min"], figures["solution"]["max"]), (u.min(), u.max()))
        with open(self.folder / "f.csv", newline="", encoding="utf-8") as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        self.assertEqual(rows, figures["fluxes"])
        for path in ["certificate: ok", "u.vtu", "c.vtu", "f.csv"]:
            self.assertIn(path, self.output)
        for word in ["vertices", "marker", "inflow", "imbalance", "M-matrix", "direct", "W", "H1", "assemble"]:
            self.assertIn(word, self.output)
        report = self.report()
        self.assertEqual((report["command"], report["input"]["dimension"]), ("solve", 2))
        self.assertEqual(report["case"]["sha256"],
                         hashlib.sha256((self.folder / "case.toml").read_bytes()).hexdigest())
        self.assert_certified(report["certificate"])
        self.assertLessEqual({"assemble", "solve", "write", "total"}, set(report["timing_s"]))
        self.assertEqual(figures["linear"]["residuals"][0], 1)
        self.assertLess(figures["linear"]["residual"], 1e-12)

    def test_the_command_line_takes_the_place_of_the_case(self):
        self.solve(self.TEXT + '[output]\nmesh = "u.vtu"\ncells = "c.vtu"', "-o", "other.vtu", "--quiet")
        self.assertEqual(self.output, "")
        self.assertIn("other.vtu", self.names())
        self.assertIn("c.vtu", self.names())
        self.assertNotIn("u.vtu", self.names())

    def test_paths_are_relative_to_the_case(self):
        (self.folder / "sub").mkdir()
        self.case(self.TEXT + '[output]\nmesh = "u.vtu"', domain="../square.poly", name="sub/case.toml")
        self.succeed("solve", "sub/case.toml")
        self.assertEqual(sorted(path.name for path in (self.folder / "sub").iterdir()), ["case.toml", "u.vtu"])

    def test_threads_do_not_matter(self):
        cases = [(self.TEXT, "square.poly", 0.05), (self.TEXT, "box.poly", 0.15),
                 ('method = "fem"\n' + self.TEXT, "box.poly", 0.15),
                 (self.TEXT + '[linear]\nmethod = "conjugate-gradients"\n', "box.poly", 0.15),
                 (self.TEXT + '[linear]\nmethod = "conjugate-gradients"\npreconditioner = "multigrid"\n', "box.poly",
                  0.08),
                 ('[equation]\nconductivity = "1 + u^2"\n[boundary.others]\ntype = "dirichlet"\nvalue = "x"',
                  "box.poly", 0.2)]
        for text, domain, size in cases:
            with self.subTest(text=text, domain=domain):
                self.case(text + '\n[output]\nmesh = "u.vtu"\ncells = "c.vtu"\nfluxes = "f.csv"', domain, size)
                found = []
                for threads in (1, 8):
                    self.succeed("solve", "case.toml", "--threads", threads)
                    found.append([(self.folder / name).read_bytes() for name in ("u.vtu", "c.vtu", "f.csv")])
                self.assertTrue(found[0] == found[1])

    def test_examples_solve(self):
        cases = sorted((SOURCE / "examples/cases").glob("*.toml"))
        self.assertGreaterEqual(len(cases), 2)
        for case in cases:
            with self.subTest(case=case.name):
                self.succeed("solve", case, "-o", "u.vtu", "--report", "report.json")
                self.assertTrue(self.report()["solve"]["matrix"]["m_matrix"])
                self.assert_balanced(self.report()["solve"])

    def test_the_documented_example_solves(self):
        text = (SOURCE / "docs/case.md").read_text(encoding="utf-8")
        example = text.split("```toml\n")[1].split("```")[0]
        self.assertIn("[domain]", example)
        domain = (SOURCE / "examples/domains/plate.poly").read_text()
        self.write("plate.poly", domain)
        self.write("case.toml", example)
        self.succeed("solve", "case.toml")


class Pictures(SolveTest):
    """voropack plot --array."""

    @staticmethod
    def signed_area(data):
        """Of a path of relative moves and lines, y downwards."""
        area, at, start, command, pair = 0, (0, 0), (0, 0), "m", []
        for token in re.findall(r"[mlz]|-?\d+", data):
            if token in "mlz":
                command = token
                if token == "z":
                    area += at[0] * start[1] - start[0] * at[1]
                    at = start
                continue
            pair.append(int(token))
            if len(pair) < 2:
                continue
            to = (at[0] + pair[0], at[1] + pair[1])
            if command == "m":
                start, command = to, "l"
            else:
                area += at[0] * to[1] - to[0] * at[1]
            at, pair = to, []
        return -area / 2

    def test_bands_cover_the_domain_and_lie_where_their_values_are(self):
        self.solve('[boundary.others]\ntype = "dirichlet"\nvalue = "3*x"', "-o", "u.vtu")
        self.succeed("plot", "u.vtu", "--array", "u", "-o", "u.svg", "--report", "report.json")
        self.assertEqual(self.report()["options"]["array"], "u")
        root = xml.etree.ElementTree.parse(self.folder / "u.svg").getroot()
        space = "{http://www.w3.org/2000/svg}"
        paths = [path.get("d") for path in root.iter(f"{space}path") if path.get("fill")]
        areas = [self.signed_area(path) / 1e8 for path in paths]
        self.assertEqual(len(areas), 24, "3 in steps of 0.5 / 4")
        for area in areas:  # Coordinates are whole numbers.
            self.assertAlmostEqual(area, 1 / 24, places=3)
        self.assertAlmostEqual(sum(areas), 1, places=3)
        labels = [text.text for text in root.iter(f"{space}text")]
        self.assertEqual(labels, ["u", "0", "0.5", "1", "1.5", "2", "2.5", "3"])

    def test_constants_are_one_colour(self):
        self.solve('[boundary.others]\ntype = "dirichlet"\nvalue = -7', "-o", "u.vtu")
        self.succeed("plot", "u.vtu", "--array", "u", "-o", "u.svg")
        root = xml.etree.ElementTree.parse(self.folder / "u.svg").getroot()
        paths = [path for path in root.iter("{http://www.w3.org/2000/svg}path") if path.get("fill")]
        self.assertLessEqual(len(paths), 2)

    def test_arrays_that_are_not_there(self):
        self.succeed("mesh", "square.poly", "-o", "a.vtu")
        self.fail_with(2, "plot", "a.vtu", "--array", "spacin", "-o", "a.svg", words='did you mean "spacing"?')
        self.succeed("convert", "a.vtu", "a.node")
        self.fail_with(2, "plot", "a.node", "--array", "u", "-o", "a.svg", words=".vtu")


class Refusals(SolveTest):
    GOOD = '[boundary.1]\ntype = "dirichlet"\nvalue = 1\n'

    def fails(self, text, *words, domain="square.poly"):
        self.case(text, domain)
        before = self.names()
        result = self.fail_with(2, "solve", "case.toml", "-o", "new.vtu", words=words)
        self.assertIn("Fix:", result.stderr)
        self.assertEqual(self.names(), before, "nothing is left behind")

    def test_markers(self):
        self.fails('[boundary.5]\ntype = "dirichlet"\nvalue = 1\n', "case.toml:1:1", "marker 5", "did you mean 4?",
                   "1, 2, 3, 4")
        self.fails(self.GOOD + '[boundary.01]\ntype = "dirichlet"\nvalue = 1\n', "case.toml:4:11", "given twice")
        self.fails('[boundary.wall]\ntype = "dirichlet"\nvalue = 1\n', "case.toml:1:11", "boundary.wall")

    def test_coefficients(self):
        self.fails(self.GOOD + '[equation]\nconductivity = "x - 0.5"', "conductivity", "solve.bad_conductivity", "(0")
        self.fails(self.GOOD + "[equation]\nconductivity = -1", "solve.bad_conductivity", "case.toml")
        self.fails(self.GOOD + "[equation]\nreaction = -1.0", "solve.bad_reaction")
        self.fails(self.GOOD + "[equation]\nconductivity = {1 = 1.0, 7 = 2.0}", "case.toml:5:30", "region 7",
                   "did you mean 1?")
        self.fails(self.GOOD + "[equation]\nconductivity = {7 = 2.0}", "says nothing of region 1")
        self.fails(self.GOOD + "[equation]\nconductivity = nan", "case.formula", "nan")

    def test_formulas(self):
        self.fails(self.GOOD + '[equation]\nsource = "1 + xx"', "case.toml:5:15", "unknown name 'xx'", "column 5",
                   "      ^")
        self.fails(self.GOOD + '[equation]\nsource = "z"', "unknown name 'z'", "x, y, t, u")
        self.fails(self.GOOD + '[equation]\nsource = "t"', "case.toml:5:10", "depends on the time")
        self.fails(self.GOOD + '[equation]\nreaction = "u"', "depends on the solution u")
        self.fails('[boundary.1]\ntype = "dirichlet"\nvalue = "u"', "depends on the solution u")
        self.fails('method = "fem"\n' + self.GOOD + '[equation]\nsource = "u"', "depends on the solution u")
        self.fails('[boundary.1]\ntype = "rate"\ntotal = "x"', "not a function of position")

    def test_conditions(self):
        for method in ["cvm", "fem"]:
            self.fails(f'method = "{method}"\n[equation]\nsource = 1\n', "solve.no_condition", "region")
        self.fails('[boundary.1]\nvalue = 1\n', "case.toml:1:1", "no type")
        self.fails('[boundary.1]\ntype = "dirchlet"\nvalue = 1', "case.toml:2:8", 'did you mean "dirichlet"?')
        self.fails('[boundary.1]\ntype = "robin"\noutside = 1', "no transfer")
        self.fails('[boundary.1]\ntype = "neumann"\nvalue = 1', "no inflow", "unknown key boundary.1.value")
        self.fails('[boundary.1]\ntype = "robin"\noutside = 1\ntransfer = -1', "solve.bad_condition")

    def test_keys_and_types(self):
        self.fails('methd = "cvm"\n' + self.GOOD, "case.toml:1:1", "did you mean method?")
        self.fails(self.GOOD + "[equation]\nconductivty = 1", "case.toml:5:1", "did you mean equation.conductivity?")
        self.fails(self.GOOD + "[linear]\nmethod = \"cg\"", "conjugate-gradients")
        self.fails(self.GOOD + "[linear]\ntolerance = \"small\"", "case.toml:5:13", 'the text "small"')
        self.fails(self.GOOD + "[equation]\nsource = [1, 2]", "case.toml:5:10", "an array")
        self.fails(self.GOOD + "[time]\nstep = 1", "case.toml:4:1", "no end")
        self.fails(self.GOOD + "[time]\nend = -1", "case.contradiction")
        self.fails('method = "fem"\n' + self.GOOD + "[time]\nend = 1", "stationary")
        self.fails(self.GOOD + '[exact]\nu = "x"\ngradient = ["1"]', "1 entries in 2D")
        self.fails(self.GOOD.replace("value = 1", "value = "), "case.toml:3:", "case.syntax")

    def test_all_faults_are_told_together(self):
        self.fails('methd = "cvm"\n[boundary.1]\ntype = "dirchlet"\nvalue = 1\n[equation]\nsorce = 1\n',
                   "equation.source", 'did you mean "dirichlet"', "did you mean method")

    def test_files(self):
        self.fail_with(2, "solve", "nothing.toml", words=["nothing.toml", "case file"])
        self.fails(self.GOOD, "nothing.poly", "io.cannot_open", domain="nothing.poly")
        self.fails(self.GOOD, "[mesh] or [domain]", domain=None)
        self.fails(self.GOOD + '[mesh]\nfile = "a.vtu"\n', "both [mesh] and [domain]")
        self.case(self.GOOD)
        self.fail_with(2, "solve", "case.toml", "-o", "u.node", words=".vtu")
        self.fail_with(2, "solve", "case.toml", "--cells", "u.svg", words=".vtu")
        self.succeed("mesh", "square.poly", "-o", "mesh.vtu")
        self.case(self.GOOD + '[mesh]\nfile = "mesh.vtu"\n', domain=None)
        self.fail_with(2, "solve", "case.toml", "-o", "mesh.vtu", words="cli.overwrites_input")

    def test_arrays(self):
        for size, name in [(0.2, "a"), (0.1, "b")]:
            self.succeed("mesh", "square.poly", "-o", f"{name}.vtu", "--size", size)
        head = self.GOOD + '[mesh]\nfile = "a.vtu"\n[equation]\nconductivity = '
        self.fails(head + '{array = "spacing", file = "b.vtu"}', "case.toml:7:16", "case.wrong_length", "spacing",
                   domain=None)
        self.fails(head + '{array = "spacign"}', "io.no_such_array", 'did you mean "spacing"', domain=None)
        self.fails(self.GOOD + '[equation]\nsource = {array = "f"}', "still to be made")

    def test_a_mesh_that_is_not_delaunay(self):
        # Two triangles across the wrong diagonal of a kite.
        self.write("kite.node", "4 2\n1 0 0\n2 2 -0.5\n3 4 0\n4 2 0.5\n")
        self.write("kite.ele", "2 3\n1 1 2 3\n2 1 3 4\n")
        text = '[mesh]\nfile = "kite.node"\n[boundary.others]\ntype = "dirichlet"\nvalue = "x"\n'
        self.fails(text, "case.not_delaunay", "kite.node", "negative area", 'method = "fem"', domain=None)
        figures = self.solve('method = "fem"\n' + text + '[exact]\nu = "x"', domain=None)
        self.assertLess(figures["errors"]["max"], 1e-14)
        self.assertNotIn("W", figures["errors"])
        figures = self.solve(text + '[exact]\nu = "x"', "--redelaunay", domain=None)
        self.assertLess(figures["errors"]["max"], 1e-14)
        self.assertTrue(figures["matrix"]["m_matrix"])
        self.assertTrue(self.report()["options"]["redelaunay"])
        self.case(self.GOOD)
        self.fail_with(2, "solve", "case.toml", "--redelaunay", words="[mesh]")

    def test_a_mesh_of_nothing(self):
        self.write("none.node", "0 2 0 0\n")
        self.write("none.ele", "0 3 0\n")
        for method in ["cvm", "fem"]:
            self.fails(f'method = "{method}"\n[mesh]\nfile = "none.node"\n', "none.node", "case.empty_mesh", domain=None)

    def test_numbers_beyond_what_a_computer_holds(self):
        for equation in ["source = 1e308", "conductivity = 1e308\nsource = 1", "conductivity = 1e-300\nsource = 1e10"]:
            self.case(f"{self.GOOD}[equation]\n{equation}")
            before = self.names()
            self.fail_with(4, "solve", "case.toml", "-o", "new.vtu", words="solve.overflow")
            self.assertEqual(self.names(), before)
        self.fails(self.GOOD + "[equation]\nsource = 1e999", "case.toml:5:", "case.syntax")
        self.case(self.GOOD, size=5e-324)
        self.fail_with(2, "solve", "case.toml", words="spacing.bad_size")
        self.fails("a = " + "[" * 100000, "case.syntax", domain=None)
        self.fails("", "[mesh] or [domain]", domain=None)
        self.case(self.GOOD + "[time]\nend = 1e300\nstep = 1")
        self.fail_with(3, "solve", "case.toml", words="1e+300 time steps are needed")

    def test_conductivities_that_jump(self):
        # Two materials in series: the smaller conductivity takes all of the drop. Flows are differences of values,
        # and values of 1 in the better conductor have few digits left for theirs.
        for jump, (left, right) in itertools.product((1e12, 1e-12), ((0.0, 1.0), (1.0, 0.0))):
            figures = self.solve(f'[equation]\nconductivity = {{1 = 1.0, 2 = {jump}}}\n'
                                 f'[boundary.3]\ntype = "dirichlet"\nvalue = {left}\n'
                                 f'[boundary.2]\ntype = "dirichlet"\nvalue = {right}\n', domain="halves.poly")
            flow = 1 / (1 + 1 / jump)
            self.assertTrue(figures["matrix"]["m_matrix"])
            closed, into_right, into_left = (flux["inflow"] for flux in figures["fluxes"])
            self.assertEqual(closed, 0)
            for inflow, balance, value, conductivity in zip((into_left, into_right), figures["balances"], (left, right),
                                                            (1, jump)):
                rounding = max(1e-12 * flow, 100 * sys.float_info.epsilon * conductivity * value)
                self.assertAlmostEqual(inflow, flow if value else -flow, delta=rounding)
                self.assertLess(abs(balance["imbalance"]), rounding)

    def test_help(self):
        text = self.succeed("solve", "--help").stdout
        for word in ["CASE", "--output", "--cells", "--fluxes", "--report", "docs/case.md",
                     "Example: voropack solve heat.toml"]:
            self.assertIn(word, text)


if __name__ == "__main__":
    unittest.main()
