"""A process of its own that makes one file light after the other, so that a bad one can cost no more than it.

The process is started afresh rather than forked: nothing of the program that asks is in it, and it may be asked from a
process that may have no children by `multiprocessing` (a Dask worker).
"""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import logging
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import BldsimpError, InputError, InternalError, OutputError, UsageError
from ..report import one_line
from .row import DONE, Row, failure
from .storage import digest, storage_of
from .task import Order, Task

START_SECONDS = 300.0
"""A worker that has not loaded its modules by then never will."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that keep numerical libraries from sharing cores out that other workers have."""

LEAVE_SECONDS = 10.0
"""A worker that nobody hears from any more is ending, and tells how; one that takes longer is killed."""

OUT_OF_MEMORY = ("MemoryError", "bad_alloc")
"""What a process says last that could not even tell of it in a row."""

HEAD_BYTES = 4096

_FULL = (errno.ENOSPC, errno.EDQUOT)
_PROGRAM = "import sys; sys.path[:] = {!r}; from bldsimp.batch.worker import serve; serve({})"


class Worker:
    """The process, as who asks sees it: started when there is something to do, and again where it died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, order: Order, timeout: float | None, stopping: Callable[[], bool]) -> Iterator[tuple[Task, Row]]:
        """Have an order done.

        Parameters
        ----------
        order : Order
        timeout : float or None
            Seconds for each file.
        stopping : callable
            Whether no other file is to be begun.

        Yields
        ------
        task : Task
        row : Row
            In the order of the tasks, each as it ends. One that takes too long, or kills the process, fails.

        Raises
        ------
        BldsimpError
            Where no process can be started.
        """
        left = order.tasks
        while left and not stopping():
            if self._process is None:
                self._start()
            ended = 0
            for ended, row in enumerate(self._rows(dataclasses.replace(order, tasks=left), timeout, stopping), 1):
                yield left[ended - 1], row
            left = left[ended:]

    def kill(self) -> None:
        """End the process at once, and wait until it has; any thread may ask for it."""
        process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def close(self) -> None:
        """Let the process end, as it does when nobody asks any more."""
        if self._process is not None:
            self._connection.close()
            self._process.wait()
            self._said.close()
            self._process = None

    def _start(self) -> None:
        here, there = socket.socketpair()
        # What a crash in native code says last ends up here.
        self._said = tempfile.TemporaryFile()  # noqa: SIM115
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM.format(sys.path, there.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._said,
                pass_fds=[there.fileno()],
                env=os.environ | dict.fromkeys(ONE_THREAD, "1"),
                # Ctrl-C in a terminal is for the program that asks.
                start_new_session=True,
            )
        self._connection = Connection(here.detach())
        try:
            started = self._connection.poll(START_SECONDS) and self._connection.recv()
        except (EOFError, OSError):
            started = False
        if not started:
            raise BldsimpError(f"a worker could not start: its process {self._ended()}")

    def _rows(self, order: Order, timeout: float | None, stopping: Callable[[], bool]) -> Iterator[Row]:
        """Rows as they come from the process; none comes after that of a task that cost it."""
        task = order.tasks[0]
        try:
            self._connection.send(order)
            for task in order.tasks:
                if not self._connection.poll(timeout):
                    self.kill()
                    self._ended()
                    yield failure(task, "timeout", f"took longer than {timeout:g} s: give --timeout more")
                    return
                yield self._connection.recv()
                if stopping():
                    self._connection.send(None)
        except (EOFError, OSError):
            ended = self._ended()
            kind = "memory" if any(word in ended for word in OUT_OF_MEMORY) else "crash"
            if not stopping():
                yield failure(task, kind, f"its process {ended}")

    def _ended(self) -> str:
        """How the process ended, and what it said last; ended here, where it does not by itself."""
        assert self._process is not None
        silent = False
        try:
            code = self._process.wait(LEAVE_SECONDS)
        except subprocess.TimeoutExpired:
            self.kill()
            silent, code = True, self._process.wait()
        self._said.seek(0)
        said = one_line(self._said.read().decode("utf-8", "replace").strip().rpartition("\n")[2])
        self.close()
        if silent:
            how = "did not answer"
        elif code >= 0:
            how = f"ended with code {code}"
        elif code == -signal.SIGKILL:
            how = "was killed (SIGKILL): out of memory?"
        else:
            how = f"crashed ({signal.Signals(-code).name})"
        return f"{how}: {said}" if said else how


def serve(descriptor: int) -> None:
    """What the process does: take orders until nobody gives any."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from .. import (
        _core,  # loaded before the first file's time runs
        job,  # noqa: F401
    )

    # What trimesh says of a file that it cannot read ends in our own one line.
    logging.getLogger("trimesh").addHandler(logging.NullHandler())
    _core.limit_threads(1)
    threading.Thread(target=_leave_with, args=(descriptor,), daemon=True).start()
    connection = Connection(descriptor)
    connection.send(True)
    with contextlib.suppress(EOFError, OSError):
        while (order := connection.recv()) is not None:
            for task in order.tasks:
                connection.send(simplified(task, order))
                if connection.poll():
                    break


def _leave_with(descriptor: int) -> None:
    """End at once when the program that asks is gone, however long a file still takes."""
    poll = select.poll()
    poll.register(descriptor, 0)
    poll.poll()
    os._exit(1)


def simplified(task: Task, order: Order) -> Row:
    """Make one file light; whatever is wrong with it ends in its row."""
    start = time.perf_counter()
    try:
        _limit_memory(order.memory)
        row = _simplified(task, order)
        # What cannot be written down must cost this file alone.
        row.to_line()
    except MemoryError:
        most = f"{order.memory / 1e6:,.0f} MB" if order.memory else "memory"
        row = failure(task, "memory", f"needs more than the {most} that it may use: give --memory more")
    except (InputError, UsageError) as error:
        row = failure(task, "input", str(error))
    except OutputError as error:
        row = failure(task, "full" if _disk_is_full(error) else "output", str(error))
    except OSError as error:
        row = failure(task, "full" if _disk_is_full(error) else "input", f"{error.filename}: {error.strerror}")
    except Exception as error:
        row = failure(task, "internal", f"{type(error).__name__}: {error}")
    row.seconds = round(time.perf_counter() - start, 4)
    return row


def _simplified(task: Task, order: Order) -> Row:
    from ..job import simplify_file

    if order.version != __version__:
        raise InternalError(f"this worker has bldsimp {__version__}, not {order.version}: install the same everywhere")
    inputs, outputs = storage_of(task.source), storage_of(task.target)
    found = inputs.entry(task.source, task.name)
    if found.refusal:
        return failure(task, "refused", found.refusal)
    with inputs.reading(task.source) as source, outputs.writing(task.target) as target:
        with open(source, "rb") as stream:
            _check_head(stream.read(HEAD_BYTES))
            stream.seek(0)
            input_digest = digest(stream)
        result = simplify_file(source, task.from_, target, task.to, order.options, overwrite=order.overwrite)
        beside = [_read_with(source.parent, name) for name in result.scene.beside]
        with open(target, "rb") as stream:
            output_digest, output_bytes = digest(stream), os.fstat(stream.fileno()).st_size
    report = result.report
    before, after = report.before, report.after
    return Row(
        task.name,
        task.output,
        DONE,
        format_before=task.from_,
        format_after=task.to,
        input_bytes=found.size,
        input_mtime_ns=found.mtime,
        input_sha256=input_digest,
        beside=beside,
        output_bytes=output_bytes,
        output_sha256=output_digest,
        points_before=before.points,
        points_after=after.points,
        triangles_before=before.triangles,
        triangles_after=after.triangles,
        tolerance=report.tolerance,
        deviation=report.deviation,
        texels=report.texels,
        attempts=2 if task.again else 1,
        warnings=[*(f"passed on {part.name}: {part.reason}" for part in report.passed_on), *report.warnings],
    )


def _read_with(folder: Path, name: str) -> dict[str, Any]:
    """What a row tells of a file that was read with the input."""
    with open(folder / name, "rb") as stream:
        found = os.fstat(stream.fileno())
        return {"name": name, "bytes": found.st_size, "mtime_ns": found.st_mtime_ns, "sha256": digest(stream)}


def _limit_memory(most: int | None) -> None:
    """Let this process take so many bytes more than it has; only Linux counts what is meant here."""
    if most is None or sys.platform != "linux":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[5])
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    wanted = pages * resource.getpagesize() + most
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard < 0 else min(wanted, hard), hard))


def _check_head(head: bytes) -> None:
    """Refuse what is no mesh in any format before it is read: a sparse file may be larger than the memory."""
    if head and not any(head):
        raise InputError(f"its first {len(head):,} bytes are all zero: no mesh")


def _disk_is_full(error: BaseException | None) -> bool:
    while error is not None:
        if isinstance(error, OSError) and error.errno in _FULL:
            return True
        error = error.__cause__ or error.__context__
    return False
