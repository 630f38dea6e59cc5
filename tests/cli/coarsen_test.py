"""`coarsen` writes nested, certified levels with their interpolation."""
import math
import shutil
import unittest

from harness import CommandLineTest, read_table, two_boxes_poly, write_table


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

    def test_levels_have_the_numbers_of_vertices_that_were_asked_for(self):
        self.succeed("coarsen", "fine.node", "--target-nodes", "200,60", "-o", "out", "--report", "report.json")
        levels = self.report()["levels"]
        self.assertEqual(len(levels), 2)
        for level, wanted in zip(levels, (200, 60)):
            self.assertLessEqual(level["vertices"], wanted)
            self.assertGreaterEqual(level["vertices"], 0.7 * wanted)
            self.assert_certified(level["certificate"])
        self.assertLess(levels[0]["growth"], levels[1]["growth"])

    def test_intersections_are_counted(self):
        self.succeed("coarsen", "fine.node", "--levels", "1", "--intersections", "-o", "out", "--report", "report.json")
        counts = self.report()["levels"][0]["intersections"]
        self.assertGreater(counts["mean"], 1)
        self.assertLess(counts["mean"], counts["max"])
        self.assertLess(counts["max"], 400)

    def test_the_domain_may_be_named(self):
        self.succeed("coarsen", "fine.node", "--domain", "two.poly", "--levels", "2", "-o", "out", "--report",
                     "report.json")
        self.assertEqual(self.report()["options"]["domain"], "two.poly")
        for k, level in enumerate(self.report()["levels"], 1):
            self.assert_certified(level["certificate"])
            self.succeed("check", f"out/level-{k}.node", "--domain", "two.poly")
        self.succeed("refine", "fine.node", "--domain", "two.poly", "-o", "finer.node", "--quiet")
        longer = two_boxes_poly()
        for point in range(9, 13):
            longer = longer.replace(f"\n{point} 2 ", f"\n{point} 3 ")
        self.write("other.poly", longer)
        for command in (["coarsen", "-o", "no"], ["refine", "-o", "no.node"]):
            result = self.run_program(command[0], "fine.node", "--domain", "other.poly", *command[1:])
            self.assertEqual(result.returncode, 2)
            self.assertIn("mesh.other_domain", result.stderr)

    def test_no_level_of_an_earlier_hierarchy_stays(self):
        self.succeed("coarsen", "fine.node", "--levels", "3", "-o", "out", "--quiet")
        out = self.folder / "out"
        for name in ("level-04.node", "level-9.vtu", "notes-2.txt"):
            (out / name).write_text("the user's own")
        earlier = {path.name for path in out.iterdir()}
        self.fail_with(2, "coarsen", "missing.node", "--levels", "1", "-o", "out")
        self.assertEqual({path.name for path in out.iterdir()}, earlier)
        result = self.succeed("coarsen", "fine.node", "--levels", "1", "-o", "out")
        self.assertIn("removed: level 2, 3 of an earlier hierarchy there", result.stdout)
        self.assertEqual({path.name for path in out.iterdir()},
                         {name for name in earlier if not name.startswith(("level-2.", "level-3.", "prolongation-2.",
                                                                           "prolongation-3."))})
        self.assertNotIn("removed", self.succeed("coarsen", "fine.node", "--levels", "1", "-o", "out").stdout)

    def test_no_folder_is_named_where_nothing_is_written(self):
        self.succeed("mesh", "two.poly", "-o", "coarse.node", "--quiet")
        result = self.succeed("coarsen", "coarse.node", "--levels", "2", "-o", "none")
        self.assertIn("0 of 2 levels", result.stdout)
        self.assertNotIn("levels: none", result.stdout)
        self.assertFalse((self.folder / "none").exists())

    def test_unknown_choices_are_told_the_known_ones(self):
        for option, words in (("--order", "must be one of curve, front, random, not 'foo'"),
                              ("--initial", "must be one of mean-edge, nearest, not 'foo'")):
            self.fail_with(2, "coarsen", "fine.node", "-o", "out", option, "foo", words=words)
        text = self.succeed("coarsen", "--help").stdout
        self.assertNotIn("ENUM", text)
        self.assertIn("--order curve|front|random", text)

    def test_bad_options_are_refused(self):
        for bad in (["--growth", "1"], ["--levels", "0"], ["--lipschitz", "1"], ["--initial", "what"]):
            result = self.run_program("coarsen", "fine.node", "-o", "out", *bad)
            self.assertEqual(result.returncode, 2, result.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_levels_go_beyond_the_boundary(self):
        self.succeed("coarsen", "fine.node", "--beyond-boundary", "--levels", "2", "-o", "out", "--report", "report.json")
        levels = self.report()["levels"]
        self.assertEqual(len(levels), 2)
        for k, level in enumerate(levels, 1):
            self.assert_certified(level["certificate"])
            self.assertLessEqual(level["area_change"], 0.02)
            claims = ["--packing", "maximal", "--epsilon", repr(level["epsilon"])] if "epsilon" in level else []
            self.succeed("check", f"out/level-{k}.node", *claims)
        n_wanted = levels[1]["vertices"]
        self.succeed("coarsen", "fine.node", "--beyond-boundary", "--target-nodes", str(n_wanted), "-o", "one",
                     "--report", "report.json")
        self.assertLessEqual(self.report()["levels"][0]["vertices"], n_wanted)
        self.fail_with(2, "coarsen", "fine.node", "--beyond-boundary", "--target-nodes", "10,20", "-o", "no",
                       words="coarsen.bad_option")

    def test_options_beyond_the_boundary_need_it(self):
        for option in (["--improve", "free"], ["--feature-angle", "30"], ["--restarts", "2"]):
            self.fail_with(2, "coarsen", "fine.node", "-o", "out", *option, words="--beyond-boundary")


def gear(n=48, depth=0.1):
    """The corners of a disk whose rim goes in and out: no three of them are on a line."""
    points = []
    for i in range(n):
        r = 1 - depth * (i % 2)
        points.append((r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n)))
    return points


def polygon_poly(points, marker):
    n = len(points)
    lines = [f"{n} 2 0 0"] + [f"{i} {x!r} {y!r}" for i, (x, y) in enumerate(points, 1)]
    lines += [f"{n} 1"] + [f"{i + 1} {i + 1} {(i + 1) % n + 1} {marker}" for i in range(n)]
    return "\n".join(lines + ["0", ""])


class CoarsenBeyond(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("gear.poly", polygon_poly(gear(), 3))
        self.succeed("mesh", "gear.poly", "-o", "fine.node", "--size", "0.08", "--quiet")

    def assert_whole(self, n_levels, *options):
        """Levels that are nested, conforming to their own boundaries, and of the gear's area. Returns the report's."""
        self.succeed("coarsen", "fine.node", "--beyond-boundary", "-o", "out", "--report", "report.json", *options)
        levels = self.report()["levels"]
        self.assertEqual(len(levels), n_levels)
        fine = read_table(self.folder / "fine.node")[1]
        finer = set(range(len(fine)))
        for k, level in enumerate(levels, 1):
            header, points = read_table(self.folder / "out" / f"level-{k}.node")
            index = [int(row[4]) for row in points]
            for row, i in zip(points, index):
                self.assertEqual(row[1:3], fine[i][1:3])
            self.assertEqual(len(set(index)), len(index))
            self.assertLessEqual(set(index), finer)
            finer = set(index)
            checks = {check["name"]: check["ok"] for check in level["certificate"]["checks"]}
            for name in ("delaunay", "conformity", "protecting_balls", "dual_nonnegative", "volume_sum", "closure"):
                self.assertTrue(checks[name], name)
            self.assertLessEqual(level["area_change"], 0.05)
            edges = read_table(self.folder / "out" / f"level-{k}.edge")[1]
            self.assertEqual({row[-1] for row in edges}, {"3"})
        return levels

    def test_the_boundary_is_simplified_within_its_distance(self):
        # Within the boundary all of its 48 corners stay.
        levels = self.assert_whole(2, "--target-nodes", "110,40", "--max-area-change", "0.05")
        self.assertLessEqual(levels[1]["vertices"], 40)
        self.assertGreater(levels[1]["boundary_distance"], 0)
        self.assertLess(levels[1]["boundary_distance"], 0.3)

    def test_improvement_says_what_it_gave_up(self):
        free = self.assert_whole(1, "--target-nodes", "120")
        packed = self.assert_whole(1, "--target-nodes", "120", "--improve", "packed")
        none = self.assert_whole(1, "--target-nodes", "120", "--improve", "none")
        self.assertGreater(free[0]["largest_overlap"], 0)
        self.assertEqual(packed[0]["largest_overlap"], 0)
        self.assertEqual(none[0]["exchanges"], 0)
        for level in (free[0], packed[0]):
            self.assertGreater(level["exchanges"], 0)
            self.assertGreater(level["angle_deg"]["min"], none[0]["angle_deg"]["min"])

    def test_corners_beyond_the_feature_angle_stay(self):
        levels = self.assert_whole(2, "--levels", "2", "--feature-angle", "20", "--improve", "packed")
        kept = {(float(row[1]), float(row[2])) for row in read_table(self.folder / "out" / "level-2.node")[1]}
        self.assertLessEqual(set(gear()), kept)
        self.assertEqual(levels[1]["largest_overlap"], 0)
        self.assertAlmostEqual(levels[1]["boundary_distance"], 0, places=12)

    def test_levels_take_boundaries_of_the_users_own(self):
        self.write("round.poly", polygon_poly(gear()[::2], 9))
        self.succeed("coarsen", "fine.node", "--levels", "2", "--level-boundary", "2=round.poly", "-o", "out",
                     "--report", "report.json")
        levels = self.report()["levels"]
        for level in levels:
            self.assert_certified(level["certificate"])
        self.assertEqual([level["boundary_distance"] == 0 for level in levels], [True, False])
        markers = {row[-1] for row in read_table(self.folder / "out" / "level-2.edge")[1]}
        self.assertEqual(markers, {"9"})
        self.succeed("check", "out/level-2.node", "--domain", "round.poly")
        self.write("off.poly", polygon_poly([(1, 0), (0, 0.3), (-0.2, -0.7)], 1))
        self.fail_with(2, "coarsen", "fine.node", "--level-boundary", "1=off.poly", "-o", "no",
                       words="coarsen.level_boundary")
        for bad in ("0=round.poly", "round.poly", "9=round.poly"):
            self.fail_with(2, "coarsen", "fine.node", "--level-boundary", bad, "-o", "no")

    def test_vertices_of_no_simplex_are_left_out(self):
        header, points = read_table(self.folder / "fine.node")
        write_table(self.folder / "loose.node", [int(header[0]) + 1, *header[1:]],
                    [*points, [len(points) + 1, 0.012345, 0.023456, *points[-1][3:]]])
        for extension in ("ele", "edge"):
            shutil.copy(self.folder / f"fine.{extension}", self.folder / f"loose.{extension}")
        for beyond in ([], ["--beyond-boundary"]):
            self.succeed("coarsen", "loose.node", "--levels", "2", "-o", "out", *beyond)
            for k in (1, 2):
                index = {int(row[4]) for row in read_table(self.folder / "out" / f"level-{k}.node")[1]}
                self.assertNotIn(len(points), index)

    def test_meshes_that_are_no_delaunay_triangulations_are_refused(self):
        header, rows = read_table(self.folder / "fine.ele")
        twice = [*rows, [len(rows) + 1, *rows[0][1:]]]
        write_table(self.folder / "twice.ele", [len(twice), *header[1:]], twice)
        points_header, points = read_table(self.folder / "fine.node")
        # The last vertex is inside; moved far away it turns its triangles over.
        moved = [*points[:-1], [points[-1][0], "0.5", "0.5", *points[-1][3:]]]
        for name, vertices in (("twice", points), ("over", moved)):
            write_table(self.folder / f"{name}.node", points_header, vertices)
            shutil.copy(self.folder / "fine.edge", self.folder / f"{name}.edge")
        shutil.copy(self.folder / "fine.ele", self.folder / "over.ele")
        for name in ("twice", "over"):
            for beyond in ([], ["--beyond-boundary"]):
                self.fail_with(2, "coarsen", f"{name}.node", "-o", "no", *beyond)
        self.assertFalse((self.folder / "no").exists())
        # A kite with the wrong diagonal.
        write_table(self.folder / "kite.node", [4, 2, 0, 0], [[1, 0, 0], [2, 1, -0.2], [3, 2, 0], [4, 1, 0.2]])
        write_table(self.folder / "kite.ele", [2, 3, 0], [[1, 1, 2, 3], [2, 1, 3, 4]])
        self.fail_with(2, "coarsen", "kite.node", "-o", "no", words="coarsen.not_delaunay")
        self.fail_with(2, "coarsen", "kite.node", "-o", "no", "--beyond-boundary", words="coarsen.not_delaunay")
        self.succeed("coarsen", "kite.node", "-o", "anew", "--redelaunay")


if __name__ == "__main__":
    unittest.main()
