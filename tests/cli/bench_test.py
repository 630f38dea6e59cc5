"""The benchmark harness on a tiny input: it reaches the count, judges the peers' meshes, and stores every field."""
import json
import os
import pathlib
import subprocess
import sys
import unittest

from harness import PROGRAM, SOURCE, CommandLineTest

sys.path.insert(0, str(SOURCE / "bench"))
import domains  # noqa: E402


class Domains(CommandLineTest):
    def test_a_box_with_a_hole_is_meshed(self):
        domain = domains.box([0, 0, 0], [3, 3, 1], {"lo": [1, 1], "hi": [2, 2]})
        self.assertEqual(domain.measure, 8)
        domain.write(self.folder, "hole")
        self.succeed("mesh", "hole.poly", "-o", "a.node", "--size", "0.8", "--report", "r.json")
        self.assertAlmostEqual(self.report("r.json")["dual"]["volume_sum"], 8, places=10)

    def test_off_and_poly_are_the_same_domain(self):
        domain = domains.box([0, 0, 0], [3, 3, 1], {"lo": [1, 1], "hi": [2, 2]})
        domain.write(self.folder, "hole")
        self.assertAlmostEqual(domains.read_off(self.folder / "hole.off").measure, 8)


class Harness(CommandLineTest):
    def test_a_run(self):
        build = pathlib.Path(PROGRAM).parents[2]
        result = subprocess.run([sys.executable, SOURCE / "bench/run.py", "tiny", "--rounds", "2", "--threads", "1",
                                 "--build", build, "--results", self.folder], text=True, capture_output=True, timeout=280,
                                env={**os.environ, "TMPDIR": str(self.folder)})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        stored = list(self.folder.glob("tiny-300-*.json"))
        self.assertEqual(len(stored), 1)
        found = json.loads(stored[0].read_text())
        for key in ["machine", "threads", "seed", "input_sha256", "wanted_vertices", "rows", "skipped"]:
            self.assertIn(key, found)
        for key in ["compiler", "flags", "cpu", "commit"]:
            self.assertIn(key, found["machine"])
        ours = found["rows"][0]
        self.assertEqual(ours["program"], "voropack")
        self.assertTrue(ours["certificate_ok"], ours)
        self.assertEqual(ours["wall_s"]["runs"], 2)
        self.assertIn("packing", ours["stages_s"])
        self.assertLess(abs(ours["counts"]["vertices"] - 300), 100)
        for row in found["rows"][1:]:
            self.assertGreater(row["time_over_ours"], 0)


if __name__ == "__main__":
    unittest.main()
