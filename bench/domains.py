"""The benchmarks' domains, each as the files that the programs want: .poly, .off, .geo."""
import pathlib


class Domain:
    """Points and planar facets; a facet is a list of loops, the first its outline, the others around holes."""

    def __init__(self, points, facets, measure):
        self.points, self.facets, self.measure = points, facets, measure
        self.dimension = len(points[0])

    def write(self, folder, stem):
        """Writes every form; returns the path of the one for voropack."""
        folder = pathlib.Path(folder)
        poly = folder / f"{stem}.poly"
        poly.write_text(self._poly_3() if self.dimension == 3 else self._poly_2())
        if self.dimension == 3:
            (folder / f"{stem}.off").write_text(self._off())
            (folder / f"{stem}.geo").write_text(self._geo())
        return poly

    def _poly_2(self):
        lines = [f"{len(self.points)} 2 0 0"]
        lines += [f"{i + 1} {x!r} {y!r}" for i, (x, y) in enumerate(self.points)]
        loop = self.facets[0][0]
        lines += [f"{len(loop)} 1"]
        lines += [f"{i + 1} {a + 1} {loop[(i + 1) % len(loop)] + 1} {i + 1}" for i, a in enumerate(loop)]
        return "\n".join(lines + ["0", ""])

    def _poly_3(self):
        lines = [f"{len(self.points)} 3 0 0"]
        lines += [f"{i + 1} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(self.points)]
        lines += [f"{len(self.facets)} 1"]
        for marker, loops in enumerate(self.facets, 1):
            lines.append(f"{len(loops)} {len(loops) - 1} {marker}")
            lines += [f"{len(loop)} " + " ".join(str(i + 1) for i in loop) for loop in loops]
            for number, loop in enumerate(loops[1:], 1):
                center = [sum(self.points[i][k] for i in loop) / len(loop) for k in range(3)]
                lines.append(f"{number} " + " ".join(map(repr, center)))
        return "\n".join(lines + ["0", "0", ""])

    def _triangles(self):
        for loops in self.facets:
            outline = loops[0]
            if len(loops) == 1:
                yield from ((outline[0], outline[i], outline[i + 1]) for i in range(1, len(outline) - 1))
                continue
            # A ring between two loops whose corners correspond.
            inner, n = loops[1], len(outline)
            for i in range(n):
                j = (i + 1) % n
                yield outline[i], outline[j], inner[j]
                yield outline[i], inner[j], inner[i]

    def _off(self):
        triangles = list(self._triangles())
        lines = ["OFF", f"{len(self.points)} {len(triangles)} 0"]
        lines += [" ".join(map(repr, point)) for point in self.points]
        return "\n".join(lines + [f"3 {a} {b} {c}" for a, b, c in triangles] + [""])

    def _geo(self):
        """Gmsh's own format; the size comes from the command line."""
        lines = [f"Point({i + 1}) = {{{', '.join(map(repr, p))}}};" for i, p in enumerate(self.points)]
        edges, loop_number, surfaces = {}, 0, []
        for loops in self.facets:
            loop_numbers = []
            for loop in loops:
                signed = []
                for a, b in zip(loop, loop[1:] + loop[:1]):
                    key = (min(a, b), max(a, b))
                    if key not in edges:
                        edges[key] = len(edges) + 1
                        lines.append(f"Line({edges[key]}) = {{{key[0] + 1}, {key[1] + 1}}};")
                    signed.append(edges[key] if (a, b) == key else -edges[key])
                loop_number += 1
                lines.append(f"Line Loop({loop_number}) = {{{', '.join(map(str, signed))}}};")
                loop_numbers.append(loop_number)
            surfaces.append(len(surfaces) + 1)
            lines.append(f"Plane Surface({surfaces[-1]}) = {{{', '.join(map(str, loop_numbers))}}};")
        lines.append(f"Surface Loop(1) = {{{', '.join(map(str, surfaces))}}};")
        lines.append("Volume(1) = {1};")
        return "\n".join(lines + [""])


def box(lo, hi, hole=None):
    """A box in 2D or 3D, in 3D with a rectangular hole along z if wanted."""
    if len(lo) == 2:
        points = [(lo[0], lo[1]), (hi[0], lo[1]), (hi[0], hi[1]), (lo[0], hi[1])]
        return Domain([tuple(map(float, p)) for p in points], [[[0, 1, 2, 3]]], (hi[0] - lo[0]) * (hi[1] - lo[1]))

    def ring(a, b, z):
        return [(a[0], a[1], z), (b[0], a[1], z), (b[0], b[1], z), (a[0], b[1], z)]

    points = ring(lo, hi, lo[2]) + ring(lo, hi, hi[2])
    measure = (hi[0] - lo[0]) * (hi[1] - lo[1]) * (hi[2] - lo[2])
    # Facets are oriented outwards: bottom, top, sides.
    bottom, top, sides = [[0, 3, 2, 1]], [[4, 5, 6, 7]], [[[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4]] for i in range(4)]
    if hole:
        points += ring(hole["lo"], hole["hi"], lo[2]) + ring(hole["lo"], hole["hi"], hi[2])
        measure -= (hole["hi"][0] - hole["lo"][0]) * (hole["hi"][1] - hole["lo"][1]) * (hi[2] - lo[2])
        bottom.append([8, 11, 10, 9])
        top.append([12, 13, 14, 15])
        sides += [[[8 + (i + 1) % 4, 8 + i, 12 + i, 12 + (i + 1) % 4]] for i in range(4)]
    return Domain([tuple(map(float, p)) for p in points], [bottom, top, *sides], measure)


def read_off(path):
    """A polygon surface in OFF."""
    words = [line.split("#")[0].split() for line in pathlib.Path(path).read_text().splitlines()]
    words = [word for line in words for word in line]
    assert words[0] == "OFF", path
    n_points, n_facets = int(words[1]), int(words[2])
    at = 4
    points = [tuple(map(float, words[at + 3 * i: at + 3 * i + 3])) for i in range(n_points)]
    at += 3 * n_points
    facets = []
    for _ in range(n_facets):
        n = int(words[at])
        facets.append([list(map(int, words[at + 1: at + 1 + n]))])
        at += 1 + n
    volume = 0.0
    for loops in facets:
        a = points[loops[0][0]]
        for i in range(1, len(loops[0]) - 1):
            b, c = points[loops[0][i]], points[loops[0][i + 1]]
            volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                       + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    return Domain(points, facets, abs(volume))


def of_case(case, shared):
    """(stem, Domain) for each domain of a case; those that need absent shared data are left out."""
    description = case["domain"]
    if "box" in description:
        yield case["name"], box(description["box"]["lo"], description["box"]["hi"], description.get("hole"))
    for name in description.get("shared", []):
        path = pathlib.Path(shared) / name
        if path.exists():
            yield path.stem, read_off(path)
        else:
            print(f"skipped: {name} is not in {shared}")
