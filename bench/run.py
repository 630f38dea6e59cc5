#!/usr/bin/env python3
"""Runs benchmark cases, ours and the peers' in turn, and writes one JSON file per case and count.

    cmake --preset bench && cmake --build --preset bench
    bench/run.py cube --vertices 10000 100000        results in bench/results/
    bench/run.py --all --rounds 5

Times are compared only as ratios within one run. Each peer is asked for the same number of vertices (within 5 %), and
`voropack check` says what its mesh is. No speed is given without quality and size beside it.
"""
import argparse
import datetime
import hashlib
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import tempfile

import domains
import programs

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent
COUNT_TOLERANCE = 0.05
CALIBRATION_RUNS = 8


def n_vertices(path):
    with open(path) as file:
        for line in file:
            words = line.split("#")[0].split()
            if words:
                return int(words[0])
    raise ValueError(f"{path} is empty")


def run_once(program, stem, size, folder, timeout):
    finished = programs.run_timed(program.command(stem, size), folder, timeout)
    if finished.returncode != 0:
        raise RuntimeError(f"{program.name} ended with {finished.returncode}: {finished.output[-300:]}")
    return finished


def calibrate(program, domain, stem, n, folder, timeout):
    """The size for which `program` makes n vertices, by a secant in log-log; as near as it gets."""
    size = program.first_size(domain, n)
    best = None
    for _ in range(CALIBRATION_RUNS):
        run_once(program, stem, size, folder, timeout)
        program.prepare(folder, stem)
        count = n_vertices(folder / program.mesh(stem))
        if best is None or abs(count - n) < abs(best[1] - n):
            best = (size, count)
        if abs(count - n) <= COUNT_TOLERANCE * n:
            break
        size *= (count / n) ** (1 / domain.dimension)
    return best[0]


def judge(voropack, mesh, poly, folder, timeout):
    """What `voropack check` says of a mesh: counts, quality, and violations per check."""
    report = folder / "check.json"
    report.unlink(missing_ok=True)
    command = [voropack.executable(), "check", mesh, "--domain", poly, "--report", report, "--quiet"]
    finished = programs.run_timed(command, folder, timeout)
    if not report.exists():
        return {"error": finished.output.strip()[-500:]}
    found = json.loads(report.read_text())
    checks = {check["name"]: {"tested": check["tested"], "violations": check["violations"]}
              for check in found["certificate"]["checks"]}
    return {"certificate_ok": found["certificate"]["ok"], "checks": checks, "counts": found["counts"],
            "quality": found["quality"], "dual": found["dual"]}


def spread(values):
    return {"runs": len(values), "median": statistics.median(values), "min": min(values), "max": max(values)}


def row_of(program, finished, judged):
    last = finished[-1]
    row = {"program": program.name, "version": program.version(), "command": last.command,
           "wall_s": spread([f.wall_s for f in finished]),
           "peak_memory_bytes": statistics.median([f.peak_memory_bytes for f in finished])}
    return {**row, **judged}


def stage_times(reports):
    names = {name for report in reports for name in report["timing_s"]}
    return {name: spread([report["timing_s"].get(name, 0) for report in reports]) for name in sorted(names)}


def cache_entry(build, name):
    match = re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.MULTILINE)
    return match[1] if match else ""


def machine(build):
    cpu = re.search(r"model name\s*:\s*(.*)", pathlib.Path("/proc/cpuinfo").read_text())
    memory = re.search(r"MemTotal:\s*(\d+)", pathlib.Path("/proc/meminfo").read_text())
    compiler = cache_entry(build, "CMAKE_CXX_COMPILER")
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout.splitlines()
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=PROJECT, capture_output=True, text=True)
    build_type = cache_entry(build, "CMAKE_BUILD_TYPE")
    flags = f"{cache_entry(build, 'CMAKE_CXX_FLAGS')} {cache_entry(build, 'CMAKE_CXX_FLAGS_' + build_type.upper())}"
    return {"commit": commit.stdout.strip(), "compiler": version[0] if version else compiler, "flags": flags.strip(),
            "build_type": build_type, "cpu": cpu[1] if cpu else platform.processor(), "n_cpus": os.cpu_count(),
            "memory_bytes": int(memory[1]) * 1024 if memory else None, "system": platform.platform(),
            "load_at_start": os.getloadavg()[0]}


def bench(case, stem, domain, n, arguments, folder):
    """All programs on one domain at one count, in turn."""
    poly = domain.write(folder, stem)
    ours = programs.Voropack(arguments.build, arguments.threads, case["options"])
    peers = [programs.PEERS[name](arguments.build, arguments.threads) for name in case["peers"]]
    skipped = {peer.name: "not installed or not built" for peer in peers if not peer.available()}
    contestants, sizes = [ours], {ours.name: calibrate(ours, domain, stem, n, folder, arguments.timeout)}
    for peer in peers:
        if peer.name in skipped:
            continue
        try:
            sizes[peer.name] = (calibrate(peer, domain, stem, n, folder, arguments.timeout) if peer.makes_mesh else 0.0)
            contestants.append(peer)
        except RuntimeError as error:
            skipped[peer.name] = str(error)

    finished = {program.name: [] for program in contestants}
    reports = []
    for round_number in range(arguments.rounds + 1):  # The first round warms up.
        for program in contestants:
            result = run_once(program, stem, sizes[program.name], folder, arguments.timeout)
            if round_number > 0:
                finished[program.name].append(result)
                if program is ours:
                    reports.append(json.loads((folder / "ours.json").read_text()))
    rows = []
    for program in contestants:
        judged = {}
        if program.makes_mesh:
            program.prepare(folder, stem)
            judged = judge(ours, program.mesh(stem), poly.name, folder, arguments.timeout)
        rows.append({**row_of(program, finished[program.name], judged), "size": sizes[program.name]})
    rows[0]["stages_s"] = stage_times(reports)
    median = rows[0]["wall_s"]["median"]
    for row in rows[1:]:
        row["time_over_ours"] = row["wall_s"]["median"] / median
    return {"case": case["name"], "about": case["about"], "domain": stem, "wanted_vertices": n,
            "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
            "machine": machine(arguments.build), "threads": arguments.threads, "seed": reports[-1]["options"]["seed"],
            "input_sha256": hashlib.sha256(poly.read_bytes()).hexdigest(), "rows": rows, "skipped": skipped}


def print_rows(result):
    print(f"\n{result['domain']}: {result['wanted_vertices']} vertices wanted, {result['threads']} threads")
    print(f"{'program':<12}{'vertices':>10}{'median s':>10}{'min':>9}{'max':>9}{'GB':>7}{'time/ours':>11}  failed checks")
    for row in result["rows"]:
        wall = row["wall_s"]
        failed = {name: check["violations"] for name, check in row.get("checks", {}).items() if check["violations"]}
        verdict = row.get("error") or ", ".join(f"{name} {count}" for name, count in failed.items())
        print(f"{row['program']:<12}{row.get('counts', {}).get('vertices', ''):>10}{wall['median']:>10.3f}{wall['min']:>9.3f}"
              f"{wall['max']:>9.3f}{row['peak_memory_bytes'] / 1e9:>7.2f}{row.get('time_over_ours', 1):>11.2f}  "
              f"{verdict or '-'}")
    for name, reason in result["skipped"].items():
        print(f"{name:<12} skipped: {reason.splitlines()[0]}")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help="names of files in bench/cases")
    parser.add_argument("--all", action="store_true", help="every case but tiny")
    parser.add_argument("--vertices", type=int, nargs="+", help="instead of the case's own counts")
    parser.add_argument("--rounds", type=int, default=5, help="timed runs of each program [5]")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="for programs that use several [all]")
    parser.add_argument("--timeout", type=float, default=1800, help="seconds for one run [1800]")
    parser.add_argument("--build", type=pathlib.Path, default=PROJECT / "build/bench", help="build folder [build/bench]")
    parser.add_argument("--results", type=pathlib.Path, default=HERE / "results", help="where the JSON goes")
    parser.add_argument("--shared", type=pathlib.Path, help="folder of shared data",
                        default=pathlib.Path(os.environ.get("VOROPACK_SHARED", PROJECT / "../shared")) / "data")
    options = parser.parse_args(arguments)
    options.build = options.build.resolve()
    if options.all:
        options.cases = sorted(path.stem for path in (HERE / "cases").glob("*.json") if path.stem != "tiny")
    if not options.cases:
        parser.error("name a case, or say --all")
    return options


def main():
    arguments = parse(sys.argv[1:])
    arguments.results.mkdir(parents=True, exist_ok=True)
    for name in arguments.cases:
        case = json.loads((HERE / "cases" / f"{name}.json").read_text())
        for stem, domain in domains.of_case(case, arguments.shared):
            for n in arguments.vertices or case["vertices"]:
                with tempfile.TemporaryDirectory(prefix="voropack-bench-") as folder:
                    result = bench(case, stem, domain, n, arguments, pathlib.Path(folder))
                print_rows(result)
                date = result["date"][:19].replace(":", "")
                (arguments.results / f"{stem}-{n}-{date}.json").write_text(json.dumps(result, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
