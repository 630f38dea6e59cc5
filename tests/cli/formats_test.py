"""Other people's readers agree with us: meshio and VTK read what we write; doubles survive."""
import re
import unittest
import xml.etree.ElementTree

from harness import CommandLineTest, read_table, square_poly, two_boxes_poly

try:
    import meshio
except ImportError:
    meshio = None
try:
    import numpy
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None


class Formats(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("two.poly", two_boxes_poly())
        self.write("square.poly", square_poly())
        self.succeed("mesh", "two.poly", "-o", "a.node", "-o", "a.vtu", "--cells", "c.vtu", "--size", "0.5",
                     "--report", "report.json")

    def test_numbers_survive_a_round_trip(self):
        self.succeed("convert", "a.node", "b.vtu")
        self.succeed("convert", "b.vtu", "c.node")
        for extension in [".node", ".ele", ".face", ".edge"]:
            self.assertEqual(read_table(self.folder / f"a{extension}"), read_table(self.folder / f"c{extension}"))
        self.succeed("convert", "a.vtu", "d.vtu")
        self.assertEqual((self.folder / "a.vtu").read_bytes(), (self.folder / "d.vtu").read_bytes())

    def test_flat_simplices_are_refused_or_go_away(self):
        # The unit square with its middle on one of its diagonals, where a flat triangle closes the mesh.
        self.write("flat.node", "5 2 0 1\n1 0 0 1\n2 1 0 1\n3 1 1 1\n4 0 1 1\n5 0.5 0.5 0\n")
        self.write("flat.ele", "4 3 1\n1 1 2 5 7\n2 2 3 5 7\n3 1 5 3 7\n4 1 3 4 7\n")
        self.write("flat.edge", "4 1\n1 1 2 11\n2 2 3 12\n3 3 4 13\n4 4 1 14\n")
        for command in [["stats", "flat.node"], ["convert", "flat.node", "b.node"]]:
            self.fail_with(2, *command, words=["mesh.flat_simplex", "triangle 3", "--redelaunay"])
        verdict = self.run_program("check", "flat.node")
        self.assertEqual(verdict.returncode, 1, verdict.stderr)
        self.assertIn("triangle 3", verdict.stderr)
        self.succeed("convert", "flat.node", "b.node", "--redelaunay")
        self.assertEqual(len(read_table(self.folder / "b.ele")[1]), 4)
        self.assertEqual(sorted(row[-1] for row in read_table(self.folder / "b.edge")[1]),
                         ["11", "12", "13", "14"])
        for command in ["stats", "check"]:
            self.succeed(command, "flat.node", "--redelaunay", "--report", "report.json")
            report = self.report()
            self.assertAlmostEqual(report["dual"]["volume_sum"], 1, places=14)
            self.assertEqual(report["regions"][0]["id"], 7)
        # Another region beyond an edge that the new triangulation does not have.
        self.write("flat.edge", "5 1\n1 1 2 11\n2 2 3 12\n3 3 4 13\n4 4 1 14\n5 1 3 15\n")
        self.fail_with(2, "stats", "flat.node", "--redelaunay", words=["mesh.boundary_lost", "marker 15"])

    def write_square(self, fifth="0.3 0.5", elements=("1 2 5", "2 6 5", "2 3 6", "3 4 6", "4 5 6", "4 1 5")):
        """A square of six triangles around two points."""
        self.write("s.node", f"6 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 {fifth}\n6 0.7 0.5\n")
        self.write("s.ele", f"{len(elements)} 3 0\n" +
                   "".join(f"{i + 1} {corners}\n" for i, corners in enumerate(elements)))
        self.write("s.edge", "4 1\n1 1 2 11\n2 2 3 12\n3 3 4 13\n4 4 1 14\n")

    def succeed_anew(self, words):
        """The mesh, triangulated anew, is the square again; words are said about its simplices."""
        run = self.succeed("stats", "s.node", "--redelaunay", "--report", "report.json")
        self.assertIn(words, run.stderr)
        self.assertEqual(self.report()["counts"]["simplices"], 6)
        self.assertAlmostEqual(self.report()["dual"]["volume_sum"], 1, places=14)

    def test_duplicate_inverted_and_overlapping_simplices_are_mended(self):
        good = ("1 2 5", "2 6 5", "2 3 6", "3 4 6", "4 5 6", "4 1 5")
        self.write_square(elements=good + ("6 5 2",))
        self.fail_with(2, "stats", "s.node", words=["mesh.nonmanifold", "--redelaunay"])
        self.write_square(elements=good + ("6 5 2", "1 2 5"))
        self.succeed_anew("2 simplices were listed before")
        self.write_square(elements=("1 5 2",) + good[1:])
        self.succeed_anew("1 of 6 simplices had another orientation")
        # All the other way round is another convention.
        self.write_square(elements=[corners[::-1] for corners in good])
        self.assertNotIn("orientation", self.succeed("stats", "s.node", "--redelaunay").stderr)
        # The fifth point beyond the sixth one: triangles around both are folded over.
        self.write_square(fifth="0.9 0.5")
        self.fail_with(2, "stats", "s.node", words=["mesh.overlapping_simplices", "--redelaunay"])
        self.succeed_anew("overlap at")
        # Outside of the square, the point is no part of it.
        self.write_square(fifth="-0.2 0.5")
        self.fail_with(2, "stats", "s.node", "--redelaunay", words=["mesh.boundary_lost"])

    def test_sizes_that_cannot_be_triangulated_are_told(self):
        for size, words in [("1e150", "mesh.too_large"), ("1e-150", "mesh.too_small")]:
            self.write("s.node", f"3 2 0 0\n1 0 0\n2 {size} 0\n3 0 {size}\n")
            self.write("s.ele", "1 3 0\n1 1 2 3\n")
            self.write("s.edge", "0 1\n")
            for command in (["stats", "s.node", "--redelaunay"], ["coarsen", "s.node", "-o", "levels"],
                            ["refine", "s.node", "-o", "fine.node"]):
                result = self.fail_with(2, *command, words=[words, "scale the mesh"])
                self.assertNotIn("--domain", result.stderr)
        self.write("s.ele", "0 3 0\n")
        for command in (["stats", "s.node", "--redelaunay"], ["coarsen", "s.node", "-o", "levels"]):
            self.fail_with(2, *command, words=["mesh.empty"])

    def test_arrays_are_read_by_readers_that_move_them(self):
        """meshio 5.0 gives arrays new offsets from the front of the data on, and looks for the next one by its offset."""
        text = (self.folder / "a.vtu").read_bytes().split(b"<AppendedData")[0].decode()
        offsets = [int(offset) for offset in re.findall(r'offset="(\d+)"', text)]
        self.assertGreater(len(offsets), 5)
        self.assertEqual(offsets, sorted(offsets, reverse=True), "one that was moved must not be found first")

    @unittest.skipIf(meshio is None, "meshio is not installed")
    def test_meshio_reads_the_mesh(self):
        mesh = meshio.read(self.folder / "a.vtu")
        counts = self.report()["counts"]
        self.assertEqual(len(mesh.points), counts["vertices"])
        self.assertEqual(sum(len(block.data) for block in mesh.cells), counts["simplices"])
        for name in ["spacing", "marker", "carrier_dimension"]:
            self.assertIn(name, mesh.point_data)
        self.assertEqual(set(mesh.cell_data["region"][0]), {1, 2})

    def read_vtk(self, name):
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / name))
        reader.Update()
        return reader.GetOutput()

    @unittest.skipIf(vtk is None, "vtk is not installed")
    def test_vtk_agrees_on_the_volumes_of_the_cells(self):
        grid = self.read_vtk("c.vtu")
        self.assertEqual(grid.GetNumberOfCells(), self.report()["counts"]["cells"])
        self.assertEqual(grid.GetCellType(0), vtk.VTK_POLYHEDRON)
        stated = vtk_to_numpy(grid.GetCellData().GetArray("volume"))
        measured = [self.volume_of_convex(grid.GetCell(i)) for i in range(grid.GetNumberOfCells())]
        for own, other in zip(stated, measured):
            self.assertAlmostEqual(own, other, places=12)
        self.assertAlmostEqual(stated.sum(), 2, places=12)

    @staticmethod
    def volume_of_convex(cell):
        """Pyramids over the faces from a point inside; VTK's own integral of polyhedra is good to 1e-3 only."""
        corners = vtk_to_numpy(cell.GetPoints().GetData()).astype(float)
        inside = corners.mean(axis=0)
        volume = 0.0
        for k in range(cell.GetNumberOfFaces()):
            face = vtk_to_numpy(cell.GetFace(k).GetPoints().GetData()).astype(float) - inside
            volume += abs(sum(numpy.dot(face[0], numpy.cross(face[i], face[i + 1])) for i in range(1, len(face) - 1))) / 6
        return volume

    @unittest.skipIf(vtk is None, "vtk is not installed")
    def test_vtk_reads_2d_cells(self):
        self.succeed("mesh", "square.poly", "-o", "s.vtu", "--cells", "sc.vtu", "--size", "0.3")
        grid = self.read_vtk("sc.vtu")
        self.assertEqual(grid.GetCellType(0), vtk.VTK_POLYGON)
        self.assertAlmostEqual(vtk_to_numpy(grid.GetCellData().GetArray("volume")).sum(), 1, places=10)

    def test_a_plot_is_xml_and_small(self):
        self.succeed("mesh", "square.poly", "-o", "s.node", "--size", "0.1")
        self.succeed("plot", "s.node", "-o", "s.svg")
        picture = self.folder / "s.svg"
        self.assertTrue(xml.etree.ElementTree.parse(picture).getroot().tag.endswith("svg"))
        self.assertLess(picture.stat().st_size, 200_000)


if __name__ == "__main__":
    unittest.main()
