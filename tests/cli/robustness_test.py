"""Hostile numbers, files, disks and options: an error that says where, what and how to mend it, and nothing left behind."""
import itertools
import re
import resource
import struct
import subprocess
import unittest

from harness import PROGRAM, CommandLineTest, box_poly, box_with_plates_poly, square_poly

TETRAHEDRON = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
CORNERS = list(itertools.product((0, 1), repeat=3))
CUBE = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6),
        (1, 3, 5), (3, 7, 5)]  # Triangles, seen counterclockwise from outside.


def ply_header(encoding, n_vertices, n_faces, length="uchar"):
    return (f"ply\nformat {encoding} 1.0\nelement vertex {n_vertices}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {n_faces}\nproperty list {length} int vertex_indices\nend_header\n").encode()


def surface_files(triangles):
    """A surface with the corners of the unit cube in every format that has surfaces, by the name of the file."""
    points = "".join("%d %d %d\n" % x for x in CORNERS)
    faces = "".join("3 %d %d %d\n" % t for t in triangles)
    numbered = "".join(f"{i} {x} {y} {z}\n" for i, (x, y, z) in enumerate(CORNERS))
    n = len(triangles)
    stl = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %d %d %d\n" % CORNERS[i] for i in t) +
                  "endloop\nendfacet\n" for t in triangles)
    return {
        "a.off": f"OFF\n8 {n} 0\n{points}{faces}".encode(),
        "a.obj": ("".join("v %d %d %d\n" % x for x in CORNERS) +
                  "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)).encode(),
        "text.stl": f"solid a\n{stl}endsolid a\n".encode(),
        "binary.stl": b"x" * 80 + struct.pack("<I", n) + b"".join(
            struct.pack("<12fH", 0, 0, 0, *(c for i in t for c in CORNERS[i]), 0) for t in triangles),
        "text.ply": ply_header("ascii", 8, n) + (points + faces).encode(),
        "little.ply": ply_header("binary_little_endian", 8, n) + b"".join(
            [struct.pack("<3f", *x) for x in CORNERS] + [struct.pack("<B3i", 3, *t) for t in triangles]),
        "big.ply": ply_header("binary_big_endian", 8, n) + b"".join(
            [struct.pack(">3f", *x) for x in CORNERS] + [struct.pack(">B3i", 3, *t) for t in triangles]),
        "a.poly": f"8 3 0 0\n{numbered}{n} 0\n".encode() + b"".join(
            b"1\n3 %d %d %d\n" % t for t in triangles) + b"0\n0\n",
        "a.smesh": f"8 3 0 0\n{numbered}{n} 0\n{faces}0\n0\n".encode(),
    }


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
        for size in (1e61, 1e150, 1e300, 1.7e308):
            self.refused("large.poly", square_poly(size), "domain.too_large")
            self.refused("large.poly", box_poly(hi=(size, size, size)), "domain.too_large")
            self.refused("far.poly", box_poly((-size, 0, 0), (size, 1, 1)), "domain.too_large")
        for size in (1e-61, 1e-150, 1e-300, 5e-324):
            self.refused("small.poly", square_poly(size), "domain.too_small")
            self.refused("small.poly", box_poly(hi=(size, size, size)), "domain.too_small")
        self.refused("thin.poly", box_poly((0, 0, 0), (1e30, 1, 1)), "domain.zero_size_facet")
        self.refused("beyond.poly", square_poly("1e309"), "beyond.poly:3:")

    def test_parts_without_thickness(self):
        self.refused("flat.poly", box_poly(hi=(1, 1, 0)), "domain.zero_size_facet")
        for gap in (0, 1e-13):
            self.refused("twin.poly", box_with_plates_poly([0.5, 0.5 + gap]),
                         ("facet 7", "facet 8", "domain.self_intersection"))
        for name, text in surface_files(CUBE[:2] + [t[::-1] for t in CUBE[:2]]).items():
            with self.subTest(name=name):  # A square, there and back.
                self.refused(name, text, "domain.self_intersection")

    def test_triangles_that_are_there_twice(self):
        for name, text in surface_files(CUBE + [CUBE[4], CUBE[7][::-1]]).items():
            with self.subTest(name=name):
                self.refused(name, text, "domain.self_intersection")

    def test_domains_without_anything(self):
        for name, text in surface_files([]).items():
            with self.subTest(name=name):
                self.refused(name, text, "domain.empty")
        for name, text in [("a.off", "OFF\n0 0 0\n"), ("a.obj", "# nothing\n"), ("b.stl", b"\0" * 84),
                           ("a.ply", ply_header("ascii", 0, 0))]:
            with self.subTest(name=name):
                self.refused(name, text, "domain.empty")
        nothing_left = box_poly().removesuffix("0\n0\n") + "1\n1 0.5 0.5 0.5\n0\n"
        self.refused("hole.poly", nothing_left, "domain.outside")

    def test_files_cut_at_any_place(self):
        for name, text in surface_files(CUBE).items():
            (self.folder / name).write_bytes(text)
            self.succeed("mesh", name, "-o", "whole.vtu")
            (self.folder / "whole.vtu").unlink()
            ends = text.rfind(b"\n", 0, len(text.rstrip())) if name in ("text.stl", "a.smesh", "a.poly") else len(text)
            for part in range(8):
                with self.subTest(name=name, part=part):
                    self.refused(name, text[:ends * part // 8], name)

    def test_counts_that_no_file_holds(self):
        self.refused("a.poly", "2147483648 3 0 0\n1 0 0 0\n", ("a.poly:1:", "2147483648", "io.bad_count"))
        self.refused("b.poly", "99999999999999999999 3 0 0\n", ("b.poly:1:", "io.bad_number"))
        self.refused("c.poly", TETRAHEDRON + "1 0\n2000000000 0\n3 1 2 3\n", ("c.poly:7:", "io.bad_count"))
        self.refused("d.off", "OFF\n2147483647 2147483647 0\n0 0 0\n", ("d.off:2:", "io.bad_count"))
        self.refused("e.stl", b"x" * 80 + (2**31).to_bytes(4, "little") + b"\0" * 100, "io.truncated")
        self.refused("e.stl", b"x" * 80 + b"\xff" * 4, "io.truncated")
        for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
            for count in (2**31, 2**32 - 1, 2**40):
                self.refused("f.ply", ply_header(encoding, count, 1), ("f.ply:3:", str(count), "io.bad_count"))
                self.refused("f.ply", ply_header(encoding, 0, count), ("f.ply:7:", str(count), "io.bad_count"))
            self.refused("f.ply", ply_header(encoding, 2**64, 1), ("f.ply:3:", "io.bad_number"))
        row = b"\0" * 12 + struct.pack("<I", 2**31)
        self.refused("f.ply", ply_header("binary_little_endian", 1, 1, "uint") + row, (str(2**31), "io.bad_count"))

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
        case = ('[mesh]\nfile = "whole.node"\n[boundary.others]\ntype = "dirichlet"\nvalue = "x"\n'
                '[output]\nmesh = "new/u.vtu"\n')
        self.write("still.toml", case)
        self.write("moving.toml", case + "every = 0.1\n[time]\nend = 1\n")
        before = self.names()
        for arguments in [["mesh", "box.poly", "--size", "0.15", "-o", "new/a.vtu"],
                          ["mesh", "box.poly", "--size", "0.15", "-o", "a.vtu", "--cells", "new/cells.vtu"],
                          ["mesh", "box.poly", "--size", "0.15", "-o", "./whole.node"],
                          ["convert", "whole.node", "a.vtu"],
                          ["solve", "still.toml"], ["solve", "moving.toml", "--cells", "cells.vtu"]]:
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
