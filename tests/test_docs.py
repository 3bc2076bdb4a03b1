"""What the documents name is there, and they are as plain and short as they should be."""

from __future__ import annotations

import ast
import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

from bldsimp import _core
from bldsimp.cli import main

DOCS = sorted((ROOT / "docs").glob("*.md"))
ALL = [*sorted(ROOT.glob("*.md")), *DOCS]
ARCHITECTURE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
LINK = re.compile(r"\[([^\]]*)\]\(([^):#]*)(?:#([^)]*))?\)")
OTHERS = {"--slow", "--no-save", "--min-part", "--allow-close", "--help"}
"""Options of pytest and npm, and the hidden ones."""

LONGEST_SENTENCE = 30
PLAIN = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "compare.md", "decisions.md", "formats.md",
         "from_the_article.md")  # fmt: skip


def find_links(document: Path) -> list[tuple[str, Path, str]]:
    """Return words, target and anchor of each link to a file."""
    text = document.read_text(encoding="utf-8")
    return [
        (words, (document.parent / target).resolve() if target else document, anchor)
        for words, target, anchor in LINK.findall(text)
        if not target.startswith("http")
    ]


def find_anchors(document: Path) -> set[str]:
    """Return the anchors that GitHub gives to the headings of a document."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def find_sentences(text: str) -> list[str]:
    """Return the sentences of a Markdown text, without tables and code."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = "\n".join(line for line in text.splitlines() if not line.startswith(("|", "!", "    ")))
    blocks = re.split(r"\n\s*\n|\n(?=\s*[-*] |\s*\d+\. |#)", LINK.sub(r"\1", text))
    return [one for block in blocks for one in re.split(r"(?<=[.?!])\s+(?=[A-Z`*(])", " ".join(block.split()))]


def find_python_names(source: str) -> set[str]:
    """Return functions, methods, classes and top-level values that a module defines."""
    tree = ast.parse(source)
    definitions = (ast.FunctionDef, ast.ClassDef)
    names = {node.name for node in ast.walk(tree) if isinstance(node, definitions)}
    for node in tree.body:
        if isinstance(node, ast.Assign):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return names


def find_cpp_names(source: str) -> set[str]:
    """Return functions that a file declares or defines, and its types, with and without their namespace."""
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


@pytest.mark.parametrize("document", ALL, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    for _, target, anchor in find_links(document):
        assert target.exists(), target
        assert not anchor or anchor in find_anchors(target), anchor


@pytest.mark.parametrize("document", [path for path in ALL if path.name in PLAIN], ids=lambda path: path.name)
def test_sentences_are_short(document: Path) -> None:
    sentences = find_sentences(document.read_text(encoding="utf-8"))
    assert [one for one in sentences if len(one.split()) > LONGEST_SENTENCE] == []


def test_options_that_texts_name_exist(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("simplify", "inspect", "compare", "batch"):
        assert main([command, "--help"]) == 0
    known = set(re.findall(r"--[a-z][a-z-]+", capsys.readouterr().out)) | OTHERS
    for document in ALL:
        told = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", document.read_text(encoding="utf-8")))
        assert told <= known, document.name


def test_the_architecture_is_short() -> None:
    assert len(ARCHITECTURE.split()) <= 1500


def test_the_tree_of_the_architecture_is_that_of_the_checkout() -> None:
    tree = ARCHITECTURE.split("## The tree")[1].split("```")[1]
    named = set()
    for line in tree.strip().splitlines():
        folder = ROOT / "bldsimp" if line.startswith(" ") else ROOT
        names = re.split(r"\s{3,}", line.strip())[0].split()
        assert all((folder / name).exists() for name in names), line
        named |= {(folder / name).resolve() for name in names}
    rooms = {path for path in (ROOT / "bldsimp").iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert rooms <= named


def test_the_kernels_that_the_architecture_names_exist() -> None:
    rows = ARCHITECTURE.split("| stage | kernel |")[1].split("\n\n")[0].splitlines()[2:]
    assert len(rows) >= 10
    for row in rows:
        for name in re.findall(r"`(\w+)`", row.split("|")[2]):
            assert callable(getattr(_core, name)), name


@pytest.mark.parametrize("document", DOCS, ids=lambda path: path.name)
def test_names_are_defined_in_the_files_they_link_to(document: Path) -> None:
    named = [(words.strip("`"), target) for words, target, _ in find_links(document) if words.startswith("`")]
    named = [(name, target) for name, target in named if target.suffix in (".py", ".cpp", ".hpp")]
    named = [(name, target) for name, target in named if "/" not in name]
    for name, target in named:
        source = target.read_text(encoding="utf-8")
        known = find_python_names(source) if target.suffix == ".py" else find_cpp_names(source)
        assert name in known, f"{target.name} defines no {name}"


def test_a_name_that_is_only_called_is_not_taken_for_a_definition() -> None:
    names = find_cpp_names(
        "struct Net {};\nint walk(Index h) {\n  return step(h);\n  jump(h);\n  if (skip(h)) x = hop(h);\n}\n"
    )
    assert names == {"Net", "walk"}
    assert find_python_names("A = 1\ndef f():\n    return g()\n") == {"A", "f"}


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
    """Run the one command that makes the figures, into a folder of its own."""
    pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
    pytest.importorskip("PIL", reason="the extra 'pictures' is not installed")
    folder = tmp_path_factory.mktemp("figures")
    subprocess.run([sys.executable, ROOT / "examples" / "compare_buildings.py", folder], check=True)
    return folder


def read_rows(path: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    """Return the rows of a CSV by file, tolerance and method."""
    with path.open(encoding="utf-8", newline="") as opened:
        return {(row["file"], row["tolerance"], row["method"]): row for row in csv.DictReader(opened)}


@pytest.mark.slow
def test_the_figures_are_those_of_today(figures: Path) -> None:
    shown, today = (read_rows(folder / "buildings.csv") for folder in (ROOT / "docs", figures))
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
    rows = read_rows(ROOT / "docs" / "buildings.csv")
    text = (ROOT / "docs" / "from_the_article.md").read_text(encoding="utf-8")
    files = dict.fromkeys(file for file, _, _ in rows)
    tolerances = dict.fromkeys(tolerance for _, tolerance, _ in rows)
    for file, letter in zip(files, "AB", strict=True):
        for tolerance in tolerances:
            counts = [int(rows[file, tolerance, method]["points"]) for method in ("original", "standard", "improved")]
            assert counts[2] <= counts[1]
            assert f"| {letter} | {tolerance} | " + " | ".join(f"{count:,}" for count in counts) + " |" in text
