"""Hostile numbers, files, disks and options: an error that says where, what and how to mend it, and nothing left behind."""
import re
import resource
import subprocess
import unittest

from harness import PROGRAM, CommandLineTest, box_poly, square_poly

TETRAHEDRON = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"


class Refusals(CommandLineTest):
    def refused(self, name, text, words):
        """The domain is refused with a file, an id and a remedy, within a few seconds, and leaves nothing."""
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        result = self.fail_with(2, "mesh", name, "-o", "out/a.vtu", "--report", "out/r.json", words=words, timeout=20)
        self.assertIn(name, result.stderr)
        self.assertRegex(result.stderr, r"\[(io|domain)\.\w+\]\n  Fix: \w+")
        self.assertEqual(self.names(), [name])
        (self.folder / name).unlink()
        return result

    def test_geometry_without_a_volume(self):
        square = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n"
        self.refused("flat.poly", square + "2 0\n1\n3 1 2 3\n1\n3 1 3 4\n0\n0\n", "domain.open_boundary")
        self.refused("line.poly", "3 2 0 0\n1 0 0\n2 1 0\n3 2 0\n3 0\n1 1 2\n2 2 3\n3 3 1\n0\n", "domain.open_boundary")
        self.refused("collinear.poly", "3 3 0 0\n1 0 0 0\n2 1 0 0\n3 2 0 0\n1 0\n1\n3 1 2 3\n0\n0\n",
                     ("collinear.poly:6:", "domain.zero_size_facet"))
        self.refused("point.poly", "1 3 0 0\n1 0 0 0\n0 0\n0\n0\n", "domain.empty")
        self.refused("point.node", "1 2 0 0\n1 0 0\n", "domain.empty")
        self.refused("thin.poly", box_poly((0, 0, 0), (1, 1, 1e-12)), "domain.zero_size_facet")

    def test_two_facets_at_the_same_place(self):
        lines = box_poly().splitlines()
        facets = lines.index("6 1")
        lines[facets] = "7 1"
        lines[facets + 13:facets + 13] = ["1 0 7", lines[facets + 2]]
        self.refused("twice.poly", "\n".join(lines), ("twice.poly:23:", "facet 1", "facet 7", "domain.self_intersection"))

    def test_coordinates_beyond_what_is_resolved(self):
        self.refused("far.poly", box_poly((1e15, 0, 0), (1e15 + 8, 8, 8)), "domain.too_far")
        self.refused("large.poly", square_poly(1e61), "domain.too_large")
        self.refused("small.poly", square_poly(1e-61), "domain.too_small")

    def test_counts_that_no_file_holds(self):
        self.refused("a.poly", "2147483648 3 0 0\n1 0 0 0\n", ("a.poly:1:", "2147483648", "io.bad_count"))
        self.refused("b.poly", "99999999999999999999 3 0 0\n", ("b.poly:1:", "io.bad_number"))
        self.refused("c.poly", TETRAHEDRON + "1 0\n2000000000 0\n3 1 2 3\n", ("c.poly:7:", "io.bad_count"))
        self.refused("d.off", "OFF\n2147483647 2147483647 0\n0 0 0\n", ("d.off:2:", "io.bad_count"))
        self.refused("e.stl", b"x" * 80 + (2**31).to_bytes(4, "little") + b"\0" * 100, "io.truncated")
        header = "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\n"
        self.refused("f.ply", header + "property float z\nend_header\n", ("f.ply:3:", "io.bad_count"))

    def test_bytes_that_are_no_text(self):
        for name, text in [("a.poly", b"\xff\xfe\x80\0 3 0 0\n\xc3\x28\n"), ("b.poly", b"4 3 0 0\n1 0 0 \xff\xfe\n"),
                           ("c.obj", b"v \xff\xfe 0 0\n"), ("d.off", b"OFF\0\0\0" * 50), ("e.poly", b"")]:
            with self.subTest(name=name):
                self.refused(name, text, name)

    def test_options(self):
        self.write("box.poly", box_poly())
        for threads in ["-1", "100000", "x", "1.5", ""]:
            self.fail_with(2, "mesh", "box.poly", "-o", "a.vtu", "--threads", threads, words=("--threads", "0 to 4096"))
        self.fail_with(3, "mesh", "box.poly", "-o", "a.vtu", "--max-vertices", "5", words="raise --max-vertices to")
        self.assertEqual(self.names(), ["box.poly"])


class Range(CommandLineTest):
    def test_the_ends_of_the_range_are_meshed_and_certified(self):
        for exponent in (-59, 60):
            with self.subTest(exponent=exponent):
                size = float(f"1e{exponent}")
                self.write("box.poly", box_poly(hi=(size, size, size)))
                self.write("square.poly", square_poly(size))
                self.succeed("mesh", "box.poly", "-o", "a.vtu")
                self.succeed("mesh", "square.poly", "-o", "a.vtu")

    def test_far_from_the_origin_is_meshed_and_certified(self):
        far = 1e11
        self.write("box.poly", box_poly((far, -far, far), (far + 8, 8 - far, far + 8)))
        self.succeed("mesh", "box.poly", "-o", "a.vtu")

    def test_more_threads_than_processors_are_no_matter_for_words(self):
        self.write("box.poly", box_poly())
        one = self.succeed("mesh", "box.poly", "-o", "a.node", "--size", "0.2", "--no-progress", "--threads", "1")
        many = self.succeed("mesh", "box.poly", "-o", "b.node", "--size", "0.2", "--no-progress", "--threads",
                            "64")
        self.assertEqual(many.stderr, one.stderr)
        self.assertEqual((self.folder / "a.ele").read_bytes(), (self.folder / "b.ele").read_bytes())


class FullDisk(CommandLineTest):
    def test_no_half_file_is_left(self):
        """A limit on the size of files stands for a full disk: writing fails in the middle, too."""
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "whole.node", "--size", "0.15", "--cells", "whole.vtu")
        before = self.names()
        for arguments in [["mesh", "box.poly", "--size", "0.15", "-o", "new/a.vtu"],
                          ["mesh", "box.poly", "--size", "0.15", "-o", "a.vtu", "--cells", "new/cells.vtu"],
                          ["mesh", "box.poly", "--size", "0.15", "-o", "./whole.node"],
                          ["convert", "whole.node", "a.vtu"]]:
            with self.subTest(arguments=arguments):
                result = subprocess.run(
                    [PROGRAM, *arguments], cwd=self.folder, text=True, capture_output=True, timeout=120,
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, re.compile(r"File too large  \[io\.cannot_write\]\n  Fix: \w+"))
                self.assertNotIn(".voropack-", result.stderr, "the place is named as the user named it")
                self.assertEqual(self.names(), before)


class Inputs(CommandLineTest):
    def test_the_points_beside_a_domain_are_not_overwritten(self):
        lines = square_poly().splitlines()
        self.write("a.node", "\n".join(lines[:5]) + "\n")
        self.write("a.poly", "0 2 0 0\n" + "\n".join(lines[5:]) + "\n")
        before = (self.folder / "a.node").read_bytes()
        self.fail_with(2, "mesh", "a.poly", "-o", "a.node", words="a.node is the input and the output")
        self.assertEqual((self.folder / "a.node").read_bytes(), before)
        self.succeed("mesh", "a.poly", "-o", "b.node")

    def test_a_mesh_beside_a_domain_with_its_own_points_is_replaced(self):
        self.write("a.poly", square_poly())
        self.succeed("mesh", "a.poly", "-o", "a.node")
        self.succeed("mesh", "a.poly", "-o", "a.node", "--size", "0.2")


if __name__ == "__main__":
    unittest.main()
