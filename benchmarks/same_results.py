"""Record what bldsimp makes of every model, and compare with an earlier record: the gate of a refactoring.

usage: python benchmarks/same_results.py record FILE.json [--program PATH] [--only TEXT]
       python benchmarks/same_results.py check FILE.json [--program PATH] [--only TEXT]

Each model of `data/`, of the third-party models and of a folder of small cases beside them is simplified at
three tolerances, to its own format and to GLB. A record holds the hash of each file written, the exit code,
the message of a run that fails, and the figures of the report. `check` runs all of it again, prints a line for
each difference, and exits with 1 where a hash, an exit code or a figure differs. Texts (warnings, messages) may
change: they are counted, not compared.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from surface import ROOT, find_models

SUFFIXES = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")
TOLERANCES = ("auto", "0.1%", "1%")
SECONDS = 900

RENAMED: dict[str, str] = {}
"""Report keys that got another name: the old one, and what it is called now."""


def list_models(only: str) -> Iterator[tuple[str, Path]]:
    """Yield the name and path of each model whose name contains a text."""
    models = find_models()
    for folder in (ROOT / "data", models, models.parent / "cases"):
        for path in sorted(folder.rglob("*")):
            name = f"{folder.name}/{path.relative_to(folder).as_posix()}"
            if path.suffix.lower() in SUFFIXES and only in name:
                yield name, path


def list_runs(only: str) -> Iterator[tuple[str, Path, str, str]]:
    """Yield the key, the model, the tolerance and the output format of each run."""
    for name, path in list_models(only):
        own = path.suffix[1:].lower()
        for tolerance in TOLERANCES:
            for target in sorted({own, "glb"}):
                yield f"{name} {tolerance} {target}", path, tolerance, target


def run_once(program: str, path: Path, tolerance: str, target: str) -> dict[str, Any]:
    """Simplify one model; return exit code, message, hashes and figures."""
    with tempfile.TemporaryDirectory() as folder:
        out, report = Path(folder, "out", f"result.{target}"), Path(folder, "report.json")
        out.parent.mkdir()
        command = [program, "simplify", str(path), str(out), "--tolerance", tolerance, "--report", str(report)]
        try:
            done = subprocess.run([*command, "--quiet"], capture_output=True, text=True, timeout=SECONDS, check=False)
        except subprocess.TimeoutExpired:
            return {"code": None, "message": "timeout", "files": {}, "figures": {}, "texts": []}
        written = (file for file in sorted(out.parent.rglob("*")) if file.is_file())
        files = {
            file.relative_to(out.parent).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest() for file in written
        }
        figures, texts = split_report(json.loads(report.read_text("utf-8"))) if report.exists() else ({}, [])
        message = done.stderr.replace(str(path), path.name).strip()
        return {"code": done.returncode, "message": message, "files": files, "figures": figures, "texts": texts}


def split_report(report: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Split a report into figures by their path, and its texts."""
    figures: dict[str, Any] = {}
    texts: list[str] = []

    def walk(path: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                walk(f"{path}.{key}" if path else key, inner)
        elif isinstance(value, list):
            figures[f"{path}.length"] = len(value)
            for index, inner in enumerate(value):
                walk(f"{path}.{index}", inner)
        elif isinstance(value, str):
            texts.append(f"{path}: {value}")
        else:
            figures[path] = value

    walk("", {key: value for key, value in report.items() if key not in ("seconds", "schema")})
    return figures, texts


def rename(path: str) -> str:
    """Return the name that a figure has now."""
    return ".".join(RENAMED.get(word, word) for word in path.split("."))


def find_differences(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Describe each difference of one run that counts."""
    differences = []
    if old["code"] != new["code"]:
        differences.append(f"exit code {old['code']} -> {new['code']} ({new['message']})")
    if old["files"] != new["files"]:
        names = sorted(old["files"].keys() | new["files"].keys())
        changed = [name for name in names if old["files"].get(name) != new["files"].get(name)]
        differences.append(f"bytes of {', '.join(changed)}")
    before = {rename(path): value for path, value in old["figures"].items()}
    for path in sorted(before.keys() & new["figures"].keys()):
        if before[path] != new["figures"][path]:
            differences.append(f"{path} {before[path]} -> {new['figures'][path]}")
    missing = sorted(before.keys() - new["figures"].keys())
    if missing:
        differences.append(f"missing: {', '.join(missing)}")
    return differences


def main() -> int:
    """Run the program over all models, and record or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mode", choices=("record", "check"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--program", default=str(Path(sys.executable).with_name("bldsimp")))
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    runs = list(list_runs(given.only))
    with ThreadPoolExecutor(given.jobs) as pool:
        results = pool.map(lambda run: run_once(given.program, *run[1:]), runs)
        found = {run[0]: result for run, result in zip(runs, results, strict=True)}
    if given.mode == "record":
        given.file.write_text(json.dumps(found, indent=1), encoding="utf-8")
        print(f"{len(found)} runs recorded in {given.file}")
        return 0
    recorded = json.loads(given.file.read_text("utf-8"))
    differing = texts = 0
    for key, new in found.items():
        old = recorded.get(key)
        differences = ["not in the record"] if old is None else find_differences(old, new)
        differing += bool(differences)
        if old is not None:
            texts += old["texts"] != new["texts"] or old["message"] != new["message"]
        for line in differences:
            print(f"{key}: {line}")
    print(f"{len(found)} runs: {len(found) - differing} same, {differing} differ; texts differ in {texts}")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
