"""Ctrl-C ends a run within about a second, with 130, and leaves nothing."""
import signal
import subprocess
import time
import unittest

from harness import PROGRAM, CommandLineTest, box_poly

PATIENCE = 20  # Seconds that a loaded machine may need to stop; the program itself gives up after one.


class Interrupt(CommandLineTest):
    def interrupt_after(self, seconds, number=signal.SIGINT):
        self.write("box.poly", box_poly())
        self.write("a.ele", "old")
        process = subprocess.Popen([PROGRAM, "mesh", "box.poly", "-o", "new/a.vtu", "-o", "a.node", "--report", "r.json",
                                    "--size", "0.01"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True)
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
        self.assertEqual(self.names(), ["a.ele", "box.poly"])
        self.assertEqual((self.folder / "a.ele").read_text(), "old")

    def test_at_once(self):
        self.interrupt_after(0.3)

    def test_in_the_middle(self):
        self.interrupt_after(2)

    def test_termination(self):
        self.interrupt_after(1, signal.SIGTERM)


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
