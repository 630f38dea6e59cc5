"""What the tests of the command line share: running the program in a folder of its own, small domains, .node files."""
import itertools
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["VOROPACK"]
SOURCE = pathlib.Path(os.environ["VOROPACK_SOURCE"])

CHECKS = ["packing", "spacing_lipschitz", "voronoi_maximal", "delaunay", "conformity", "protecting_balls",
          "voronoi_containment", "radius_edge", "dual_nonnegative", "volume_sum", "closure"]


def box_poly(lo=(0, 0, 0), hi=(1, 1, 1)):
    """A box as TetGen .poly, region 1."""
    corners = [tuple(hi[k] if bits[k] else lo[k] for k in range(3)) for bits in itertools.product((0, 1), repeat=3)]
    facets = []
    for axis in range(3):
        for side in (0, 1):
            ids = [i for i, bits in enumerate(itertools.product((0, 1), repeat=3)) if bits[axis] == side]
            facets.append([ids[0], ids[1], ids[3], ids[2]])
    lines = ["8 3 0 0"] + [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(corners)]
    lines += ["6 1"]
    for marker, facet in enumerate(facets, 1):
        lines += [f"1 0 {marker}", "4 " + " ".join(str(i + 1) for i in facet)]
    return "\n".join(lines + ["0", "0", ""])


def box_with_plates_poly(heights):
    """The unit cube with square plates inside, one at each height; their markers are 7, 8, ..."""
    lines = box_poly().split("\n")
    points, facets = lines[1:9], lines[10:22]
    for marker, z in enumerate(heights, 7):
        n = len(points)
        for i, (x, y) in enumerate([(0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7)], n + 1):
            points.append(f"{i} {x} {y} {z}")
        facets += [f"1 0 {marker}", "4 " + " ".join(str(i) for i in range(n + 1, n + 5))]
    return "\n".join([f"{len(points)} 3 0 0", *points, f"{len(facets) // 2} 1", *facets, "0", "0", ""])


def two_boxes_poly():
    """The box [0,2] x [0,1] x [0,1] cut at x = 1: regions 1 and 2."""
    corners = [(x, y, z) for x in (0, 1, 2) for y in (0, 1) for z in (0, 1)]
    number = {corner: i + 1 for i, corner in enumerate(corners)}
    facets = []
    for x in (0, 1, 2):
        facets.append([(x, 0, 0), (x, 1, 0), (x, 1, 1), (x, 0, 1)])
    for x in (0, 1):
        for y in (0, 1):
            facets.append([(x, y, 0), (x + 1, y, 0), (x + 1, y, 1), (x, y, 1)])
        for z in (0, 1):
            facets.append([(x, 0, z), (x + 1, 0, z), (x + 1, 1, z), (x, 1, z)])
    lines = [f"{len(corners)} 3 0 0"] + [f"{number[c]} {c[0]} {c[1]} {c[2]}" for c in corners]
    lines += [f"{len(facets)} 1"]
    for marker, facet in enumerate(facets, 1):
        lines += [f"1 0 {marker}", "4 " + " ".join(str(number[c]) for c in facet)]
    return "\n".join(lines + ["0", "2", "1 0.5 0.5 0.5 1", "2 1.5 0.5 0.5 2", ""])


def square_poly(size=1):
    """A square as Triangle .poly with markers 1 to 4."""
    return "\n".join(["4 2 0 0", "1 0 0", f"2 {size} 0", f"3 {size} {size}", f"4 0 {size}", "4 1", "1 1 2 1", "2 2 3 2",
                      "3 3 4 3", "4 4 1 4", "0", ""])


def read_table(path):
    """Header and rows of a .node, .ele, .face or .edge file, as lists of words."""
    lines = [line.split("#")[0].split() for line in pathlib.Path(path).read_text().splitlines()]
    lines = [line for line in lines if line]
    return lines[0], lines[1:]


def write_table(path, header, rows):
    pathlib.Path(path).write_text("\n".join(" ".join(map(str, line)) for line in [header, *rows]) + "\n")


class CommandLineTest(unittest.TestCase):
    """Each test runs in an empty folder, self.folder."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="voropack test "))  # A space in every path.
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_program(self, *arguments, **options):
        """The finished process, with text streams."""
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True,
                              timeout=options.pop("timeout", 120), **options)

    def succeed(self, *arguments, **options):
        result = self.run_program(*arguments, **options)
        self.assertEqual(result.returncode, 0, f"{arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def fail_with(self, code, *arguments, words=(), **options):
        """Runs, expects the exit code, nothing on standard output, and each of `words` on standard error."""
        result = self.run_program(*arguments, **options)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}\n{result.stderr}")
        self.assertIn("error:", result.stderr)
        for word in [words] if isinstance(words, str) else words:
            self.assertIn(word, result.stderr)
        return result

    def report(self, name="report.json"):
        return json.loads((self.folder / name).read_text())

    def names(self):
        """The names of all files and folders that are there."""
        return sorted(path.name for path in self.folder.iterdir())

    def assert_certified(self, certificate):
        failed = [check for check in certificate["checks"] if not check["ok"]]
        self.assertTrue(certificate["ok"] and not failed, failed)
        self.assertEqual([check["name"] for check in certificate["checks"]], CHECKS)
