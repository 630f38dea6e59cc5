"""The programs that bench/run.py compares: how each is asked for about n vertices, and where its mesh is."""
import dataclasses
import pathlib
import re
import shutil
import subprocess
import time

# Vertices of a mesh of edge length h in a domain of measure V are about kDensity * V / h^D: a first guess.
DENSITY = {2: 1.15, 3: 1.3}


@dataclasses.dataclass
class Finished:
    """One run of a program."""
    command: list
    wall_s: float
    peak_memory_bytes: int
    returncode: int
    output: str


def run_timed(command, folder, timeout):
    """Runs to the end or to `timeout` seconds, with wall time and peak memory of the process."""
    log = pathlib.Path(folder) / "output.txt"
    with open(log, "w") as stream:
        start = time.perf_counter()
        process = subprocess.Popen([str(word) for word in command], cwd=folder, stdout=stream, stderr=subprocess.STDOUT)
        deadline = start + timeout
        peak = 0
        while process.poll() is None:
            peak = max(peak, peak_memory(process.pid))
            if time.perf_counter() > deadline:
                process.kill()
                process.wait()
                break
            time.sleep(0.002)
        wall = time.perf_counter() - start
    return Finished([str(word) for word in command], wall, peak, process.returncode, log.read_text(errors="replace"))


def peak_memory(pid):
    """Peak resident memory of a running process in bytes, 0 if it is gone. (What wait4 says of a child is at least what
    this process had when it started the child.)"""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    found = re.search(r"^VmHWM:\s*(\d+) kB", status, re.MULTILINE)
    return int(found[1]) * 1024 if found else 0


class Program:
    """A mesher. `size` is what it is asked for; a smaller size gives more vertices."""
    name = ""
    makes_mesh = True   # False: triangulates our vertices, so there is no count to reach and no mesh to judge.

    def __init__(self, tools, threads):
        self.tools, self.threads = tools, threads

    def available(self):
        return shutil.which(self.executable()) is not None

    def executable(self):
        return self.name

    def version(self):
        return ""

    def first_size(self, domain, n):
        return (DENSITY[domain.dimension] * domain.measure / n) ** (1 / domain.dimension)

    def command(self, stem, size):
        raise NotImplementedError

    def mesh(self, stem):
        """The mesh file that a run left, relative to its folder, in a format that voropack reads."""
        raise NotImplementedError

    def prepare(self, folder, stem):
        """Converts what a run left, where that is needed. Not timed."""


class Voropack(Program):
    name = "voropack"

    def __init__(self, tools, threads, options):
        super().__init__(tools, threads)
        self.options = options

    def executable(self):
        return str(self.tools / "apps/voropack/voropack")

    def version(self):
        return subprocess.run([self.executable(), "--version"], capture_output=True, text=True).stdout.strip()

    def command(self, stem, size):
        return [self.executable(), "mesh", f"{stem}.poly", "-o", "ours.node", "--report", "ours.json", "--size", repr(size),
                "--threads", self.threads, "--quiet", *self.options]

    def mesh(self, stem):
        return "ours.node"


class TetGen(Program):
    name = "tetgen"

    def version(self):
        text = subprocess.run(["tetgen", "-h"], capture_output=True, text=True).stdout
        match = re.search(r"Version ([\d.]+)", text)
        return match[1] if match else ""

    def command(self, stem, size):
        # -O0/0: no smoothing and no swapping after refinement, which would break the Delaunay property.
        return ["tetgen", f"-pq1.2a{size ** 3 / 6:.17f}O0/0", f"{stem}.poly"]

    def mesh(self, stem):
        return f"{stem}.1.node"


class Gmsh(Program):
    name = "gmsh"

    def version(self):
        return subprocess.run(["gmsh", "--version"], capture_output=True, text=True).stderr.strip()

    def command(self, stem, size):
        return ["gmsh", "-3", "-algo", "hxt", "-nt", self.threads, "-clmin", repr(size), "-clmax", repr(size), "-format",
                "mesh", "-o", "gmsh.mesh", f"{stem}.geo"]

    def mesh(self, stem):
        return "gmsh.node"

    def prepare(self, folder, stem):
        medit_to_node(folder / "gmsh.mesh", folder / "gmsh.node")


class Mesh3(Program):
    name = "mesh_3"

    def executable(self):
        return str(self.tools / "bench/peers/mesh_3")

    def version(self):
        return "CGAL Mesh_3, parallel"

    def command(self, stem, size):
        return [self.executable(), f"{stem}.off", repr(size), "mesh_3.mesh", self.threads]

    def mesh(self, stem):
        return "mesh_3.node"

    def prepare(self, folder, stem):
        medit_to_node(folder / "mesh_3.mesh", folder / "mesh_3.node")


class Mesher2(Program):
    name = "mesher_2"

    def executable(self):
        return str(self.tools / "bench/peers/mesher_2")

    def version(self):
        return "CGAL Delaunay_mesher_2, sequential"

    def command(self, stem, size):
        return [self.executable(), f"{stem}.poly", repr(size), "mesher_2.node"]

    def mesh(self, stem):
        return "mesher_2.node"


class Delaunay3(Program):
    """Only the triangulation of our vertices in Hilbert order: what any Delaunay mesher must pay at least."""
    name = "delaunay_3"
    makes_mesh = False

    def executable(self):
        return str(self.tools / "bench/peers/delaunay_3")

    def version(self):
        return "CGAL Delaunay_triangulation_3, sequential, Hilbert order"

    def command(self, stem, size):
        return [self.executable(), "ours.node"]


PEERS = {program.name: program for program in (TetGen, Gmsh, Mesh3, Mesher2, Delaunay3)}


def medit_to_node(source, target):
    """Medit .mesh (ASCII) to .node and .ele: vertices that no tetrahedron uses are dropped."""
    words = iter(pathlib.Path(source).read_text().split())
    points, simplices = [], []
    for word in words:
        if word == "Vertices":
            points = [[next(words), next(words), next(words), next(words)][:3] for _ in range(int(next(words)))]
        elif word == "Tetrahedra":
            simplices = [[int(next(words)) for _ in range(5)] for _ in range(int(next(words)))]
    used = sorted({corner for simplex in simplices for corner in simplex[:4]})
    number = {old: new for new, old in enumerate(used, 1)}
    with open(target, "w") as out:
        out.write(f"{len(used)} 3 0 0\n")
        out.writelines(f"{number[i]} {' '.join(points[i - 1])}\n" for i in used)
    with open(pathlib.Path(target).with_suffix(".ele"), "w") as out:
        out.write(f"{len(simplices)} 4 1\n")
        out.writelines(f"{k} {' '.join(str(number[i]) for i in s[:4])} {s[4]}\n" for k, s in enumerate(simplices, 1))
