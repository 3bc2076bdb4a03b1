"""Run the Khronos glTF validator, if node and its npm package are installed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("validate_gltf.js")


def list_issues(*files: Path) -> list[Counter[str]]:
    """List the codes of the errors and warnings of each file; skip the test if the validator is missing."""
    node = shutil.which("node")
    run = node and subprocess.run([node, str(SCRIPT), *map(str, files)], capture_output=True, text=True)
    if not run or run.returncode == 3:
        missing = "node is not installed" if not run else run.stderr.strip()
        if os.environ.get("BLDSIMP_NEED_VALIDATOR") == "1":
            pytest.fail(missing)
        pytest.skip(f"{missing}: 'npm install --no-save gltf-validator' in the checkout")
    assert run.returncode == 0, run.stderr
    return [Counter(issue["code"] for issue in found) for found in json.loads(run.stdout)]


def assert_no_new_issues(before: Path, *after: Path) -> None:
    """Check that no file has an error or warning more often than the first has."""
    old, *new = list_issues(before, *after)
    for path, found in zip(after, new, strict=True):
        assert not found - old, f"{path.name}: {dict(found - old)}"
