#!/bin/sh
# Sets bldsimp up (the first time) and runs its quick tests on all cores.
#
# usage: sh tests/run.sh [--slow] [OPTIONS]    --slow runs what a quick run leaves out; options go to pytest
set -eu
cd "$(dirname "$0")/.."
sh setup.sh test
exec .venv/bin/python -m pytest -n logical "$@"
