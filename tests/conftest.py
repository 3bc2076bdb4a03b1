"""What several test files share."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> None:
    """Programs that the tests start can be interrupted, even where the tests run in a shell's background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def models_folder() -> Path:
    """Where the third-party models are, if they are; for tests made one per file."""
    return Path(os.environ.get("BLDSIMP_MODELS") or ROOT.parent / "shared" / "models")


@pytest.fixture(scope="session")
def models() -> Path:
    """Folder of third-party models, which are not part of the repository."""
    folder = models_folder()
    if not folder.is_dir():
        pytest.skip("no third-party models: set BLDSIMP_MODELS to their folder")
    return folder


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of the project's own buildings."""
    return ROOT / "data"
