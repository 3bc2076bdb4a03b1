"""Inside of a worker's process: simplify each file of an order, and send its row."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import select
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from .. import __version__, _core
from ..errors import InputError, InternalError, OutputError, UsageError
from ..job import simplify_file
from .row import DONE, FileRow, make_failure, make_row
from .storage import hash_stream, open_storage
from .task import Task, WorkOrder

HEAD_BYTES = 4096

_FULL = (errno.ENOSPC, errno.EDQUOT)


def serve(descriptor: int) -> None:
    """Take orders until the connection closes: what the process runs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Our own message covers what trimesh logs of a file that it cannot read.
    logging.getLogger("trimesh").addHandler(logging.NullHandler())
    _core.limit_threads(1)
    threading.Thread(target=_exit_with_leader, args=(descriptor,), daemon=True).start()
    connection = Connection(descriptor)
    connection.send(True)
    with contextlib.suppress(EOFError, OSError):
        while (order := connection.recv()) is not None:
            for task in order.tasks:
                connection.send(simplify_task(task, order))
                if connection.poll():
                    break


def _exit_with_leader(descriptor: int) -> None:
    """End at once when the leader is gone, however long a file still takes."""
    poll = select.poll()
    poll.register(descriptor, 0)
    poll.poll()
    os._exit(1)


def simplify_task(task: Task, order: WorkOrder) -> FileRow:
    """Simplify one file; its row reports any error."""
    start = time.perf_counter()
    try:
        _limit_memory(order.memory)
        row = _simplify(task, order)
        # A row that cannot be encoded must not stop other files.
        row.to_line()
    except MemoryError:
        most = f" than {order.memory / 1e6:,.0f} MB of" if order.memory else ""
        row = make_failure(task, "memory", f"needs more{most} memory: give a larger --memory")
    except (InputError, UsageError) as error:
        row = make_failure(task, "input", str(error))
    except OutputError as error:
        row = make_failure(task, "full" if _disk_is_full(error) else "output", str(error))
    except OSError as error:
        row = make_failure(task, "full" if _disk_is_full(error) else "input", f"{error.filename}: {error.strerror}")
    except Exception as error:
        row = make_failure(task, "internal", f"{type(error).__name__}: {error}")
    row.seconds = round(time.perf_counter() - start, 4)
    return row


def _simplify(task: Task, order: WorkOrder) -> FileRow:
    if order.version != __version__:
        raise InternalError(
            f"this worker has bldsimp {__version__}, not {order.version}: install the same version everywhere"
        )
    inputs, outputs = open_storage(task.source), open_storage(task.target)
    found = inputs.look_up(task.source, task.name)
    if found.refusal:
        return make_failure(task, "refused", found.refusal)
    with inputs.fetch(task.source) as source, outputs.store(task.target) as target:
        with open(source, "rb") as stream:
            _check_head(stream.read(HEAD_BYTES))
            stream.seek(0)
            input_sha256 = hash_stream(stream)
        result = simplify_file(source, task.from_, target, task.to, order.options, overwrite=order.overwrite)
        beside = [_describe_file(source.parent, name) for name in result.scene.beside]
        with open(target, "rb") as stream:
            output_sha256, output_bytes = hash_stream(stream), os.fstat(stream.fileno()).st_size
    report, before, after = result.report, result.report.before, result.report.after
    return make_row(
        task,
        DONE,
        input_bytes=found.size,
        input_mtime_ns=found.mtime,
        input_sha256=input_sha256,
        beside=beside,
        output_bytes=output_bytes,
        output_sha256=output_sha256,
        points_before=before.points,
        points_after=after.points,
        triangles_before=before.triangles,
        triangles_after=after.triangles,
        tolerance=report.tolerance,
        deviation=report.deviation,
        texels=report.texels,
        warnings=[*(f"unchanged {part.name}: {part.reason}" for part in report.unchanged_parts), *report.warnings],
    )


def _describe_file(folder: Path, name: str) -> dict[str, Any]:
    """Describe a file that was read with the input, for its row."""
    with open(folder / name, "rb") as stream:
        found = os.fstat(stream.fileno())
        return {"name": name, "bytes": found.st_size, "mtime_ns": found.st_mtime_ns, "sha256": hash_stream(stream)}


def _limit_memory(most: int | None) -> None:
    """Let this process use so many bytes more than it has; only Linux counts those that are meant here."""
    if most is None or sys.platform != "linux":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[5])
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    wanted = pages * resource.getpagesize() + most
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard < 0 else min(wanted, hard), hard))


def _check_head(head: bytes) -> None:
    """Refuse a file of zeros before it is read: a sparse file may be larger than the memory."""
    if head and not any(head):
        raise InputError(f"its first {len(head):,} bytes are all zero: not a mesh")


def _disk_is_full(error: BaseException | None) -> bool:
    """Tell whether a full disk is behind an error."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _FULL:
            return True
        error = error.__cause__ or error.__context__
    return False
