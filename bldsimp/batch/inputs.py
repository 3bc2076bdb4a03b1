"""Find the files to simplify, and plan where their results go."""

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
from .row import FAILED, FileRow
from .storage import FileEntry, Storage, is_url, join_path, make_absolute, open_storage
from .task import Task

_WILDCARD = re.compile(r"[*?\[]")
_FIELDS = ("stem", "ext", "from")

_resolve_folder = lru_cache(maxsize=1024)(os.path.realpath)


class FoundFile(NamedTuple):
    """An input: the path or URL of a folder, and the file below it."""

    root: str
    entry: FileEntry


@dataclass(frozen=True)
class OutputLayout:
    """Where results go.

    Attributes
    ----------
    root : str
        Folder or URL that mirrors the inputs' folders.
    name : str
        Template for the name of each result, with ``{stem}`` and ``{from}`` of the input and ``{ext}`` of the result.
    to, from_ : str or None
        Formats of all results and inputs; None to use the suffix.
    """

    root: str
    name: str
    to: str | None = None
    from_: str | None = None

    def __post_init__(self) -> None:
        """Refuse a template or format that cannot be used."""
        try:
            name = self.name.format_map(dict.fromkeys(_FIELDS, "x"))
        except (KeyError, IndexError, ValueError):
            name = ""
        if not name or "/" in name or name in (".", ".."):
            raise UsageError(f"--name {self.name!r}: give a file name; it may contain {{stem}}, {{ext}} and {{from}}")
        if self.to is not None and self.to not in SUFFIXES:
            raise UsageError(f"--to: cannot write format '{self.to}': use one of {', '.join(SUFFIXES)}")

    def make_task(self, found: FoundFile) -> Task:
        """Make the task for an input; its format may still be one that cannot be written."""
        path = PurePosixPath(found.entry.name)
        from_ = self.from_ or path.suffix[1:].lower()
        to = self.to or from_
        name = self.name.format_map({"stem": path.stem, "ext": to, "from": from_})
        output = str(path.with_name(name))
        return Task(found.root, found.entry.name, self.root, output, from_, to, found.entry.size, found.entry.mtime)


@dataclass
class Plan:
    """Tasks, and rows of the inputs that are refused."""

    tasks: list[Task] = field(default_factory=list)
    refused: list[FileRow] = field(default_factory=list)


def find_inputs(sources: Iterable[str], out: str) -> Iterator[FoundFile]:
    """Find the files that folders, globs and names stand for.

    Parameters
    ----------
    sources : iterable of str
        A folder stands for all files below it in a format that bldsimp writes. A glob, where ``**`` stands for any
        folders, stands for all files that match. Anything else is a file; its name is the path from the working
        directory, or the absolute path where that leads out of it.
    out : str
        Folder of results: files in it are not inputs, unless you name them.

    Raises
    ------
    UsageError
        Where a folder is that of the results, or no file is found.
    """
    for given in sources:
        source = make_absolute(given)
        storage = open_storage(source)
        if storage.is_folder(source):
            if _resolve(source) == _resolve(out):
                raise UsageError(f"{source}: is also the folder of the results: choose another one for them")
            yield from _walk(storage, source, "**/*", SUFFIXES, out)
        elif _WILDCARD.search(source) and storage.look_up(source, source).refusal:
            yield from _walk(storage, *_split_glob(source), (), out)
        else:
            root, name = _split_path(source)
            yield FoundFile(root, storage.look_up(source, name))


def plan_tasks(inputs: Iterable[FoundFile], layout: OutputLayout) -> Plan:
    """Pair inputs with outputs.

    Raises
    ------
    UsageError
        Where two inputs would write the same file, an input would be overwritten, or no format to write is known.
    """
    plan = Plan()
    sources: dict[str, str] = {}
    seen: set[str] = set()
    for found in inputs:
        if found.entry.refusal:
            plan.refused.append(FileRow(found.entry.name or ".", "", FAILED, "refused", found.entry.refusal))
            continue
        task = layout.make_task(found)
        if task.to not in SUFFIXES:
            how = f"cannot write format '{task.to}': give --to" if task.to else "has no suffix: give --from"
            raise UsageError(f"{task.source}: {how} with one of {', '.join(SUFFIXES)}")
        source, target = _resolve(task.source), _resolve(task.target)
        other = sources.setdefault(target, source)
        if other != source:
            raise UsageError(
                f"{other} and {source} would both write {target}: give a --name that tells them apart,"
                " such as '{stem}_{from}.{ext}', or simplify them one by one"
            )
        if source not in seen:
            seen.add(source)
            plan.tasks.append(task)
    for target in seen & sources.keys():
        raise UsageError(f"{target}: is an input and would be overwritten: choose another folder or --name")
    return plan


def parse_names(data: bytes) -> list[str]:
    """Parse a list of names: one a line, or with a zero byte after each, as ``find -print0`` writes them."""
    return [os.fsdecode(name) for name in data.split(b"\0" if b"\0" in data else b"\n") if name]


def _walk(storage: Storage, root: str, pattern: str, suffixes: tuple[str, ...], out: str) -> Iterator[FoundFile]:
    """Find the files below a root that match a pattern, and have one of the suffixes if any are given.

    Raises
    ------
    UsageError
        Where there are none.
    """
    matches = _compile_glob(pattern).fullmatch

    def is_wanted(name: str) -> bool:
        return bool(matches(name)) and (not suffixes or PurePosixPath(name).suffix[1:].lower() in suffixes)

    entry = None
    for entry in storage.find(root, is_wanted, out):
        yield FoundFile(root, entry)
    if entry is None:
        raise UsageError(f"{join_path(root, pattern)}: there is no such file")


def _split_glob(glob: str) -> tuple[str, str]:
    """Split a glob into the folder that it starts from and the rest."""
    parts = glob.split("/")
    first = next(i for i, part in enumerate(parts) if _WILDCARD.search(part))
    return "/".join(parts[:first]) or ("/" if first else "."), "/".join(parts[first:])


def _compile_glob(glob: str) -> re.Pattern[str]:
    """Compile a glob to a regular expression."""
    pieces = re.split(r"(\*\*/|\*\*|\*|\?|\[[^]]+\])", glob)
    wild = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    parts = [_translate_set(piece) if piece[:1] == "[" and i % 2 else wild.get(piece, re.escape(piece))
             for i, piece in enumerate(pieces)]  # fmt: skip
    return re.compile("".join(parts), re.DOTALL)


def _translate_set(piece: str) -> str:
    """Translate a set of letters; a leading ``!`` negates it."""
    inside = re.sub(r"([\\[&~|])", r"\\\1", piece[1:-1])
    return f"[^{inside[1:]}]" if inside[0] in "!^" else f"[{inside}]"


def _split_path(path: str) -> tuple[str, str]:
    """Split a path into root and name: below the working directory where the file is there, else below the top."""
    if is_url(path):
        scheme, _, rest = path.partition("://")
        bucket, _, name = rest.partition("/")
        return f"{scheme}://{bucket}", name
    relative = os.path.relpath(path)
    return (os.getcwd(), relative) if relative.split("/")[0] != ".." else ("/", path[1:])


def _resolve(path: str) -> str:
    """Resolve the links among the folders above a file, so that equal files have equal paths."""
    if is_url(path):
        return path.rstrip("/")
    head, tail = os.path.split(path.rstrip("/") or "/")
    return os.path.join(_resolve_folder(head or "."), tail)
