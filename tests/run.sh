#!/bin/sh
# Sets bldsimp up (the first time) and runs its tests; options go to pytest.
set -eu
cd "$(dirname "$0")/.."
sh setup.sh test
exec .venv/bin/python -m pytest "$@"
