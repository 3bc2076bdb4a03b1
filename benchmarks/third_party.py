"""Where the third-party models are, which are not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def models_folder() -> Path:
    """Folder of the models: BLDSIMP_MODELS, or `../shared/models` beside the checkout.

    Raises
    ------
    SystemExit
        Where it is missing; says what to do.
    """
    folder = Path(os.environ.get("BLDSIMP_MODELS") or ROOT.parent / "shared" / "models")
    if not folder.is_dir():
        raise SystemExit(f"{folder}: no such folder: set BLDSIMP_MODELS to that of the third-party models")
    return folder
