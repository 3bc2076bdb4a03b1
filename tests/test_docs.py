"""What the documents name is there: every function under its name, in the file that is linked."""

from __future__ import annotations

import ast
import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

DOCS = sorted((ROOT / "docs").glob("*.md"))
LINK = re.compile(r"\[([^\]]*)\]\(([^):#]+)\)")


def links(document: Path) -> list[tuple[str, Path]]:
    """Words and target of each link to a file."""
    text = document.read_text(encoding="utf-8")
    return [(words, (document.parent / target).resolve()) for words, target in LINK.findall(text)]


def python_names(source: str) -> set[str]:
    """Functions, methods, classes and top-level values that a module defines."""
    tree = ast.parse(source)
    definitions = (ast.FunctionDef, ast.ClassDef)
    names = {node.name for node in ast.walk(tree) if isinstance(node, definitions)}
    for node in tree.body:
        if isinstance(node, ast.Assign):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return names


def cpp_names(source: str) -> set[str]:
    """Functions that a file declares or defines, and its types, with and without their namespace."""
    code = re.sub(r"//.*", "", source)
    names = set(re.findall(r"^\s*(?:struct|class|enum class)\s+(\w+)", code, re.MULTILINE))
    # A name that follows a type and precedes an open bracket; a call follows an operator or opens a line.
    declared = re.compile(
        r"^[ \t]*(?![ \t]|return\b|throw\b|else\b)[\w:<>,&* ]*[\w>&*]\s+[&*]?(?:\w+::)?(\w+)\(", re.MULTILINE
    )
    names |= set(declared.findall(code))
    for space, body in re.findall(r"^namespace (\w+) \{\n(.*?)^\}", code, re.MULTILINE | re.DOTALL):
        names |= {f"{space}::{name}" for name in declared.findall(body)}
    return names


@pytest.mark.parametrize("document", DOCS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    missing = [str(target) for _, target in links(document) if not target.exists()]
    assert missing == []


@pytest.mark.parametrize("document", DOCS, ids=lambda path: path.name)
def test_names_are_defined_in_the_files_they_link_to(document: Path) -> None:
    named = [(words.strip("`"), target) for words, target in links(document) if words.startswith("`")]
    named = [(name, target) for name, target in named if target.suffix in (".py", ".cpp", ".hpp")]
    named = [(name, target) for name, target in named if "/" not in name]
    for name, target in named:
        source = target.read_text(encoding="utf-8")
        known = python_names(source) if target.suffix == ".py" else cpp_names(source)
        assert name in known, f"{target.name} defines no {name}"


def test_a_name_that_is_only_called_is_not_taken_for_a_definition() -> None:
    names = cpp_names(
        "struct Net {};\nint walk(Index h) {\n  return step(h);\n  jump(h);\n  if (skip(h)) x = hop(h);\n}\n"
    )
    assert names == {"Net", "walk"}
    assert python_names("A = 1\ndef f():\n    return g()\n") == {"A", "f"}


def test_each_formula_step_and_figure_of_the_article_has_its_row() -> None:
    text = (ROOT / "docs" / "from_the_article.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    for start in (
        "(1)",
        "(2) and (3)",
        *(f"{k}. " for k in range(1, 7)),
        *(f"{k}, " for k in range(1, 5)),
        "5 and 6",
        "7,",
    ):
        (row,) = [line for line in rows if line.startswith(f"| {start}")]
        assert "](../" in row


@pytest.fixture(scope="module")
def figures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the one command that makes the figures writes today."""
    pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
    pytest.importorskip("PIL", reason="the extra 'pictures' is not installed")
    folder = tmp_path_factory.mktemp("figures")
    subprocess.run([sys.executable, ROOT / "examples" / "compare_buildings.py", folder], check=True)
    return folder


def rows_of(path: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    """Rows of a CSV by file, tolerance and method."""
    with path.open(encoding="utf-8", newline="") as opened:
        return {(row["file"], row["tolerance"], row["method"]): row for row in csv.DictReader(opened)}


def test_the_figures_are_those_of_today(figures: Path) -> None:
    shown, today = (rows_of(folder / "buildings.csv") for folder in (ROOT / "docs", figures))
    assert list(shown) == list(today)
    for key, row in today.items():
        for name in ("points", "triangles", "watertight", "border_made", "note"):
            assert row[name] == shown[key][name], (
                f"{key}: run examples/compare_buildings.py, and see what the text says"
            )
    made = sorted(path.name for path in figures.iterdir())
    assert made == ["building_a_methods.png", "building_b_methods.png", "buildings.csv", "points.svg"]
    assert all((ROOT / "docs" / name).stat().st_size > 10_000 for name in made if name != "buildings.csv")


def test_the_table_is_the_csv_and_improved_never_has_more_points_than_standard() -> None:
    rows = rows_of(ROOT / "docs" / "buildings.csv")
    text = (ROOT / "docs" / "from_the_article.md").read_text(encoding="utf-8")
    files = dict.fromkeys(file for file, _, _ in rows)
    tolerances = dict.fromkeys(tolerance for _, tolerance, _ in rows)
    for file, letter in zip(files, "AB", strict=True):
        for tolerance in tolerances:
            counts = [int(rows[file, tolerance, method]["points"]) for method in ("original", "standard", "improved")]
            assert counts[2] <= counts[1]
            assert f"| {letter} | {tolerance} | " + " | ".join(f"{count:,}" for count in counts) + " |" in text
