#!/bin/sh
# Simplifies every OBJ of a folder to a GLB of the same name in another folder.
#
# usage: sh simplify_folder.sh FROM TO [OPTION of bldsimp simplify]...
# Goes on after a file that fails, and exits with 1 if any did.
set -u
[ $# -ge 2 ] || { echo "usage: sh simplify_folder.sh FROM TO [OPTION]..." >&2; exit 2; }
from=$1 to=$2
shift 2
mkdir -p "$to" || exit 1
failed=0
for source in "$from"/*.obj; do
    [ -e "$source" ] || { echo "no OBJ files in $from" >&2; exit 1; }
    name=$(basename "$source" .obj)
    echo "$name" >&2
    bldsimp simplify "$source" "$to/$name.glb" "$@" || failed=1
done
exit $failed
