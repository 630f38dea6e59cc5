#!/usr/bin/env bash
# Makes the pictures of the README and the docs with the program itself: docs/pictures/*.svg.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$here/../run" mesh "$here/../examples/domains/plate.poly" -o "$work/plate.node" --size 0.35 --region-size 2=0.2 --quiet
"$here/../run" plot "$work/plate.node" -o "$here/pictures/plate.svg"

"$here/../run" mesh "$here/../examples/domains/cracks.poly" -o "$work/cracks.node" --quiet
"$here/../run" plot "$work/cracks.node" -o "$here/pictures/cracks.svg"

for case in heat aquifer; do
  "$here/../run" solve "$here/../examples/cases/$case.toml" -o "$work/$case.vtu" --quiet
  "$here/../run" plot "$work/$case.vtu" --array u -o "$here/pictures/$case.svg"
done

# Meshes made to measure: the last of each series.
"$here/../run" solve "$here/../examples/cases/corner.toml" --adapt --cycles 3 -o "$work/corner.vtu" --quiet
"$here/../run" plot "$work/corner_0003.vtu" -o "$here/pictures/corner.svg"
"$here/../run" solve "$here/../examples/cases/layer.toml" --adapt --max-vertices 1300 -o "$work/layer.vtu" --quiet
last=("$work"/layer_*.vtu)
"$here/../run" plot "${last[-1]}" -o "$here/pictures/layer.svg"

"$here/../run" paper figure3 -o "$here/pictures/figure3.svg"

"$here/../run" paper figure5 --size 0.02 --levels 3 --quiet -o "$here/pictures/figure5.svg"

# The mesh of Figure 8 is no part of this project: see docs/theory/beyond_boundary.md.
airfoil=${VOROPACK_SHARED:-$here/../../shared}/data/airfoil/airfoil.node
[ ! -f "$airfoil" ] || "$here/../run" paper figure8 --mesh "$airfoil" --quiet -o "$here/pictures/figure8.svg"
