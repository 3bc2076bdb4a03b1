"""The rules of the house: who may import whom, how long things may be, and that each name means one thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from conftest import ROOT

PACKAGE = ROOT / "bldsimp"
FLOORS = (
    ("errors", "material"),
    ("options", "display"),
    ("model",),
    ("tolerance", "unique_rows", "testing", "triangulation", "trimesh_adapter"),
    ("stages",),
    ("result", "report"),
    ("pipeline",),
    ("scene", "inspection"),
    ("io",),
    ("compare",),
    ("job", "api"),
    ("batch",),
    ("cli",),
)
"""Rooms from the ground up: a module imports from its own floor or from below."""

SILENT = ("tolerance", "unique_rows", "triangulation", "stages", "result")
"""Rooms that know neither files nor the screen; `pipeline` writes an input that fails, where asked."""

OUTSIDE = {"click", "glob", "io", "logging", "os", "pathlib", "shutil", "subprocess", "sys", "tempfile"}
"""Modules that lead to files or to the screen."""

LONGEST_FUNCTION = 60
LONGEST_FILE = 450
MOST_NOQA = 10

UPWARD: set[tuple[str, str]] = set()
"""Imports that still lead upwards; may only shrink."""

CIRCLES: set[str] = set()
"""Modules that are still in a circle; may only shrink."""

TWICE: set[str] = set()
"""Public names that two modules still define for different things; may only shrink."""


@cache
def parse(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def load_modules() -> dict[str, ast.Module]:
    """Return the syntax tree of each module of the package by its dotted name without `bldsimp.`."""
    trees = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        trees[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = parse(path)
    return trees


def find_imports(name: str, tree: ast.AST) -> Iterator[tuple[str, list[str]]]:
    """Yield each module of the package that a module imports, with the names that it takes from there."""
    known = load_modules()
    is_package = (PACKAGE / Path(*name.split("."))).is_dir()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            assert not any(alias.name.startswith("bldsimp") for alias in node.names), f"{name}: import relatively"
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        parents = name.split(".") if name else []
        parents = parents[: len(parents) - node.level + is_package]
        home = ".".join(parents + (node.module.split(".") if node.module else []))
        for alias in node.names:
            inner = f"{home}.{alias.name}".strip(".")
            yield (inner, []) if inner in known or inner == "_core" else (home, [alias.name])


@cache
def build_graph() -> dict[str, set[str]]:
    """Return the modules that each module imports, without the core and the package itself."""
    return {
        name: {target for target, _ in find_imports(name, tree) if target not in ("", "_core", name)}
        for name, tree in load_modules().items()
    }


def find_floor(module: str) -> int:
    """Return the floor of a module."""
    (floor,) = [number for number, rooms in enumerate(FLOORS) if module.split(".")[0] in rooms]
    return floor


def test_every_room_has_a_floor() -> None:
    rooms = {name.split(".")[0] for name in load_modules()} - {""}
    assert rooms <= {room for rooms in FLOORS for room in rooms}


def test_imports_lead_downwards() -> None:
    found = {
        (name, target)
        for name, targets in build_graph().items()
        if name
        for target in targets
        if find_floor(target) > find_floor(name)
    }
    assert found == UPWARD


def test_no_imports_run_in_a_circle() -> None:
    edges = build_graph()
    reached = {name: set(targets) for name, targets in edges.items() if name}
    for _ in reached:
        grown = {name: targets.union(*(reached[target] for target in targets)) for name, targets in reached.items()}
        if grown == reached:
            break
        reached = grown
    assert {name for name, targets in reached.items() if name in targets} == CIRCLES


def test_the_core_has_one_door() -> None:
    """`from .. import _core` alone, so that a reader finds every call of a kernel by `_core.`."""
    for name, tree in load_modules().items():
        for target, names in find_imports(name, tree):
            assert not (target == "_core" and names), f"{name}: from .. import _core"
        aliases = [node for node in ast.walk(tree) if isinstance(node, ast.alias) and "_core" in node.name]
        assert all(alias.name == "_core" and not alias.asname for alias in aliases), name


def find_libraries(tree: ast.AST) -> set[str]:
    """Return the top names of the libraries that a module imports."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        if isinstance(node, ast.ImportFrom) and not node.level and node.module:
            found.add(node.module.split(".")[0])
    return found


def find_calls(tree: ast.AST) -> set[str]:
    """Return the plain names that a module calls."""
    return {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}


def test_stages_know_neither_files_nor_the_screen() -> None:
    for name, tree in load_modules().items():
        if name.split(".")[0] in SILENT:
            assert not find_libraries(tree) & OUTSIDE, name
            assert not find_calls(tree) & {"open", "print", "input"}, name


def test_only_the_command_line_prints() -> None:
    for name, tree in load_modules().items():
        if name.split(".")[0] != "cli":
            assert "click" not in find_libraries(tree), name
            assert "print" not in find_calls(tree), name


# Sizes and names


def list_python_files() -> list[Path]:
    """Return every Python file of the checkout."""
    rooms = ("bldsimp", "tests", "benchmarks", "examples", ".ci")
    return sorted(path for room in rooms for path in (ROOT / room).rglob("*.py"))


def list_source_files() -> list[Path]:
    """Return every file of code of the checkout."""
    suffixes = (".cpp", ".hpp", ".js", ".html", ".sh")
    rooms = ("bldsimp", "tests", "benchmarks", "examples")
    others = [path for room in rooms for path in (ROOT / room).rglob("*") if path.suffix in suffixes]
    return list_python_files() + sorted(path for path in others if ".min." not in path.name)


def test_no_function_is_too_long() -> None:
    long = []
    for path in list_python_files():
        for node in ast.walk(parse(path)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                first = node.body[0]
                documented = ast.get_docstring(node) is not None
                words = (first.end_lineno or 0) - first.lineno + 1 if documented else 0
                length = (node.end_lineno or 0) - node.lineno + 1 - words
                if length > LONGEST_FUNCTION:
                    long.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}: {length} lines")
    assert long == []


def test_no_file_is_too_long() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in list_source_files()}
    long = {str(path.relative_to(ROOT)): length for path, length in lengths.items() if length > LONGEST_FILE}
    assert long == {}


def test_few_warnings_are_switched_off_and_each_has_its_reason() -> None:
    """A reason stands behind the rule, or in a comment on the line above."""
    found = []
    for path in list_python_files():
        above = ""
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            switch = re.search(r"# [n]oqa(?P<rules>: ?[A-Z0-9, ]*[0-9])?(?P<reason>.*)", line)
            if switch:
                found.append(f"{path.relative_to(ROOT)}:{number}")
                assert switch["rules"], f"{found[-1]}: name the rule"
                assert switch["reason"].strip(" :#-") or above.startswith("#"), f"{found[-1]}: say why"
            above = line.strip()
    assert len(found) <= MOST_NOQA, found


def test_a_public_name_means_one_thing() -> None:
    """Commands of the command line are named after the functions that they call."""
    homes = defaultdict(set)
    for module, tree in load_modules().items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                is_command = any("command" in ast.unparse(decorator) for decorator in node.decorator_list)
                homes[node.name] |= set() if is_command else {module}
    found = {name for name, where in homes.items() if len(where) > 1}
    assert found == TWICE, {name: sorted(homes[name]) for name in found ^ TWICE}
