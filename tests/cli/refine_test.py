"""`refine` keeps every vertex to the bit, refines where it is told to, and refuses what it cannot keep."""
import unittest

from harness import CommandLineTest, read_table, two_boxes_poly


class Refine(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("two.poly", two_boxes_poly())
        self.succeed("mesh", "two.poly", "-o", "coarse.node", "--size", "0.3", "--quiet")

    def points(self, name):
        return [tuple(row[1:4]) for row in read_table(self.folder / name)[1]]

    def refined(self, *options):
        self.succeed("refine", "coarse.node", "-o", "fine.node", "--report", "report.json", *options)
        report = self.report()
        self.assert_certified(report["certificate"])
        return report

    def test_levels_keep_all_vertices(self):
        for levels in (1, 2):
            report = self.refined("--levels", str(levels))
            coarse, fine = self.points("coarse.node"), self.points("fine.node")
            self.assertLess(set(coarse), set(fine))
            self.assertEqual(report["refinement"],
                             {"kept": len(coarse), "added": len(fine) - len(coarse), "removed": 0})
            self.assertEqual({row[-1] for row in read_table(self.folder / "fine.ele")[1]}, {"1", "2"})
            self.succeed("check", "fine.node", "--domain", "two.poly")

    def test_one_level_halves_the_spacing(self):
        self.refined()
        fine = {tuple(row[1:4]): float(row[4]) for row in read_table(self.folder / "fine.node")[1]}
        for row in read_table(self.folder / "coarse.node")[1]:
            self.assertAlmostEqual(fine[tuple(row[1:4])], float(row[4]) / 2, places=12)

    def test_places(self):
        self.write("well.txt", "# a well\n0.5 0.5 0\n0.5, 0.5, 1\n")
        for option in (["--ball", "0.5,0.5,0.5,0.1=0.05"], ["--box", "0.4,0.4,0.4,0.6,0.6,0.6=0.05"],
                       ["--near", "well.txt=0.05"], ["--region-size", "1=0.1"], ["--marker-size", "1=0.1"],
                       ["--size-expr", "0.1+0.2*x"]):
            report = self.refined(*option)
            self.assertEqual(report["refinement"]["removed"], 0)
            self.assertGreater(report["refinement"]["added"], 20)
        self.refined("--levels", "0")
        self.assertEqual(len(self.points("fine.node")), len(self.points("coarse.node")))

    def test_the_spacing_grows_where_vertices_may_go(self):
        report = self.refined("--keep", "fitting", "--size", "0.6")
        figures, n = report["refinement"], len(self.points("coarse.node"))
        self.assertGreater(figures["removed"], n // 4)
        self.assertEqual(figures["kept"] + figures["removed"], n)
        self.assertEqual(len(self.points("fine.node")), figures["kept"] + figures["added"])
        self.succeed("check", "fine.node", "--domain", "two.poly")
        # A fine place moves.
        self.refined("--size", "0.3", "--ball", "0.5,0.5,0.5,0.1=0.08")
        (self.folder / "fine.node").rename(self.folder / "coarse.node")
        for end in ("ele", "face", "edge"):
            (self.folder / f"fine.{end}").rename(self.folder / f"coarse.{end}")
        figures = self.refined("--keep", "fitting", "--size", "0.3", "--ball", "1.5,0.5,0.5,0.1=0.08")["refinement"]
        for count in figures.values():
            self.assertGreater(count, 20)
        # Levels are counted from the mesh's own spacing.
        self.assertEqual(self.refined("--keep", "fitting", "--levels", "0", "--size", "0.6")["refinement"]["removed"], 0)

    def test_sizes_that_change_nothing_are_said_to(self):
        result = self.succeed("refine", "coarse.node", "-o", "fine.node", "--size", "1")
        self.assertIn(" 0 added, 0 removed", result.stdout)
        self.assertIn("--keep fitting", result.stdout)
        self.assertNotIn("--keep fitting", self.succeed("refine", "coarse.node", "-o", "fine.node").stdout)

    def test_vertices_of_no_simplex_are_left_out(self):
        header, rows = read_table(self.folder / "coarse.node")
        n = len(rows)
        row = [str(n + 1), "0.123", "0.234", "0.345", *rows[-1][4:]]
        self.write("loose.node", "\n".join(" ".join(line) for line in [[str(n + 1), *header[1:]], *rows, row]) + "\n")
        for ending in ("ele", "face", "edge"):
            self.write(f"loose.{ending}", (self.folder / f"coarse.{ending}").read_text())
        result = self.succeed("refine", "loose.node", "-o", "fine.node", "--report", "report.json")
        self.assertIn(f"1 vertex of no simplex: {n} (counted from 0)", result.stdout)
        self.assertEqual(self.report()["refinement"]["unused"], 1)
        self.assertNotIn(tuple(row[1:4]), self.points("fine.node"))
        expected = (self.folder / "fine.node").read_bytes()
        self.refined()
        self.assertEqual((self.folder / "fine.node").read_bytes(), expected)
        self.write("case.toml", '[mesh]\nfile = "loose.node"\n[boundary.others]\ntype = "dirichlet"\nvalue = "x"\n'
                   '[exact]\nu = "x"\n')
        result = self.succeed("solve", "case.toml", "-o", "u.vtu", "--report", "report.json")
        self.assertIn(f"1 vertex of no simplex: {n} (counted from 0)", result.stdout)
        self.assertLess(self.report()["solve"]["errors"]["max"], 1e-9)

    def test_a_ball_has_no_negative_radius(self):
        self.fail_with(2, "refine", "coarse.node", "-o", "fine.node", "--ball", "1,0,0,-0.5=0.1",
                       words="a ball has the radius -0.5")

    def test_progress_can_be_silenced(self):
        self.write("needle.poly", "3 2 0 0\n1 0 0\n2 1 0\n3 1 0.05\n3 1\n1 1 2 1\n2 2 3 2\n3 3 1 3\n0\n")
        self.assertIn("round", self.succeed("mesh", "needle.poly", "-o", "needle.node").stderr)
        self.assertEqual(self.succeed("mesh", "needle.poly", "-o", "needle.node", "--no-progress").stderr, "")

    def test_what_cannot_stay(self):
        result = self.run_program("refine", "coarse.node", "-o", "fine.node", "--ball", "0.5,0.5=0.1")
        self.assertEqual(result.returncode, 2)
        self.assertIn("4 numbers", result.stderr)
        result = self.run_program("refine", "coarse.node", "-o", "fine.node", "--near", "nothing.txt=0.1")
        self.assertEqual(result.returncode, 2)
        self.assertFalse((self.folder / "fine.node").exists())

    def test_a_mesh_that_fails_its_certificate(self):
        header, rows = read_table(self.folder / "coarse.node")
        inside = next(i for i, row in enumerate(rows) if row[-1] == "0")
        x = rows[inside]
        x[1] = str(float(x[1]) + 0.06)
        text = " ".join(header) + "\n" + "\n".join(" ".join(row) for row in rows) + "\n"
        self.write("moved.node", text)
        for ending in ("ele", "face", "edge"):
            self.write(f"moved.{ending}", (self.folder / f"coarse.{ending}").read_text())
        result = self.run_program("refine", "moved.node", "-o", "fine.node")
        self.assertEqual(result.returncode, 2)
        self.assertIn("certificate", result.stderr)
        self.succeed("refine", "moved.node", "-o", "fine.node", "--redelaunay", "--force", "--report", "report.json")
        self.assertLess(set(self.points("moved.node")), set(self.points("fine.node")))

    def test_a_boundary_with_few_markers(self):
        """Faces without a condition often have no marker: a marker of its own, which they keep."""
        header, rows = read_table(self.folder / "coarse.face")
        dropped = rows[0][-1]
        for row in rows:
            row[-1] = "0" if row[-1] == dropped else row[-1]
        n_dropped = sum(row[-1] == "0" for row in rows)
        self.assertTrue(0 < n_dropped < len(rows))
        self.write("plain.face", " ".join(header) + "\n" + "\n".join(" ".join(row) for row in rows) + "\n")
        for ending in ("node", "ele", "edge"):
            self.write(f"plain.{ending}", (self.folder / f"coarse.{ending}").read_text())
        self.succeed("check", "plain.node")
        self.succeed("coarsen", "plain.node", "--levels", "1", "-o", "plain", "--quiet")
        self.succeed("refine", "plain.node", "-o", "fine.node")
        fine = [row[-1] for row in read_table(self.folder / "fine.face")[1]]
        self.assertGreater(fine.count("0"), n_dropped)
        # The domain gives the new mesh its markers.
        self.succeed("refine", "plain.node", "-o", "fine.node", "--domain", "two.poly")
        self.assertNotIn("0", [row[-1] for row in read_table(self.folder / "fine.face")[1]])

    def test_it_composes_with_coarsen(self):
        self.refined()
        self.succeed("coarsen", "fine.node", "--levels", "1", "-o", "levels", "--quiet")
        self.succeed("refine", "levels/level-1.node", "-o", "again.node", "--report", "report.json")
        self.assert_certified(self.report()["certificate"])
        self.assertLess(set(self.points("levels/level-1.node")), set(self.points("again.node")))

    def test_threads_do_not_matter(self):
        self.refined("--threads", "1")
        one = (self.folder / "fine.node").read_bytes()
        self.refined("--threads", "8")
        self.assertEqual((self.folder / "fine.node").read_bytes(), one)


if __name__ == "__main__":
    unittest.main()
