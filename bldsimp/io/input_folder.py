"""Read the files that a model names, only from beneath the model's own folder.

A model may come from anywhere, and the files that it names may end up in the result. So a path that leaves the folder
(absolute, upwards, with a scheme) is never followed. Links within the folder are the user's own.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path, PureWindowsPath

LoadFile = Callable[[str], bytes | None]
"""Takes a relative path, returns the bytes of the file, or None if there is none."""


def find_beneath(folder: Path | None, name: str) -> Path | None:
    """Return the path of a readable file that a model in a folder names, or None if it is missing or elsewhere."""
    if folder is None or not name:
        return None
    local = os.path.normpath(name.replace("\\", "/"))
    if os.path.isabs(local) or PureWindowsPath(local).drive or local.split(os.sep)[0] == os.pardir:
        return None
    path = folder / local
    return path if os.path.isfile(path) and os.access(path, os.R_OK) else None


class InputFolder:
    """Files beneath a model's folder.

    Attributes
    ----------
    path : Path or None
    size : int
        Bytes of the files that were read, without images.
    names : list of str
        Existing files that were asked for, images too, each once.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.size = 0
        self.names: list[str] = []

    def load(self, name: str) -> bytes | None:
        """Return the bytes of a file, or None if it cannot be read."""
        data = self.load_image(name)
        self.size += len(data or b"")
        return data

    def load_image(self, name: str) -> bytes | None:
        """Return the bytes of an image; `size` does not include them."""
        path = self._find(name)
        return None if path is None else path.read_bytes()

    def has(self, name: str) -> bool:
        """Tell whether a file exists; `names` then lists it, since the result may need its bytes."""
        return self._find(name) is not None

    def _find(self, name: str) -> Path | None:
        path = find_beneath(self.path, name)
        if path is not None:
            relative = os.path.relpath(path, self.path)
            if relative not in self.names:
                self.names.append(relative)
        return path
