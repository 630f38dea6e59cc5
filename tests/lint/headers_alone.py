#!/usr/bin/env python3
"""Compiles each public header alone: headers_alone.py COMPILER. Exit 1 if one does not stand on its own."""
import pathlib
import subprocess
import sys

include = pathlib.Path(__file__).resolve().parents[2] / "include"
headers = sorted(include.rglob("*.h"))
assert headers, f"no header under {include}"
failed = 0
for header in headers:
    name = header.relative_to(include).as_posix()
    command = [sys.argv[1], "-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", f"-I{include}",
               "-xc++", "-"]
    result = subprocess.run(command, input=f'#include "{name}"\n#include "{name}"\n', text=True, capture_output=True)
    if result.returncode != 0:
        failed += 1
        print(f"{name} does not compile alone:\n{result.stderr}")
print(f"{len(headers) - failed} of {len(headers)} headers compile alone")
sys.exit(1 if failed else 0)
