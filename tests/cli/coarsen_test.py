"""`coarsen` writes nested, certified levels with their interpolation."""
import unittest

from harness import CommandLineTest, read_table, two_boxes_poly


class Coarsen(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("two.poly", two_boxes_poly())
        self.succeed("mesh", "two.poly", "-o", "fine.node", "--size", "0.12", "--quiet")

    def test_levels_are_nested_and_certified(self):
        self.succeed("coarsen", "fine.node", "--levels", "3", "-o", "out", "--report", "report.json")
        levels = self.report()["levels"]
        self.assertGreaterEqual(len(levels), 2)
        fine = read_table(self.folder / "fine.node")[1]
        finer = set(range(len(fine)))
        for k, level in enumerate(levels, 1):
            self.assert_certified(level["certificate"])
            header, points = read_table(self.folder / "out" / f"level-{k}.node")
            self.assertEqual(header[:3], [str(level["vertices"]), "3", "2"])
            index = [int(row[5]) for row in points]
            for row, i in zip(points, index):
                self.assertEqual(row[1:4], fine[i][1:4])
            self.assertEqual(len(set(index)), len(index))
            self.assertLess(set(index), finer)
            finer = set(index)
            regions = {row[-1] for row in read_table(self.folder / "out" / f"level-{k}.ele")[1]}
            self.assertEqual(regions, {"1", "2"})
            self.succeed("check", f"out/level-{k}.node", "--domain", "two.poly")

    def test_the_interpolation_is_exact_for_linear_functions(self):
        self.succeed("coarsen", "fine.node", "--levels", "1", "-o", "out", "--quiet")
        lines = (self.folder / "out" / "prolongation-1.mtx").read_text().splitlines()
        self.assertEqual(lines[0], "%%MatrixMarket matrix coordinate real general")
        fine = [[float(x) for x in row[1:4]] for row in read_table(self.folder / "fine.node")[1]]
        coarse = [[float(x) for x in row[1:4]] for row in read_table(self.folder / "out" / "level-1.node")[1]]
        self.assertEqual([int(x) for x in lines[1].split()], [len(fine), len(coarse), len(lines) - 2])
        x = [[0.0] * 4 for _ in fine]
        for line in lines[2:]:
            i, j, value = line.split()
            for k, coordinate in enumerate([*coarse[int(j) - 1], 1]):
                x[int(i) - 1][k] += float(value) * coordinate
        for found, wanted in zip(x, fine):
            for a, b in zip(found, [*wanted, 1]):
                self.assertAlmostEqual(a, b, places=9)

    def test_bad_options_are_refused(self):
        for bad in (["--growth", "1"], ["--levels", "0"], ["--lipschitz", "1"], ["--initial", "what"]):
            result = self.run_program("coarsen", "fine.node", "-o", "out", *bad)
            self.assertEqual(result.returncode, 2, result.stderr)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    unittest.main()
