#!/bin/sh
# Simplifies every OBJ of a folder to a GLB of the same name in another folder, then prints a table.
#
# usage: sh simplify_folder.sh FROM TO [OPTION of bldsimp simplify]...      (-q: the table alone)
# Goes on after a file that fails, and exits with 1 if any did.
set -u
[ $# -ge 2 ] || { echo "usage: sh simplify_folder.sh FROM TO [OPTION]..." >&2; exit 2; }
from=$1 to=$2
shift 2
mkdir -p -- "$to" || exit 1
reports=$(mktemp -d) || exit 1
trap 'rm -rf "$reports"' EXIT
trap 'exit 130' INT TERM
failed=0 found=0
for source in "$from"/*.obj "$from"/*.OBJ; do
    [ -e "$source" ] || continue
    found=$((found + 1))
    file=${source##*/}
    echo "$file" >&2
    bldsimp simplify "$@" --report "$reports/$file.json" -- "$source" "$to/${file%.*}.glb" ||
        { failed=1; echo null >"$reports/$file.json"; }
done
[ "$found" -gt 0 ] || { echo "no OBJ files in $from" >&2; exit 1; }

python3 -c '
import json, pathlib, sys
heads = "file", "points", "left", "triangles", "left", "deviation", "watertight", "seconds"
rows, total = [heads], [0, 0, 0, 0, 0.0]
for path in sorted(pathlib.Path(sys.argv[1]).iterdir()):
    done = json.loads(path.read_text())
    if done is None:
        rows.append((path.stem, "failed", "", "", "", "", "", ""))
        continue
    before, after = done["before"], done["after"]
    own = [before["points"], after["points"], before["triangles"], after["triangles"], done["seconds"]]
    total = [sum(pair) for pair in zip(total, own)]
    closed = "yes" if after["watertight"] else "no"
    counts = [f"{value:,}" for value in own[:4]]
    rows.append((path.stem, *counts, "{:.3g}".format(done["deviation"]), closed, f"{own[4]:.2f}"))
rows.append(("all", *(f"{value:,}" for value in total[:4]), "", "", f"{total[4]:.2f}"))
widths = [max(map(len, column)) for column in zip(*rows)]
for name, *cells in rows:
    line = [name.ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(cells, widths[1:]))]
    print("  ".join(line).rstrip())
' "$reports"
exit "$failed"
