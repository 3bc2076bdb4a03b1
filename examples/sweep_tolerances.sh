#!/bin/sh
# Simplifies one model at several tolerances and prints what each costs and saves.
#
# usage: sh sweep_tolerances.sh FILE [TOLERANCE]...      (auto 0.01% 0.1% 0.5% 1% where none is given)
# Writes NAME_TOLERANCE.glb into the folder NAME_sweep here, or into the folder that OUT names, over
# what an earlier run wrote. Goes on after a tolerance that fails, and exits with 1 if any did.
set -u
[ $# -ge 1 ] || { echo "usage: sh sweep_tolerances.sh FILE [TOLERANCE]..." >&2; exit 2; }
source=$1
shift
[ $# -gt 0 ] || set -- auto 0.01% 0.1% 0.5% 1%
name=${source##*/}
name=${name%.*}
out=${OUT:-${name}_sweep}
mkdir -p -- "$out" || exit 1
reports=$(mktemp -d) || exit 1
trap 'rm -rf "$reports"' EXIT
trap 'exit 130' INT TERM
failed=0 k=0
for tolerance; do
    k=$((k + 1))
    # A percent sign in a name is a nuisance in links.
    case $tolerance in *%) label=${tolerance%\%}pct ;; *) label=$tolerance ;; esac
    bldsimp simplify -q --overwrite --tolerance "$tolerance" --report "$reports/$k.json" -- \
        "$source" "$out/${name}_$label.glb" || { failed=1; echo null >"$reports/$k.json"; }
done

python3 -c '
import json, pathlib, sys
rows = [("tolerance", "model units", "points", "of input", "triangles", "deviation", "kB", "seconds")]
for k, written in enumerate(sys.argv[2:], 1):
    done = json.loads(pathlib.Path(sys.argv[1], f"{k}.json").read_text())
    if done is None:
        rows.append((written, "failed", "", "", "", "", "", ""))
        continue
    after = done["after"]
    share = after["points"] / max(done["before"]["points"], 1)
    moved, size = done["deviation"], after["bytes"] / 1000
    rows.append((written, "{:.3g}".format(done["tolerance"]), "{:,}".format(after["points"]), f"{share:.1%}",
                 "{:,}".format(after["triangles"]), f"{moved:.3g}", f"{size:,.1f}", "{:.2f}".format(done["seconds"])))
widths = [max(map(len, column)) for column in zip(*rows)]
for row in rows:
    print("  ".join(cell.rjust(width) for cell, width in zip(row, widths)).rstrip())
' "$reports" "$@"
exit "$failed"
