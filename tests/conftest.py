"""Options, profiles and fixtures that all tests share."""

from __future__ import annotations

import os
import signal
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
SLOW = "slow: sh tests/run.sh --slow runs them"

# A quick run tries a fifth of the examples. Both try the same ones every time, unless they are to look for new ones.
SAME = "BLDSIMP_RANDOM" not in os.environ
settings.register_profile("quick", max_examples=20, deadline=None, derandomize=SAME)
settings.register_profile("slow", max_examples=100, deadline=None, derandomize=SAME)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--slow`."""
    parser.addoption("--slow", action="store_true", help="run what a quick run leaves out, and no more")


def pytest_configure(config: pytest.Config) -> None:
    """Choose how many examples Hypothesis tries, before the tests are imported."""
    settings.load_profile("slow" if config.getoption("--slow") else "quick")


def is_slow(item: pytest.Item) -> bool:
    """Return whether a test waits for a slow run: it is marked, or starts a browser."""
    return item.get_closest_marker("slow") is not None or "browser" in item.fixturenames


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip slow tests, or with `--slow` leave out all others but those that try random examples."""
    if config.getoption("--slow"):
        wanted = [is_slow(item) or hasattr(item.obj, "hypothesis") for item in items]
        config.hook.pytest_deselected(items=[item for item, kept in zip(items, wanted, strict=True) if not kept])
        items[:] = [item for item, kept in zip(items, wanted, strict=True) if kept]
        return
    for item in items:
        if is_slow(item):
            item.add_marker(pytest.mark.skip(reason=SLOW))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say in three lines at most what was skipped, and why."""
    reasons = Counter(
        report.longrepr[2].removeprefix("Skipped: ") if isinstance(report.longrepr, tuple) else str(report.longrepr)
        for report in terminalreporter.stats.get("skipped", [])
    )
    ordered = [f"{count} {reason}" for reason, count in reasons.most_common()]
    lines = [*ordered[:2], "; ".join(ordered[2:])] if len(ordered) > 2 else ordered
    for number, line in enumerate(lines):
        terminalreporter.write_line(f"{'        ' if number else 'skipped '} {line}")


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> None:
    """Let programs that tests start be interrupted, even where the tests run in a shell's background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def models_folder() -> Path:
    """Return where the third-party models should be; for tests that exist once for each file."""
    return Path(os.environ.get("BLDSIMP_MODELS") or ROOT.parent / "shared" / "models")


@pytest.fixture(scope="session")
def models() -> Path:
    """Folder of third-party models, which are not part of the repository."""
    folder = models_folder()
    if not folder.is_dir():
        pytest.skip("need third-party models: set BLDSIMP_MODELS to their folder")
    return folder


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of the project's own buildings."""
    return ROOT / "data"
