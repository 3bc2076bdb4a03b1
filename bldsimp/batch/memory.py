"""Estimate how much memory there is, and how much a file needs."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

from ..display import format_bytes
from ..errors import UsageError
from ..options import BATCH_MEMORY_SHARE
from .task import Task

MB = 1_000_000

WORKER_BYTES = 60 * MB
"""Memory of a worker that has loaded its modules."""

LEAST_SHARE = 64 * MB
"""A worker with less memory than this cannot simplify even small files."""

LEAST_NEED = 2
"""Bytes of memory for each byte of any file that can be read: the file itself, and what is made of it."""

LIKELY_NEED = {"glb": 55, "gltf": 55, "ply": 55, "stl": 25, "obj": 30, "off": 25}
"""Bytes of memory for each byte of a file that is flat nowhere, as measured; a flat one takes a third."""


def estimate_memory(task: Task) -> int:
    """Return the bytes that should be enough for a file."""
    return LIKELY_NEED.get(task.from_, max(LIKELY_NEED.values())) * task.size


def measure_free_memory() -> int:
    """Return the bytes that `batch` uses by default: a share of the free memory of this machine or container."""
    free = [_measure_available()]
    for limit in ("memory.max", "memory/memory.limit_in_bytes"):
        # A container without a limit says "max".
        with contextlib.suppress(OSError, ValueError):
            free.append(int(Path("/sys/fs/cgroup", limit).read_text()))
    return int(BATCH_MEMORY_SHARE * min(free))


def _measure_available() -> int:
    """Return the free bytes of this machine; where neither psutil nor Linux knows them, all of its bytes."""
    with contextlib.suppress(ImportError):
        import psutil

        return int(psutil.virtual_memory().available)
    with contextlib.suppress(OSError, TypeError):
        return int(re.search(r"MemAvailable:\s+(\d+)", Path("/proc/meminfo").read_text())[1]) * 1024  # type: ignore[index]
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def choose_jobs(memory: int, cores: int) -> int:
    """Choose as many processes as the memory is enough for, but no more than there are cores."""
    return max(1, min(cores, memory // (WORKER_BYTES + LEAST_SHARE)))


def divide_memory(memory: int, jobs: int) -> tuple[int, int]:
    """Divide memory into the bytes that all files may use together, and the share of each worker.

    Raises
    ------
    UsageError
        Where that is too little.
    """
    for_files = memory - jobs * WORKER_BYTES
    if for_files < jobs * LEAST_SHARE:
        least = format_bytes(jobs * (WORKER_BYTES + LEAST_SHARE))
        given = format_bytes(memory)
        raise UsageError(f"--memory: {given} is too little for {jobs} jobs: give {least} or more, or a smaller -j")
    return for_files, for_files // jobs
