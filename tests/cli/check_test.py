"""`check` accepts what `mesh` made and finds every kind of tampering."""
import unittest

from harness import CommandLineTest, box_poly, read_table, square_poly, two_boxes_poly, write_table


class Check(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("two.poly", two_boxes_poly())
        self.succeed("mesh", "two.poly", "-o", "a.node", "--size", "0.4", "--quiet")

    def table(self, extension):
        return read_table(self.folder / f"a{extension}")

    def failed_checks(self, *options):
        """Runs check, expects failure, and returns the names of the failed checks."""
        result = self.run_program("check", "a.node", "--report", "report.json", *options)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertIn("FAILED", result.stdout)
        report = self.report()
        self.assertFalse(report["certificate"]["ok"])
        self.assertNotEqual(report["certificate"]["checks"], [])
        return {check["name"] for check in report["certificate"]["checks"] if not check["ok"]}

    def test_an_untouched_mesh_passes_with_and_without_its_domain(self):
        self.assertIn("certificate: ok", self.succeed("check", "a.node").stdout)
        self.succeed("check", "a.node", "--domain", "two.poly", "--gradation", "0.2", "--report", "report.json")
        self.assert_certified(self.report()["certificate"])
        self.assertTrue(all(check["tested"] > 0 for check in self.report()["certificate"]["checks"]))

    def test_both_formats_give_the_same_verdict(self):
        self.succeed("convert", "a.node", "b.vtu")
        self.succeed("check", "b.vtu", "--domain", "two.poly")

    def test_a_moved_vertex_is_found(self):
        header, rows = self.table(".node")
        inside = next(row for row in rows if all(0.2 < float(x) % 1 < 0.8 for x in row[1:4]))
        inside[1] = str(float(inside[1]) + 0.2)
        write_table(self.folder / "a.node", header, rows)
        self.assertTrue(self.failed_checks() & {"delaunay", "packing", "conformity"})

    def test_a_dropped_simplex_is_found(self):
        header, rows = self.table(".ele")
        header[0] = str(int(header[0]) - 1)
        del rows[len(rows) // 2]
        rows = [[str(i + 1), *row[1:]] for i, row in enumerate(rows)] if rows[0][0] == "1" else [
            [str(i), *row[1:]] for i, row in enumerate(rows)]
        write_table(self.folder / "a.ele", header, rows)
        self.assertTrue(self.failed_checks("--domain", "two.poly"))
        self.assertTrue(self.failed_checks())

    def test_a_swapped_region_is_found(self):
        header, rows = self.table(".ele")
        row = rows[len(rows) // 2]
        row[-1] = "2" if row[-1] in ("1", "1.0") else "1"
        write_table(self.folder / "a.ele", header, rows)
        self.assertTrue(self.failed_checks("--domain", "two.poly"))
        self.assertTrue(self.failed_checks())

    def test_duplicated_interface_vertices_are_found(self):
        """The two regions come apart: each has its own copy of the vertices on the interface."""
        node_header, nodes = self.table(".node")
        ele_header, elements = self.table(".ele")
        first = int(nodes[0][0])
        copies = {}
        for row in list(nodes):
            if float(row[1]) == 1:
                copies[row[0]] = str(len(nodes) + first)
                nodes.append([copies[row[0]], *row[1:]])
        self.assertTrue(copies)
        for row in elements:
            if row[-1] == "2":
                row[1:5] = [copies.get(corner, corner) for corner in row[1:5]]
        node_header[0] = str(len(nodes))
        write_table(self.folder / "a.node", node_header, nodes)
        write_table(self.folder / "a.ele", ele_header, elements)
        self.assertTrue(self.failed_checks("--domain", "two.poly"))

    def test_a_simplex_given_twice_is_found(self):
        header, rows = self.table(".ele")
        write_table(self.folder / "a.ele", [str(int(header[0]) + 1), *header[1:]],
                    [*rows, [str(int(rows[-1][0]) + 1), *rows[0][1:]]])
        self.assertEqual(self.failed_checks(), {"conformity"})
        self.fail_with(2, "stats", "a.node", words="[mesh.")

    def test_a_wrong_spacing_is_found(self):
        header, rows = self.table(".node")
        rows[-1][4] = str(5 * float(rows[-1][4]))
        write_table(self.folder / "a.node", header, rows)
        self.assertTrue(self.failed_checks("--gradation", "0.2") & {"packing", "spacing_lipschitz"})

    def test_places_far_from_the_origin_can_be_told_apart(self):
        self.write("far.node", "4 2 0 0\n1 1e6 1e6\n2 1000001 1e6\n3 1000001 1000001\n4 1e6 1000001\n")
        self.write("far.ele", "2 3 0\n1 1 2 3\n2 1 3 4\n")
        self.succeed("check", "far.node", "--report", "report.json")
        places = " ".join(check.get("where", "") for check in self.report()["certificate"]["checks"])
        self.assertIn("(1000001, 1000000)", places)
        self.assertNotIn("1e+06", places)

    def test_a_false_claim_of_gradation_is_found(self):
        self.write("square.poly", square_poly())
        self.succeed("mesh", "square.poly", "-o", "a.node", "--size-expr", "0.02+0.4*x", "--gradation", "0.3")
        self.assertIn("spacing_lipschitz", self.failed_checks("--gradation", "0.01"))

    def test_a_mesh_of_another_domain_is_found(self):
        self.write("box.poly", box_poly(hi=(2, 1, 1)))
        self.assertTrue(self.failed_checks("--domain", "box.poly"))
        self.write("square.poly", square_poly())
        self.fail_with(2, "check", "a.node", "--domain", "square.poly", words="dimension")

    def test_without_spacing_the_checks_that_need_it_are_not_tested(self):
        header, rows = self.table(".node")
        write_table(self.folder / "a.node", [header[0], header[1], "0", "0"], [row[:4] for row in rows])
        self.succeed("check", "a.node", "--report", "report.json")
        tested = {check["name"]: check["tested"] for check in self.report()["certificate"]["checks"]}
        for name in ["packing", "spacing_lipschitz", "voronoi_maximal"]:
            self.assertEqual(tested[name], 0, name)
        self.assertGreater(tested["delaunay"], 0)


if __name__ == "__main__":
    unittest.main()
