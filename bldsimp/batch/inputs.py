"""Which files are meant, and where their results go."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import PurePosixPath
from typing import NamedTuple

from ..errors import UsageError
from ..io.read import SUFFIXES
from .row import FAILED, Row
from .storage import Entry, Storage, is_url, join, storage_of, whole
from .task import Task

_WILD = re.compile(r"[*?\[]")
_FIELDS = ("stem", "ext", "from")


class Found(NamedTuple):
    """An input: the path or URL of a folder, and what is known of the file beneath it."""

    root: str
    entry: Entry


@dataclass(frozen=True)
class Layout:
    """Where results go.

    Attributes
    ----------
    root : str
        Folder or URL that mirrors the inputs' folders.
    name : str
        Of each result: ``{stem}`` and ``{from}`` of the input, ``{ext}`` of the result stand for what they say.
    to, from_ : str or None
        Formats of all results and inputs; None for what the suffix tells.
    """

    root: str
    name: str
    to: str | None = None
    from_: str | None = None

    def __post_init__(self) -> None:
        try:
            name = self.name.format_map(dict.fromkeys(_FIELDS, "x"))
        except (KeyError, IndexError, ValueError):
            name = ""
        if not name or "/" in name or name in (".", ".."):
            raise UsageError(f"--name {self.name!r}: give a file name; {{stem}}, {{ext}} and {{from}} may stand in it")
        if self.to is not None and self.to not in SUFFIXES:
            raise UsageError(f"--to: format '{self.to}' cannot be written: use one of {', '.join(SUFFIXES)}")

    def task(self, found: Found) -> Task:
        """What is to be done with an input; its format may still be one that cannot be written."""
        path = PurePosixPath(found.entry.name)
        from_ = self.from_ or path.suffix[1:].lower()
        to = self.to or from_
        name = self.name.format_map({"stem": path.stem, "ext": to, "from": from_})
        output = str(path.with_name(name))
        return Task(found.root, found.entry.name, self.root, output, from_, to, found.entry.size, found.entry.mtime)


@dataclass
class Plan:
    """What is to be done, and rows of what cannot be."""

    tasks: list[Task] = field(default_factory=list)
    refused: list[Row] = field(default_factory=list)


def find_inputs(sources: Iterable[str], out: str) -> Iterator[Found]:
    """Files that folders, globs and names mean.

    Parameters
    ----------
    sources : iterable of str
        A folder: all files beneath it of a format that bldsimp writes, too. A glob, where ``**`` stands for any
        folders: all files that match. Else a file; its name is the path from the working directory, or the whole path
        where that leads out of it.
    out : str
        Folder of results: what is in it is no input, unless named.

    Raises
    ------
    UsageError
        Where a folder is that of the results, or nothing is there.
    """
    for given in sources:
        source = whole(given)
        storage = storage_of(source)
        if storage.is_folder(source):
            if _place(source) == _place(out):
                raise UsageError(f"{source}: is also the folder of the results: choose another for them")
            yield from _found(storage, source, "**/*", SUFFIXES, out)
        elif _WILD.search(source) and storage.entry(source, source).refusal:
            yield from _found(storage, *_split(source), (), out)
        else:
            root, name = _named(source)
            yield Found(root, storage.entry(source, name))


def plan(inputs: Iterable[Found], layout: Layout) -> Plan:
    """Pair inputs with outputs.

    Raises
    ------
    UsageError
        Where two inputs would write the same file, one would be overwritten, or no format to write is known.
    """
    result = Plan()
    sources: dict[str, str] = {}
    seen: set[str] = set()
    for found in inputs:
        if found.entry.refusal:
            result.refused.append(Row(found.entry.name or ".", "", FAILED, "refused", found.entry.refusal))
            continue
        task = layout.task(found)
        if task.to not in SUFFIXES:
            how = f"format '{task.to}' cannot be written: give --to" if task.to else "has no suffix: give --from"
            raise UsageError(f"{task.source}: {how} with one of {', '.join(SUFFIXES)}")
        source, target = _place(task.source), _place(task.target)
        other = sources.setdefault(target, source)
        if other != source:
            raise UsageError(
                f"{other} and {source} would both write {target}: tell them apart with"
                " --name, say '{stem}_{from}.{ext}', or give them one by one"
            )
        if source not in seen:
            seen.add(source)
            result.tasks.append(task)
    for target in seen & sources.keys():
        raise UsageError(f"{target}: is an input and would be overwritten: choose another folder, or --name")
    return result


def names_in(data: bytes) -> list[str]:
    """The names of a list: one a line, or with a zero byte after each, as ``find -print0`` writes them."""
    return [os.fsdecode(name) for name in data.split(b"\0" if b"\0" in data else b"\n") if name]


def _found(storage: Storage, root: str, pattern: str, suffixes: tuple[str, ...], out: str) -> Iterator[Found]:
    """Files beneath a root that match a pattern and have one of the suffixes, if any are given.

    Raises
    ------
    UsageError
        Where there are none.
    """
    matches = _expression(pattern).fullmatch

    def wanted(name: str) -> bool:
        return bool(matches(name)) and (not suffixes or PurePosixPath(name).suffix[1:].lower() in suffixes)

    none = True
    for entry in storage.find(root, wanted, out):
        none = False
        yield Found(root, entry)
    if none:
        raise UsageError(f"{join(root, pattern)}: there is no such file")


def _split(glob: str) -> tuple[str, str]:
    """The folder that a glob starts from, and the rest."""
    parts = glob.split("/")
    first = next(i for i, part in enumerate(parts) if _WILD.search(part))
    return "/".join(parts[:first]) or ("/" if first else "."), "/".join(parts[first:])


def _expression(glob: str) -> re.Pattern[str]:
    """A regular expression for names that a glob means."""
    pieces = re.split(r"(\*\*/|\*\*|\*|\?|\[[^]]+\])", glob)
    wild = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    parts = [_set(piece) if piece[:1] == "[" and i % 2 else wild.get(piece, re.escape(piece))
             for i, piece in enumerate(pieces)]  # fmt: skip
    return re.compile("".join(parts), re.DOTALL)


def _set(piece: str) -> str:
    """A set of letters; ``!`` turns it round."""
    inside = re.sub(r"([\\[&~|])", r"\\\1", piece[1:-1])
    return f"[^{inside[1:]}]" if inside[0] in "!^" else f"[{inside}]"


def _named(path: str) -> tuple[str, str]:
    """The root and the name of a file: beneath the working directory if it is there, else beneath the top."""
    if is_url(path):
        scheme, _, rest = path.partition("://")
        bucket, _, name = rest.partition("/")
        return f"{scheme}://{bucket}", name
    relative = os.path.relpath(path)
    return (os.getcwd(), relative) if relative.split("/")[0] != ".." else ("/", path[1:])


def _place(path: str) -> str:
    """A path that is equal for equal files, links among the folders above it followed."""
    if is_url(path):
        return path.rstrip("/")
    head, tail = os.path.split(path.rstrip("/") or "/")
    return os.path.join(_real(head or "."), tail)


@lru_cache(maxsize=1024)
def _real(folder: str) -> str:
    return os.path.realpath(folder)
