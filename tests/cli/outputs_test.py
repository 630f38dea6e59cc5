"""Files appear whole or not at all; errors say where; streams hold what belongs to them."""
import os
import subprocess
import unittest

from harness import PROGRAM, CommandLineTest, box_poly, square_poly


class Streams(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("box.poly", box_poly())

    def test_results_go_to_standard_output(self):
        result = self.succeed("mesh", "box.poly", "-o", "a.vtu", "--size", "0.5")
        for word in ["vertices", "radius/edge", "certificate: ok", "a.vtu"]:
            self.assertIn(word, result.stdout)
        self.assertNotIn("\x1b", result.stdout + result.stderr, "no escape codes without a terminal")

    def test_quiet_says_nothing_but_errors(self):
        result = self.succeed("mesh", "box.poly", "-o", "a.vtu", "--size", "0.5", "--quiet")
        self.assertEqual((result.stdout, result.stderr), ("", ""))
        self.fail_with(2, "mesh", "missing.poly", "-o", "a.vtu", "--quiet", words="missing.poly")

    def test_verbose_tells_the_time_of_stages(self):
        result = self.succeed("mesh", "box.poly", "-o", "a.vtu", "--size", "0.5", "--verbose")
        self.assertRegex(result.stderr, r"packing took [\d.]+ s")

    def test_a_full_standard_output_is_an_error_and_leaves_no_file(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([PROGRAM, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.5"], cwd=self.folder,
                                    stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("standard output", result.stderr)
        self.assertEqual(self.names(), ["box.poly"])

    def test_a_closed_pipe_is_no_error(self):
        read_end, write_end = os.pipe()
        os.close(read_end)
        result = subprocess.run([PROGRAM, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.5"], cwd=self.folder,
                                stdout=write_end, stderr=subprocess.PIPE, text=True)
        os.close(write_end)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("a.vtu", self.names())


class Files(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("box.poly", box_poly())

    def test_all_outputs_of_one_run(self):
        self.succeed("mesh", "box.poly", "-o", "deep/er/a.vtu", "-o", "a.node", "--cells", "cells.vtu", "--report",
                     "r.json", "--size", "0.5")
        for name in ["a.node", "a.ele", "a.face", "cells.vtu", "r.json", "deep"]:
            self.assertIn(name, self.names())
        self.assertTrue((self.folder / "deep/er/a.vtu").stat().st_size > 100)
        self.assertFalse([name for name in self.names() if name.startswith(".")], "no hidden leftovers")

    def test_places_that_cannot_be_written_to_are_found_before_the_work(self):
        self.write("file", "text")
        for place in ["file/a.vtu", "/proc/nowhere/a.vtu", "/dev/null/a.vtu"]:
            self.fail_with(2, "mesh", "box.poly", "-o", place, "--size", "0.001", words=place, timeout=20)
        self.fail_with(2, "mesh", "box.poly", "-o", "a.vtu", "--report", "file/r.json", words="file/r.json")
        self.assertEqual(self.names(), ["box.poly", "file"])

    def test_a_full_device_is_an_error_and_stays_a_device(self):
        self.fail_with(2, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.5", "--report", "/dev/full",
                       words="/dev/full") if os.path.exists("/dev/full") else self.skipTest("no /dev/full")
        self.assertFalse(os.path.isfile("/dev/full"))

    def test_the_input_is_never_overwritten(self):
        self.succeed("mesh", "box.poly", "-o", "a.node", "--size", "0.5")
        before = (self.folder / "a.node").read_bytes()
        self.fail_with(2, "convert", "a.node", "a.node", words="input and the output")
        self.fail_with(2, "mesh", "box.poly", "-o", "a.vtu", "-o", "./a.vtu", words="twice")
        self.fail_with(2, "stats", "a.node", "--report", "a.node", words="input and the output")
        for outputs in (["-o", "a.node"], ["-o", "b.node", "-o", "./a.node"], ["-o", "b.vtu", "--report", "a.ele"]):
            self.fail_with(2, "refine", "a.node", *outputs, words="input and the output")
        self.fail_with(2, "refine", "a.node", "--domain", "box.poly", "-o", "b.node", "--report", "box.poly",
                       words="input and the output")
        self.succeed("mesh", "box.poly", "-o", "sizes.node", "--size", "0.6")
        self.fail_with(2, "refine", "a.node", "--size-field", "sizes.node", "-o", "sizes.node",
                       words="input and the output")
        self.assertEqual((self.folder / "a.node").read_bytes(), before)

    def test_a_hierarchy_is_never_written_over_its_input(self):
        self.succeed("mesh", "box.poly", "-o", "a.node", "--size", "0.2")
        self.succeed("coarsen", "a.node", "-o", "levels", "--levels", "3")
        before = {path.name: path.read_bytes() for path in (self.folder / "levels").iterdir()}
        self.assertIn("level-3.node", before)
        # Level 1 would be written over, level 3 removed.
        for level in (1, 3):
            self.fail_with(2, "coarsen", f"levels/level-{level}.node", "-o", "levels", "--levels", "1",
                           words="input and the output")
        self.assertEqual({path.name: path.read_bytes() for path in (self.folder / "levels").iterdir()}, before)

    def test_a_failed_run_keeps_the_old_file(self):
        self.write("a.vtu", "old")
        self.fail_with(2, "mesh", "missing.poly", "-o", "a.vtu")
        self.fail_with(3, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.01", "--max-vertices", "10")
        self.assertEqual((self.folder / "a.vtu").read_text(), "old")


class WrongInputs(CommandLineTest):
    def fails(self, name, text, command=("mesh",), words=()):
        path = self.write(name, text) if isinstance(text, str) else self.folder / name
        if isinstance(text, bytes):
            path.write_bytes(text)
        before = self.names()
        arguments = [*command, name]
        if command[0] == "mesh":
            arguments += ["-o", "out.vtu", "--report", "out.json"]
        result = self.fail_with(2, *arguments, words=words)
        self.assertEqual(self.names(), before)
        return result

    def test_missing_files(self):
        for arguments in [["mesh", "no.poly", "-o", "a.vtu"], ["check", "no.node"], ["stats", "no.vtu"],
                          ["convert", "no.node", "a.vtu"], ["plot", "no.node", "-o", "a.svg"]]:
            self.fail_with(2, *arguments, words="no.")
        self.assertEqual(self.names(), [])

    def test_unknown_input_formats(self):
        self.fails("a.step", "text", words="a.step")
        self.fails("noextension", "text")
        self.fails("a.dat", "text", command=("check",))

    def test_truncated_domains(self):
        for name, text in [("square.poly", square_poly()), ("box.poly", box_poly())]:
            for part in (0, 0.1, 0.3, 0.5, 0.7):
                with self.subTest(name=name, part=part):
                    self.fails(name, text[: int(len(text) * part)], words=name)

    def test_truncated_meshes(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "a.node", "-o", "a.vtu", "--size", "0.6")
        whole = {name: (self.folder / name).read_bytes() for name in ["a.node", "a.ele", "a.vtu"]}
        for name, text in whole.items():
            read = "a.vtu" if name == "a.vtu" else "a.node"
            for part in (0, 0.02, 0.3, 0.9):
                with self.subTest(name=name, part=part):
                    (self.folder / name).write_bytes(text[: int(len(text) * part)])
                    self.fail_with(2, "check", read, words=name)
            (self.folder / name).write_bytes(text)

    def test_binary_garbage(self):
        garbage = bytes((i * 97 + 13) % 256 for i in range(5000))
        for name in ["a.poly", "a.smesh", "a.off", "a.stl", "a.obj", "a.ply"]:
            with self.subTest(name=name):
                self.fails(name, garbage, words=name)
        for name in ["a.vtu", "a.node"]:
            with self.subTest(name=name):
                self.fails(name, garbage, command=("stats",), words="a.")

    def test_an_open_box_is_refused_with_its_fault(self):
        lines = box_poly().splitlines()
        lines[9] = "5 1"
        del lines[10:12]
        self.fails("open.poly", "\n".join(lines), words="[domain.")

    def test_points_that_are_not_finite(self):
        self.fails("nan.poly", square_poly().replace("2 1 0", "2 nan 0", 1), words="nan.poly")

    def test_a_3d_mesh_cannot_be_plotted(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "a.node", "--size", "0.6")
        self.fail_with(2, "plot", "a.node", "-o", "a.svg", words="2D")
        self.assertNotIn("a.svg", self.names())


if __name__ == "__main__":
    unittest.main()
