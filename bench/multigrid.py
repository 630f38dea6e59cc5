#!/usr/bin/env python3
"""Multigrid and BoomerAMG on the same systems, in turn, from the matrix to a relative residual of 1e-8.

    cmake --preset bench && cmake --build --preset bench
    bench/multigrid.py --build build/bench --unknowns 1000000 --loads 10 --threads 2

Ours includes coarsening, control volumes and matrices of the levels, and setup; the peer's includes its setup. Prints a
table with seconds by the clock and of all processors; --json writes the same as a file.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

THRESHOLD = {2: 0.25, 3: 0.5}  # As hypre's manual recommends.
ASKED = {2: 0.98, 3: 0.69}  # What to ask micro/multigrid for, to get 1.
SECONDS = r"(?P<{0}>[\d.]+) s, (?P<{0}_processor>[\d.]+) s"
OURS = re.compile("with coarsening and setup: 1 load " + SECONDS.format("first") + r" of processor time; \d+ loads "
                  + SECONDS.format("all"))
PEER_FIRST = re.compile("setup and first load: " + SECONDS.format("first"))
PEER_ALL = re.compile("setup and all loads: " + SECONDS.format("all"))


def run(command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def row_of(name, dimension, unknowns, iterations, *matches):
    row = {"dimension": dimension, "unknowns": unknowns, "solver": name, "iterations": iterations}
    for match in matches:
        row.update({key: float(value) for key, value in match.groupdict().items()})
    return row


def run_ours(arguments, dimension, system):
    out = run([arguments.build / "bench/micro/multigrid", str(dimension), str(round(ASKED[dimension] * arguments.unknowns)),
               str(arguments.growth), "1", str(arguments.loads), str(arguments.threads), system, "1"])
    unknowns = int(re.search(r"unknowns (\d+)", out)[1])
    return row_of("multigrid", dimension, unknowns, int(re.search(r"iterations (\d+)", out)[1]), OURS.search(out))


def run_peer(arguments, dimension, system, unknowns, aggressive):
    ranks = max(1, arguments.threads)
    # Unbound: mpirun would pin its ranks.
    root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    out = run(["mpirun", *root, "--bind-to", "none", "--oversubscribe", "-np", str(ranks),
               arguments.build / "bench/peers/boomer_amg", system, str(THRESHOLD[dimension]), str(aggressive),
               str(arguments.loads)])
    name = "BoomerAMG" + (", aggressive" if aggressive else "")
    return row_of(name, dimension, unknowns, int(re.search(r"iterations (\d+)", out)[1]), PEER_FIRST.search(out),
                  PEER_ALL.search(out))


def table(rows, loads):
    lines = [f"| dimension | unknowns | solver | iterations | 1 load: clock | processor | over ours | {loads} loads: "
             "clock | processor | over ours |", "| --- " * 10 + "|"]
    for row in rows:
        ours = next(other for other in rows
                    if other["solver"] == "multigrid" and other["dimension"] == row["dimension"])
        cells = [row["dimension"], f"{row['unknowns']:,}", row["solver"], row["iterations"]]
        for key in ("first", "all"):
            processor = row[key + "_processor"]
            cells += [f"{row[key]:.2f}", f"{processor:.2f}", f"{processor / ours[key + '_processor']:.2f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/bench"))
    parser.add_argument("--dimensions", type=int, nargs="+", default=[2, 3])
    parser.add_argument("--unknowns", type=int, default=1_000_000, help="about")
    parser.add_argument("--growth", type=float, default=2.5)
    parser.add_argument("--loads", type=int, default=10)
    parser.add_argument("--threads", type=int, default=1, help="threads of ours, ranks of the peer")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for dimension in arguments.dimensions:
            system = str(pathlib.Path(folder) / "system")
            rows.append(run_ours(arguments, dimension, system))
            for aggressive in (0, 1):
                rows.append(run_peer(arguments, dimension, system, rows[-1]["unknowns"], aggressive))
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")
    print(table(rows, arguments.loads))


if __name__ == "__main__":
    main()
