#!/bin/sh
# Makes .venv with bldsimp in it, and rebuilds only what has changed since the last time.
#
# usage: sh setup.sh [EXTRAS]      EXTRAS as in pyproject.toml, with commas: test, lint, pictures, plots, bench,
#                                  compressed
# needs: Python 3.10 or later and a C++20 compiler; pip fetches everything else.
# Set PYTHON to choose the interpreter of a new .venv.
set -eu
cd "$(dirname "$0")"
extras=${1:-}
python=.venv/bin/python
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_REQUIRE_VIRTUALENV=0

say() { echo "setup: $*" >&2; }
fail() { say "$*"; exit 1; }
# Run each candidate: its name may be a launcher of a version that is not installed.
new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 10))' >/dev/null 2>&1; }

find_python() {
    for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11 python3.10 python; do
        if new_enough "$candidate"; then echo "$candidate"; return; fi
    done
    fail "no Python 3.10 or later found; install one or set PYTHON to it"
}

make_venv() {
    base=$(find_python)
    say "making .venv with $("$base" --version)"
    "$base" -m venv --clear .venv >&2 || fail "no venv module: install it (Debian: python3-venv), then run again"
}

# Print what an editable install depends on. It knows Python files by name: a new name needs a new installation, an
# edit does not.
state() {
    "$python" --version
    pwd
    echo "${CXX:-} ${CXXFLAGS:-} ${CMAKE_ARGS:-}"
    find setup.sh pyproject.toml CMakeLists.txt bldsimp/_core -type f ! -name '*.pyc' ! -name '*.so' -exec cksum {} + |
        sort
    find bldsimp -name '*.py' | sort
}

install() {
    found=
    for compiler in ${CXX:-} c++ g++ clang++; do
        if command -v "$compiler" >/dev/null 2>&1; then found=$compiler; break; fi
    done
    [ -n "$found" ] || fail "no C++ compiler found; install g++ or clang++, or set CXX"
    say "building and installing bldsimp into .venv (a minute or two)"
    "$python" -m pip --version >/dev/null 2>&1 || "$python" -m ensurepip --upgrade >/dev/null
    "$python" -m pip install -qq "scikit-build-core>=0.11" "nanobind>=2.4"
    # Ask the build backend whether it needs its own cmake and ninja.
    tools=$("$python" -c 'from scikit_build_core.build import get_requires_for_build_editable as needed
print(*(each.replace(" ", "") for each in needed()))')
    # shellcheck disable=SC2086  # one word for each requirement
    [ -z "$tools" ] || "$python" -m pip install -qq $tools
    most=$(echo ",$extras," | sed 's/,compressed,/,/; s/^,//; s/,$//')
    PATH="$PWD/.venv/bin:$PATH" "$python" -m pip install -qq --no-build-isolation -e ".${most:+[$most]}" ||
        fail "the build failed, see above; \"rm -rf build .venv\" starts again"
    # Packages of this extra may need a build with tools of their own.
    case ",$extras," in *,compressed,*) install_decoders ;; esac
}

install_decoders() {
    decoders=$("$python" -c 'from importlib.metadata import requires
print(*(each.split(";")[0].replace(" ", "") for each in requires("bldsimp") or () if "compressed" in each))')
    # shellcheck disable=SC2086  # one word for each requirement
    "$python" -m pip install -qq $decoders || fail "the decoders of compressed glTF cannot be installed, see above"
}

new_enough "$python" || make_venv
stamp=".venv/bldsimp-${extras:-base}.stamp"
now=$(state)
if [ "$now" != "$(cat "$stamp" 2>/dev/null)" ]; then
    install
    # A rebuild serves all extras, but only the extras of this run are certainly installed.
    echo "$now" >"$stamp"
    [ "$extras" = "" ] || cp "$stamp" .venv/bldsimp-base.stamp
fi
