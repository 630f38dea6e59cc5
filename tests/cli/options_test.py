"""Help, versions, and what is said of wrong options, before any work."""
import unittest

from harness import CommandLineTest, box_poly

COMMANDS = ["mesh", "check", "stats", "convert", "plot"]


class Help(CommandLineTest):
    def test_program_names_every_command_and_exit_code(self):
        text = self.succeed("--help").stdout
        for word in COMMANDS + ["130 interrupted", "70 a fault of ours", "Example:"]:
            self.assertIn(word, text)

    def test_each_command_has_help_with_an_example(self):
        for command in COMMANDS:
            text = self.succeed(command, "--help").stdout
            self.assertIn(f"Example: voropack {command} ", text)
            for option in ["--report", "--threads", "--seed", "--quiet", "--no-progress", "--verbose"]:
                self.assertIn(option, text, command)

    def test_mesh_help_shows_defaults(self):
        text = self.succeed("mesh", "--help").stdout
        for default in [r"B=0\.\d", r"A=0\.\d", "FORM=voronoi", r"E=0\.25", "KIND=lattice", "N=100000000", r"DEG=0\.1"]:
            self.assertRegex(text, default)

    def test_version(self):
        self.assertRegex(self.succeed("--version").stdout, r"^voropack \d+\.\d+\.\d+")


class WrongOptions(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("box.poly", box_poly())

    def fails(self, *arguments, words=()):
        before = self.names()
        self.assertEqual(self.fail_with(2, *arguments, words=words).stdout, "")
        self.assertEqual(self.names(), before, "nothing is left behind")

    def test_unknown_names_come_with_the_nearest_known_one(self):
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--sise", "1", words=["'--sise'", "did you mean '--size'"])
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--gradaton=1", words="did you mean '--gradation'")
        self.fails("check", "box.node", "--domian", "box.poly", words="did you mean '--domain'")
        self.fails("mehs", "box.poly", words="did you mean 'mesh'")
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--packing", "vornoi", words="did you mean 'voronoi'")
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--interior", "latice", words="did you mean 'lattice'")

    def test_wrong_values(self):
        for option, values in {
            "--size": ["0", "-1", "nan", "inf", "1e999", "abc", ""],
            "--spacing": ["0", "-0.5", "NaN"],
            "--gradation": ["0", "0.41", "-1"],
            "--feature-factor": ["0", "1.01"],
            "--epsilon": ["0", "1.5", "-0.1"],
            "--threads": ["-1", "1.5", "x"],
            "--seed": ["-1", "x"],
            "--max-vertices": ["0", "-5", "1.5"],
            "--region-size": ["1", "1=0", "=1", "1=nan", "a=1"],
            "--marker-size": ["1", "1=-2"],
        }.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.fails("mesh", "box.poly", "-o", "a.vtu", option, value, words=option)

    def test_missing_and_superfluous_arguments(self):
        self.fails(words="subcommand is required")
        self.fails("mesh", "box.poly", words="--output is required")
        self.fails("mesh", "-o", "a.vtu", words="DOMAIN is required")
        self.fails("mesh", "box.poly", "other.poly", "-o", "a.vtu", words="other.poly")
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--size", words="--size")
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--region-size", "1=1", "--region-size", "1=2", words="two sizes")

    def test_unknown_formats_are_found_before_reading(self):
        self.fails("mesh", "missing.poly", "-o", "a.vtk", words=["'.vtk'", ".vtu"])
        self.fails("mesh", "missing.poly", "-o", "a", words="unknown format")
        self.fails("mesh", "missing.poly", "-o", "a.vtu", "--cells", "a.node", words="unknown format")
        self.fails("convert", "missing.node", "a.msh", words="unknown format")
        self.fails("plot", "missing.node", "-o", "a.png", words="unknown format")

    def test_unknown_region_and_marker(self):
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--region-size", "99=0.1", words="99")
        self.fails("mesh", "box.poly", "-o", "a.vtu", "--marker-size", "99=0.1", words="99")

    def test_bad_size_expression(self):
        for expression in ["0.1+", "0.1*w", "(", ""]:
            self.fails("mesh", "box.poly", "-o", "a.vtu", "--size-expr", expression)

    def test_too_many_vertices_is_a_limit(self):
        self.fail_with(3, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.05", "--max-vertices", "100", words="100")
        self.fail_with(3, "mesh", "box.poly", "-o", "a.vtu", "--size", "1e-7", timeout=60)
        self.assertEqual(self.names(), ["box.poly"])


if __name__ == "__main__":
    unittest.main()
