"""Ctrl-C ends a run within about a second, with 130, and leaves nothing."""
import signal
import subprocess
import time
import unittest

from harness import PROGRAM, CommandLineTest, box_poly

PATIENCE = 20  # Seconds that a loaded machine may need to stop; the program itself gives up after one.


class Interrupt(CommandLineTest):
    MESH = ["mesh", "box.poly", "-o", "new/a.vtu", "-o", "a.node", "--report", "r.json", "--size", "0.01"]

    def interrupt_after(self, seconds, number=signal.SIGINT, arguments=MESH):
        self.write("box.poly", box_poly())
        self.write("a.ele", "old")
        before = self.names()
        process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(seconds)
        self.assertIsNone(process.poll(), "the run is long enough to be interrupted")
        process.send_signal(number)
        try:
            out, err = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            self.fail(f"did not stop within {PATIENCE} s")
        self.assertEqual(process.returncode, 128 + number, err)
        self.assertEqual(out, "")
        self.assertIn("interrupted", err)
        self.assertEqual(self.names(), before)
        self.assertEqual((self.folder / "a.ele").read_text(), "old")

    def test_at_once(self):
        self.interrupt_after(0.3)

    def test_in_the_middle(self):
        self.interrupt_after(2)

    def test_termination(self):
        self.interrupt_after(1, signal.SIGTERM)

    def test_a_solution_in_time(self):
        self.write("case.toml", '[domain]\nfile = "box.poly"\nsize = 0.2\n[time]\nend = 1\nstep = 1e-6\n'
                                '[boundary.others]\ntype = "dirichlet"\nvalue = "t"\n'
                                '[output]\nmesh = "new/u.vtu"\ncells = "cells.vtu"\nevery = 1e-5\n')
        self.interrupt_after(1.5, arguments=["solve", "case.toml", "--fluxes", "f.csv", "--report", "r.json"])


class Progress(CommandLineTest):
    def test_without_a_terminal_a_long_run_says_a_line_now_and_then(self):
        self.write("box.poly", box_poly())
        process = subprocess.Popen([PROGRAM, "mesh", "box.poly", "-o", "a.vtu", "--size", "0.01"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = process.stderr.readline()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)
        self.assertRegex(line, r"^\w+ .* s$")


if __name__ == "__main__":
    unittest.main()
