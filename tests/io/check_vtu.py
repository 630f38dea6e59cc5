#!/usr/bin/python3
"""Opens our .vtu files with VTK and meshio, and compares counts, arrays and volumes.

usage: check_vtu.py FOLDER    (what write_samples wrote)
Exit code: 0 all agree, 1 something differs, 77 vtk, numpy or meshio is absent (the test is skipped).
"""
import pathlib
import sys

try:
    import meshio
    import numpy as np
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)


def check(claim, condition):
    if not condition:
        print(f"failed: {claim}")
        sys.exit(1)


def close(a, b):
    return np.allclose(a, b, rtol=1e-12, atol=1e-15)


def open_with_vtk(path):
    errors = []
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(1))
    reader.SetFileName(str(path))
    reader.Update()
    check(f"VTK reads {path.name} without errors", not errors)
    return reader.GetOutput()


def signed_simplex_measures(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    if cells.shape[1] == 3:
        return (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    return np.linalg.det(edges) / 6


def polyhedron_volume(cell):
    """By the divergence theorem over the faces, whose order must be outward or all inward."""
    volume = 0.0
    for f in range(cell.GetNumberOfFaces()):
        corners = vtk_to_numpy(cell.GetFace(f).GetPoints().GetData())
        for k in range(1, len(corners) - 1):
            volume += np.dot(corners[0], np.cross(corners[k], corners[k + 1])) / 6
    return volume


def polygon_area(points):
    x, y = points[:, 0], points[:, 1]
    return (np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def check_mesh(path, dimension, cell_type, meshio_name, sides):
    grid = open_with_vtk(path)
    n_points, n_cells = (sides + 1) ** dimension, (2 if dimension == 2 else 6) * sides**dimension
    check(f"{path.name}: {n_points} points", grid.GetNumberOfPoints() == n_points)
    check(f"{path.name}: {n_cells} cells", grid.GetNumberOfCells() == n_cells)
    check(f"{path.name}: only simplices", grid.IsHomogeneous() and grid.GetCellType(0) == cell_type)
    for name in ("spacing", "marker", "carrier_dimension"):
        check(f"{path.name}: point array {name}", grid.GetPointData().GetArray(name).GetNumberOfTuples() == n_points)
    check(f"{path.name}: spacing", close(vtk_to_numpy(grid.GetPointData().GetArray("spacing")), 0.5 / sides))
    boundary = vtk_to_numpy(grid.GetFieldData().GetArray("boundary_vertices"))
    marker = vtk_to_numpy(grid.GetFieldData().GetArray("boundary_marker"))
    check(f"{path.name}: boundary", boundary.shape == (len(marker), dimension) and set(marker) == {3, 4})

    mesh = meshio.read(path)
    cells = mesh.cells_dict[meshio_name]
    check(f"{path.name}: meshio sees one block", len(mesh.cells) == 1)
    check(f"{path.name}: meshio and VTK agree on points",
          np.array_equal(mesh.points, vtk_to_numpy(grid.GetPoints().GetData())))
    check(f"{path.name}: meshio and VTK agree on corners",
          np.array_equal(cells.ravel(), vtk_to_numpy(grid.GetCells().GetConnectivityArray())))
    measures = signed_simplex_measures(mesh.points, cells)
    check(f"{path.name}: simplices are positive", measures.min() > 0)
    check(f"{path.name}: measures sum to 1", close(measures.sum(), 1))
    region = mesh.cell_data["region"][0]
    check(f"{path.name}: region", close(measures[region == 1].sum(), (sides // 2 + sides % 2) / sides))


def check_further_array(path):
    points = vtk_to_numpy(open_with_vtk(path).GetPoints().GetData())
    u = vtk_to_numpy(open_with_vtk(path).GetPointData().GetArray("u"))
    check(f"{path.name}: VTK reads the array u", np.array_equal(u, points[:, 0] + 2 * points[:, 1]))
    check(f"{path.name}: meshio reads the array u", np.array_equal(meshio.read(path).point_data["u"], u))


def check_polyhedra(path):
    grid = open_with_vtk(path)
    volume = vtk_to_numpy(grid.GetCellData().GetArray("volume"))
    check("polyhedra: types", all(grid.GetCellType(c) == 42 for c in range(grid.GetNumberOfCells())))
    check("polyhedra: volumes",
          close([polyhedron_volume(grid.GetCell(c)) for c in range(grid.GetNumberOfCells())], volume))
    check("polyhedra: a further array",
          np.array_equal(vtk_to_numpy(grid.GetCellData().GetArray("volume_twice")), 2 * volume))
    check("polyhedra: sites", np.array_equal(vtk_to_numpy(grid.GetCellData().GetArray("site")), np.arange(len(volume))))
    check("polyhedra: volumes sum to 1", close(volume.sum(), 1))
    mesh = meshio.read(path)
    check("polyhedra: meshio counts the cells", sum(len(block.data) for block in mesh.cells) == len(volume))
    check("polyhedra: meshio reads the volumes", close(np.concatenate(mesh.cell_data["volume"]).sum(), 1))


def check_polygons(path):
    grid = open_with_vtk(path)
    volume = vtk_to_numpy(grid.GetCellData().GetArray("volume"))
    areas = [polygon_area(vtk_to_numpy(grid.GetCell(c).GetPoints().GetData())) for c in range(grid.GetNumberOfCells())]
    check("polygons: types", all(grid.GetCellType(c) == 7 for c in range(grid.GetNumberOfCells())))
    check("polygons: areas, counterclockwise", close(areas, volume))
    mesh = meshio.read(path)
    check("polygons: meshio counts the cells", sum(len(block.data) for block in mesh.cells) == len(volume))


def main():
    folder = pathlib.Path(sys.argv[1])
    check_mesh(folder / "mesh2.vtu", 2, 5, "triangle", 100)
    check_further_array(folder / "mesh2.vtu")
    check_mesh(folder / "mesh3.vtu", 3, 10, "tetra", 25)
    check_polyhedra(folder / "cells3.vtu")
    check_polygons(folder / "cells2.vtu")
    print("VTK and meshio agree with our files")


if __name__ == "__main__":
    main()
