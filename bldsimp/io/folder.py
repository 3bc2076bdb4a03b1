"""Files that a model names: read only beneath the model's own folder.

A model may come from anywhere, and what it names may end up in the result; so that a path that leaves the folder
(absolute, upwards, of a scheme) is not followed, whatever stands there. Links within the folder are the user's own.
"""

from __future__ import annotations

import os
from pathlib import Path, PureWindowsPath


def beneath(folder: Path | None, name: str) -> Path | None:
    """The path of a readable file that a model in a folder names; None where there is none, or it is elsewhere."""
    if folder is None or not name:
        return None
    local = os.path.normpath(name.replace("\\", "/"))
    if os.path.isabs(local) or PureWindowsPath(local).drive or local.split(os.sep)[0] == os.pardir:
        return None
    path = folder / local
    return path if os.path.isfile(path) and os.access(path, os.R_OK) else None


class Folder:
    """Files beneath a model's folder.

    Attributes
    ----------
    path : Path or None
    size : int
        Bytes that were read but for images.
    names : list of str
        Files that were asked for and are there, images too, each once.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.size = 0
        self._names: dict[str, None] = {}

    @property
    def names(self) -> list[str]:
        return list(self._names)

    def __call__(self, name: str) -> bytes | None:
        """The bytes of a file, or None where there is none to be read."""
        data = self.picture(name)
        self.size += len(data or b"")
        return data

    def picture(self, name: str) -> bytes | None:
        """The bytes of an image, which do not count."""
        path = self._find(name)
        return None if path is None else path.read_bytes()

    def has(self, name: str) -> bool:
        """Whether there is a file; it counts as asked for, since the result may want its bytes."""
        return self._find(name) is not None

    def _find(self, name: str) -> Path | None:
        path = beneath(self.path, name)
        if path is not None:
            self._names[os.path.relpath(path, self.path)] = None
        return path
