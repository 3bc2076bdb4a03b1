"""How much memory there is, and how much a file will need."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

from ..errors import UsageError
from ..options import BATCH_MEMORY_SHARE
from ..report import size_in_words
from .task import Task

MB = 1_000_000

WORKER_BYTES = 60 * MB
"""What a worker holds when its modules are loaded."""

LEAST_SHARE = 64 * MB
"""With less for each worker, not even small files would do."""

LEAST_NEED = 2
"""Bytes of memory for each byte of any file that is read at all: itself, and what is made of it."""

LIKELY_NEED = {"glb": 55, "gltf": 55, "ply": 55, "stl": 25, "obj": 30, "off": 25}
"""Bytes of memory for each byte of a file that is nowhere flat, as measured; a flat one takes a third."""

_UNITS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}


def parse_bytes(text: str) -> int:
    """Read a number of bytes: ``800M``, ``8G``, ``1.5 GB``.

    Raises
    ------
    UsageError
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([KMGT]?)B?\s*", text.upper())
    if found is None:
        raise UsageError(f"'{text}' is no amount of memory: give a number with K, M, G or T, say 8G")
    return int(float(found[1]) * _UNITS[found[2]])


def least_need(task: Task) -> int:
    """Bytes without which a file cannot be made light."""
    return LEAST_NEED * task.size


def likely_need(task: Task) -> int:
    """Bytes that a file should do with."""
    return LIKELY_NEED.get(task.from_, max(LIKELY_NEED.values())) * task.size


def free_memory() -> int:
    """Bytes that `batch` takes by itself: a share of what is free, of this machine or of the container."""
    free = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    with contextlib.suppress(OSError, TypeError):
        free.append(int(re.search(r"MemAvailable:\s+(\d+)", Path("/proc/meminfo").read_text())[1]) * 1024)  # type: ignore[index]
    for limit in ("memory.max", "memory/memory.limit_in_bytes"):
        # A container without a limit says "max".
        with contextlib.suppress(OSError, ValueError):
            free.append(int(Path("/sys/fs/cgroup", limit).read_text()))
    return int(BATCH_MEMORY_SHARE * min(free))


def jobs_for(memory: int, cores: int) -> int:
    """How many processes there is memory for, one for each core at most."""
    return max(1, min(cores, memory // (WORKER_BYTES + LEAST_SHARE)))


def share_of(memory: int, jobs: int) -> tuple[int, int]:
    """Bytes that files may take together, and each worker at any time.

    Raises
    ------
    UsageError
        Where that is too little.
    """
    for_files = memory - jobs * WORKER_BYTES
    if for_files < jobs * LEAST_SHARE:
        least = jobs * (WORKER_BYTES + LEAST_SHARE)
        given, wanted = size_in_words(memory), size_in_words(least)
        raise UsageError(f"--memory: {given} is too little for {jobs} jobs: give {wanted} or more, or fewer -j")
    return for_files, for_files // jobs
