#!/bin/sh
# Simplifies files one after the other into a folder, and stops at the first that came out worse: more
# points than before, no longer watertight, or a deviation beyond the tolerance. Made for a build
# that must not go on with a bad model.
#
# usage: sh stop_when_worse.sh TOLERANCE TO FILE...
# Writes TO/NAME.glb, over what is there. Exits with 0 when all are good, with 3 at one that is worse (its GLB
# stays, to be looked at), and as bldsimp does at one that it cannot read or write.
set -u
[ $# -ge 3 ] || { echo "usage: sh stop_when_worse.sh TOLERANCE TO FILE..." >&2; exit 2; }
tolerance=$1 to=$2
shift 2
mkdir -p -- "$to" || exit 1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
for source; do
    name=${source##*/}
    result=$to/${name%.*}.glb
    bldsimp simplify -q --overwrite --tolerance "$tolerance" --report "$work/report.json" -- "$source" "$result" ||
        exit $?
    # What counts is what a reader of the file finds, not what the run says that it wrote.
    bldsimp inspect --json -- "$result" >"$work/result.json" || exit $?
    python3 -c '
import json, sys
report, result, name = json.load(open(sys.argv[1])), json.load(open(sys.argv[2]))["total"], sys.argv[3]
before, moved, allowed = report["before"], report["deviation"], report["tolerance"]
worse = []
if result["points"] > before["points"]:
    worse.append("{:,} points became {:,}".format(before["points"], result["points"]))
if before["watertight"] and not result["watertight"]:
    worse.append("it is no longer watertight")
if moved > allowed:
    worse.append(f"its surface may have moved by {moved:.3g}, more than {allowed:.3g}")
if worse:
    sys.exit(f"{name} came out worse: " + ", ".join(worse))
print("{}: {:,} points -> {:,}, within {:.3g}".format(name, before["points"], result["points"], moved))
' "$work/report.json" "$work/result.json" "$source" || exit 3
done
