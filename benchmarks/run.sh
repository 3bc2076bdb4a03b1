#!/bin/sh
# Run all benchmarks and print them as Markdown; a few minutes on a quiet machine:
#
#     sh benchmarks/run.sh >benchmarks/results/VERSION.md
#
# Needs bldsimp[bench] in the environment of PYTHON (default: that of setup.sh), and the third-party models in
# BLDSIMP_MODELS or in ../shared/models beside the checkout. Arguments choose sections: block anchors ...
# The section "tolerance" runs where BLDSIMP_JUDGE names a script that measures (see tolerance.py).
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-.venv/bin/python}
models=${BLDSIMP_MODELS:-../shared/models}
chosen=" ${*:-pipeline block triangulation anchors decimation tolerance normals startup textured batch models} "

section() { # NAME TITLE SCRIPT ARGUMENT...
    case $chosen in *" $1 "*) ;; *) return 0 ;; esac
    printf '\n## %s\n\n' "$2"
    script=$3
    shift 3
    echo "$script: running" >&2
    "$python" "benchmarks/$script" "$@"
}

echo "# Figures of bldsimp $("$python" -c 'import bldsimp; print(bldsimp.__version__)')"
echo
"$python" benchmarks/machine.py
section pipeline "One run: calls, functions, stages" pipeline.py
section block "The over-sampled block" block.py "$models/exact/oversampled_minimal.ply"
section block "Stages of the over-sampled block" block.py --stages --runs 3 "$models/exact/oversampled_minimal.ply"
section triangulation "The triangulation" triangulation.py
section anchors "Points beside the best peer" anchors.py
section decimation "Points that fast-simplification keeps" decimation.py
if [ -n "${BLDSIMP_JUDGE:-}" ]; then
    section tolerance "Wide tolerances" tolerance.py "$BLDSIMP_JUDGE"
fi
section normals "Walls that look like walls" normals.py
section startup "From start to end" startup.py
section textured "A textured GLB from start to end" textured.py
section batch "Many files" batch.py
section models "Every model" models.py
section models "Every model, textures and colors ignored" models.py --delimit none --tolerance auto
