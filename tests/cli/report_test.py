"""The report of each command: documented keys, right types, figures that agree with each other and with the files."""
import hashlib
import unittest

from harness import CHECKS, CommandLineTest, box_poly, read_table, square_poly, two_boxes_poly


class Report(CommandLineTest):
    def mesh(self, name, text, *options):
        self.write(name, text)
        self.succeed("mesh", name, "-o", "a.node", "--report", "report.json", *options)
        return self.report()

    def assert_numbers(self, value, where=""):
        """No number in a report is infinite or absent: JSON null never stands for one."""
        if isinstance(value, dict):
            for key, inner in value.items():
                self.assert_numbers(inner, f"{where}.{key}")
        elif isinstance(value, list):
            for inner in value:
                self.assert_numbers(inner, where)
        else:
            self.assertIsNotNone(value, where)

    def test_of_a_3d_mesh(self):
        report = self.mesh("two.poly", two_boxes_poly(), "--size", "0.4", "--seed", "5", "--threads", "2")
        self.assertEqual(set(report), {"voropack", "command", "options", "input", "counts", "regions", "quality", "dual",
                                       "packing", "costliest_features", "certificate", "timing_s", "threads",
                                       "peak_memory_bytes"})
        self.assert_numbers(report)
        self.assertEqual(report["command"], "mesh")
        self.assertEqual(report["threads"], 2)
        self.assertEqual(report["options"]["size"], 0.4)
        self.assertEqual(report["options"]["seed"], 5)
        self.assertEqual(report["options"]["packing"], "voronoi")
        digest = hashlib.sha256((self.folder / "two.poly").read_bytes()).hexdigest()
        self.assertEqual(report["input"], {"file": "two.poly", "sha256": digest, "dimension": 3, "points": 12,
                                           "segments": 20, "facets": 11, "regions": 2})
        self.assertEqual([check["name"] for check in report["certificate"]["checks"]], CHECKS)
        self.assertEqual(set(report["quality"]),
                         {"radius_edge", "angle_deg", "dihedral_deg", "edge_length"})
        self.assertEqual(set(report["dual"]), {"volume_sum", "domain_volume", "min_volume", "min_face_area",
                                               "negative_faces", "zero_faces", "zeroed_area", "zeroed_area_bound",
                                               "cell_aspect"})
        self.assertLessEqual(report["dual"]["zeroed_area"], report["dual"]["zeroed_area_bound"])
        self.assertEqual(set(report["dual"]["cell_aspect"]), {"max", "p99", "mean"})
        for stage in ["read", "spacing", "packing", "delaunay", "dual", "quality", "certificate", "write", "total"]:
            self.assertGreaterEqual(report["timing_s"][stage], 0, stage)

    def test_counts_agree_with_the_files(self):
        report = self.mesh("two.poly", two_boxes_poly(), "--size", "0.4")
        counts = report["counts"]
        self.assertEqual(counts["vertices"], int(read_table(self.folder / "a.node")[0][0]))
        self.assertEqual(counts["simplices"], int(read_table(self.folder / "a.ele")[0][0]))
        self.assertEqual(counts["boundary_simplices"], int(read_table(self.folder / "a.face")[0][0]))
        self.assertEqual(sum(region["simplices"] for region in report["regions"]), counts["simplices"])
        self.assertGreater(counts["cells"], counts["vertices"], "a vertex on the interface has two cells")

    def test_volumes_of_regions(self):
        report = self.mesh("two.poly", two_boxes_poly(), "--size", "0.4")
        self.assertEqual([region["id"] for region in report["regions"]], [1, 2])
        for region in report["regions"]:
            self.assertAlmostEqual(region["volume"], 1, places=12)
        self.assertAlmostEqual(report["dual"]["volume_sum"], 2, places=11)

    def test_of_a_2d_mesh(self):
        report = self.mesh("square.poly", square_poly(), "--size", "0.2")
        self.assertEqual(report["input"]["dimension"], 2)
        self.assertNotIn("facets", report["input"])
        self.assertNotIn("dihedral_deg", report["quality"])
        self.assertAlmostEqual(report["dual"]["volume_sum"], 1, places=12)

    def test_of_the_other_commands(self):
        self.mesh("square.poly", square_poly(), "--size", "0.2")
        self.succeed("check", "a.node", "--domain", "square.poly", "--report", "check.json")
        check = self.report("check.json")
        self.assertEqual((check["command"], check["domain"]["points"]), ("check", 4))
        self.assert_certified(check["certificate"])
        self.succeed("stats", "a.node", "--report", "stats.json")
        stats = self.report("stats.json")
        self.assertEqual(stats["counts"], check["counts"])
        self.assertNotIn("certificate", stats)
        self.succeed("convert", "a.node", "b.vtu", "--report", "convert.json")
        self.assertNotIn("quality", self.report("convert.json"))
        self.succeed("plot", "a.node", "-o", "a.svg", "--report", "plot.json")
        self.assertEqual(self.report("plot.json")["command"], "plot")

    def test_stats_prints_histograms(self):
        self.mesh("box.poly", box_poly(), "--size", "0.5")
        text = self.succeed("stats", "a.node").stdout
        for word in ["vertices", "radius/edge", "dihedral angles", "cell aspects", "####"]:
            self.assertIn(word, text)


if __name__ == "__main__":
    unittest.main()
