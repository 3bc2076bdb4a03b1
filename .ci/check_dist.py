"""Check that a wheel and a source archive contain all that is needed, and nothing else.

usage: check_dist.py WHEEL SOURCE_ARCHIVE
"""

from __future__ import annotations

import sys
import tarfile
import zipfile


def demand(condition: bool, message: str) -> None:
    """Stop with a message unless the condition holds."""
    if not condition:
        sys.exit(f"check_dist: {message}")


def check_wheel(names: list[str]) -> None:
    """Check for package, compiled core, type information and license, and against sources and tests."""
    files = ("__init__.py", "py.typed", "_core.pyi", "cli/__init__.py", "compare/page.html", "compare/page.js")
    viewer = ("compare/three-0.187.0.min.js", "compare/three-LICENSE.txt")
    for needed in (*files, *viewer):
        demand(f"bldsimp/{needed}" in names, f"the wheel lacks bldsimp/{needed}")
    cores = [name for name in names if name.startswith("bldsimp/_core") and name.endswith((".so", ".pyd"))]
    demand(len(cores) == 1, f"the wheel has {len(cores)} compiled cores, not one")
    demand(any(name.endswith("LICENSE") for name in names), "the wheel lacks the license")
    foreign = [name for name in names if not name.startswith(("bldsimp/", "bldsimp-"))]
    demand(not foreign, f"the wheel contains {foreign}")
    sources = [name for name in names if name.endswith((".cpp", ".hpp", ".txt", ".pyc")) and "/licenses/" not in name]
    sources = [name for name in sources if not name.endswith(("entry_points.txt", *viewer))]
    demand(not sources, f"the wheel contains {sources}")


def check_archive(names: list[str]) -> None:
    """Check for everything that builds and tests bldsimp, and against build products."""
    inner = {name.split("/", 1)[1] for name in names if "/" in name}
    needed = ("CMakeLists.txt", "pyproject.toml", "LICENSE", "README.md", "setup.sh", "tests/run.sh")
    for name in (*needed, "bldsimp/_core/bindings/module.cpp", "data/building_a.obj"):
        demand(name in inner, f"the source archive lacks {name}")
    products = [name for name in inner if name.endswith((".so", ".o", ".pyc")) or name.startswith(("build/", ".venv"))]
    demand(not products, f"the source archive contains {products[:5]}")


def main() -> None:
    """Check both files named on the command line."""
    wheel, archive = sys.argv[1:]
    with zipfile.ZipFile(wheel) as opened:
        check_wheel(opened.namelist())
    with tarfile.open(archive) as opened_archive:
        check_archive(opened_archive.getnames())
    print("wheel and source archive are complete")


if __name__ == "__main__":
    main()
