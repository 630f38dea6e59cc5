#!/usr/bin/env python3
"""Checks that dependencies point one way: base <- geom <- mesh <- spheres <- stages <- pipeline <- apps.

A stage may include the public headers of earlier stages, never a later one nor the private header of another stage.
The certificate shares no code with the stages that it judges. Public headers include nothing but the standard library
and public headers before them.

    include_direction.py [ROOT]      checks a source tree (default: the one that this file is in); exit 1 on a violation
    include_direction.py --self-test makes small trees with one violation each, and checks that each is found
"""
import pathlib
import re
import sys
import tempfile

# Public headers in the order of the data; each may include those before it.
PUBLIC = ["index", "error", "expression", "vec", "observer", "mesh", "domain", "mesh_domain", "spacing", "packing",
          "delaunay", "dual", "boundary_areas", "cell_integrals", "io", "quality", "certificate", "pipeline",
          "linear_system", "diffusion", "nonlinear", "transient", "multigrid", "fem", "norms", "coarsening", "refinement",
          "adaptivity"]
BASICS = ["index", "error", "expression", "vec", "observer"]


def up_to(name):
    """The public headers up to and including `name`."""
    return PUBLIC[:PUBLIC.index(name) + 1]


# Folder under src -> (public headers, private folders or single files) that it may include beside its own.
FOLDERS = {
    "base": (BASICS, []),
    "geom": (BASICS, ["base"]),
    "mesh": (BASICS + ["mesh"], ["base", "geom"]),
    "spheres": (BASICS + ["domain", "spacing", "packing"], ["base", "geom"]),  # The packing's types, but no mesh.
    "io": (BASICS + ["mesh", "domain", "dual", "io"], ["base", "geom", "mesh"]),
    "domain": (BASICS + ["domain"], ["base", "geom"]),
    "spacing": (up_to("spacing"), ["base", "geom"]),
    "packing": (up_to("packing"), ["base", "geom", "spheres"]),
    "delaunay": (up_to("delaunay"), ["base", "geom", "mesh", "spheres"]),
    "dual": (up_to("cell_integrals"), ["base", "geom", "mesh"]),
    "quality": (up_to("quality"), ["base", "geom", "mesh"]),
    "certificate": (up_to("certificate"), ["base", "geom/predicates.h", "geom/tolerance.h"]),
    "pipeline": (up_to("pipeline"), ["base"]),
    # Control volumes of any program: no simplices, no geometry.
    "solve": (BASICS + ["mesh", "boundary_areas", "linear_system", "diffusion", "nonlinear", "transient"], ["base"]),
    # Algebra: matrices and interpolations, whatever they come from.
    "multigrid": (BASICS + ["linear_system", "multigrid"], ["base", "solve/vectors.h"]),
    # Refusals, problems without conditions, and the adding up of flows are those of the control volume method.
    "fem": (BASICS + ["mesh", "boundary_areas", "linear_system", "diffusion", "fem"],
            ["base", "geom", "mesh", "solve/faults.h", "solve/floating_parts.h", "solve/coefficients.h", "solve/balance.h",
             "solve/conservation.h"]),
    "mesh_domain": (BASICS + ["mesh", "domain", "mesh_domain"], ["base", "geom", "mesh"]),
    "coarsening": (up_to("delaunay") + ["linear_system", "coarsening"], ["base", "geom", "mesh", "spheres", "packing"]),
    "refinement": (up_to("refinement"), ["base", "geom", "mesh", "coarsening/fine_mesh.h", "coarsening/initial_spacing.h",
                                           "coarsening/prolongation.h"]),
    "norms": (BASICS + ["mesh", "dual", "norms"], ["base", "geom", "mesh"]),
    # The error's equation is assembled as the solution's is.
    "adaptivity": (up_to("adaptivity"), ["base", "geom", "mesh", "norms/dual_face_parts.h", "solve/assemble.h", "solve/cell_index.h",
                                         "solve/coefficients.h", "solve/floating_parts.h"]),
}

INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
SOURCES = (".h", ".cpp")


def includes(path):
    """(line, name, is_quoted) of each include of a file."""
    text = path.read_text(encoding="utf-8")
    for match in INCLUDE.finditer(text):
        yield text.count("\n", 0, match.start(1) if match[1] else match.start(2)) + 1, match[1] or match[2], bool(match[1])


def check_public(path):
    """Faults of one public header."""
    name = path.stem
    if name not in PUBLIC:
        yield 1, f"public header {path.name} is not in the table of {pathlib.Path(__file__).name}"
        return
    allowed = {f"voropack/{earlier}.h" for earlier in PUBLIC[:PUBLIC.index(name)]}
    for line, included, quoted in includes(path):
        if included.startswith("voropack/"):
            if included not in allowed:
                yield line, f"a public header includes {included}, which does not come before it"
        elif quoted or "/" in included or included.endswith(".h"):
            yield line, f"a public header includes {included}, which is neither public nor standard"


def check_private(path, folder, public, private):
    """Faults of one file under src or apps."""
    for line, included, quoted in includes(path):
        if included.startswith("voropack/"):
            if included not in {f"voropack/{name}.h" for name in public}:
                yield line, f"{folder} includes {included} of a later stage"
        elif quoted and "/" in included:
            top = included.split("/")[0]
            if top != folder and top not in private and included not in private:
                yield line, f"{folder} includes {included}, which is private to {top}"


def check(root):
    """All faults of a tree, as lines of text."""
    faults = []

    def add(path, found):
        faults.extend(f"{path.relative_to(root)}:{line}: {message}" for line, message in found)

    for path in sorted((root / "include").rglob("*.h")):
        add(path, check_public(path))
    for path in sorted((root / "src").rglob("*")):
        if path.suffix not in SOURCES:
            continue
        folder = path.relative_to(root / "src").parts[0]
        if folder not in FOLDERS:
            add(path, [(1, f"src/{folder} is not in the table")])
        else:
            add(path, check_private(path, folder, *FOLDERS[folder]))
    for path in sorted((root / "apps").rglob("*")):
        if path.suffix in SOURCES:
            add(path, check_private(path, "apps", PUBLIC, []))
    return faults


# A good tree, and changes that must each be found.
GOOD = {
    "include/voropack/vec.h": "#include <array>\n",
    "include/voropack/mesh.h": '#include "voropack/vec.h"\n',
    "src/geom/predicates.h": '#include "voropack/vec.h"\n',
    "src/certificate/certificate.cpp": '#include "geom/predicates.h"\n#include "voropack/mesh.h"\n',
    "src/dual/dual.cpp": '#include <vector>\n#include "dual/areas.h"\n#include "geom/circumcenter.h"\n',
    "apps/voropack/main.cpp": '#include "report.h"\n#include "voropack/pipeline.h"\n',
}
BAD = {
    "later public header": ("src/domain/domain.cpp", '#include "voropack/packing.h"\n'),
    "private header of another stage": ("src/delaunay/delaunay.cpp", '#include "packing/darts.h"\n'),
    "certificate shares geometry": ("src/certificate/certificate.cpp", '#include "geom/circumcenter.h"\n'),
    "base knows geometry": ("src/base/sort.h", '#include "geom/hilbert.h"\n'),
    "spheres know the mesh": ("src/spheres/grid.h", '#include "voropack/mesh.h"\n'),
    "app reaches into the library": ("apps/voropack/main.cpp", '#include "packing/darts.h"\n'),
    "public header pulls in CGAL": ("include/voropack/mesh.h", "#include <CGAL/Triangulation_3.h>\n"),
    "public header shows a private one": ("include/voropack/mesh.h", '#include "geom/predicates.h"\n'),
    "public headers in a circle": ("include/voropack/vec.h", '#include "voropack/mesh.h"\n'),
    "unknown folder": ("src/misc/utils.h", "#include <vector>\n"),
    "unknown public header": ("include/voropack/utils.h", "#include <vector>\n"),
}


def faults_of(files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return check(root)


def self_test():
    assert faults_of(GOOD) == [], faults_of(GOOD)
    for what, (name, text) in BAD.items():
        found = faults_of({**GOOD, name: text})
        assert len(found) == 1 and found[0].startswith(name), f"{what}: {found}"
    print(f"{len(BAD)} violations, each found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2]
    faults = check(root)
    print("\n".join(faults) or "every include points the right way")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
