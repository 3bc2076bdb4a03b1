#!/bin/sh
# Sets bldsimp up (the first time), simplifies the house in data/, and prints what became of it.
set -eu
cd "$(dirname "$0")/.."
sh setup.sh
mkdir -p build
.venv/bin/bldsimp simplify data/building_a.glb build/building_a_simplified.glb --overwrite
echo "written to build/building_a_simplified.glb" >&2
