"""A separate process that simplifies one file after the other, so that a bad file does not stop the others.

The process is started afresh rather than forked: it shares no state with the program that leads it, which may be a
process that `multiprocessing` allows no children (a Dask worker).
"""

from __future__ import annotations

import dataclasses
import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection

from ..display import sanitize_line
from ..errors import BldsimpError
from .row import FileRow, make_failure
from .task import Task, WorkOrder

START_SECONDS = 300.0
"""A worker that has not loaded its modules after this time has failed."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that keep numerical libraries from using the cores of other workers."""

LEAVE_SECONDS = 10.0
"""A worker that has closed its connection is ending; one that takes longer than this is killed."""

OUT_OF_MEMORY = ("MemoryError", "bad_alloc")
"""Last words of a process that ran out of memory before it could report that in a row."""

_PROGRAM = "import sys; sys.path[:] = {!r}; from bldsimp.batch.process import serve; serve({})"


class Worker:
    """The process as its leader sees it: started when there is work, and again after it died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def run(
        self, order: WorkOrder, timeout: float | None, is_stopping: Callable[[], bool]
    ) -> Iterator[tuple[Task, FileRow]]:
        """Run the tasks of an order.

        Parameters
        ----------
        order : WorkOrder
        timeout : float or None
            Seconds for each file.
        is_stopping : callable
            Tells whether to begin no other file.

        Yields
        ------
        task : Task
        row : FileRow
            In the order of the tasks, each as it ends. A file that takes too long, or kills the process, fails.

        Raises
        ------
        BldsimpError
            Where the process cannot start.
        """
        remaining = order.tasks
        while remaining and not is_stopping():
            if self._process is None:
                self._start()
            order, ended = dataclasses.replace(order, tasks=remaining), 0
            for ended, row in enumerate(self._receive_rows(order, timeout, is_stopping), 1):
                yield remaining[ended - 1], row
            remaining = remaining[ended:]

    def kill(self) -> None:
        """End the process at once, and wait for that; any thread may call this."""
        process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def close(self) -> None:
        """Let the process end, as it does when its connection closes."""
        if self._process is not None:
            self._connection.close()
            self._process.wait()
            self._stderr.close()
            self._process = None

    def _start(self) -> None:
        here, there = socket.socketpair()
        # Native code writes its last words here when it crashes.
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115  # `close` closes it
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM.format(sys.path, there.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._stderr,
                pass_fds=[there.fileno()],
                env=os.environ | dict.fromkeys(ONE_THREAD, "1"),
                # Ctrl-C in a terminal is for the leader.
                start_new_session=True,
            )
        self._connection = Connection(here.detach())
        try:
            started = self._connection.poll(START_SECONDS) and self._connection.recv()
        except (EOFError, OSError):
            started = False
        if not started:
            raise BldsimpError(f"a worker could not start: its process {self._describe_end()}")

    def _receive_rows(
        self, order: WorkOrder, timeout: float | None, is_stopping: Callable[[], bool]
    ) -> Iterator[FileRow]:
        """Yield rows as the process sends them; the last one is that of the task that ended the process, if one did."""
        task = order.tasks[0]
        try:
            self._connection.send(order)
            for task in order.tasks:
                if not self._connection.poll(timeout):
                    self.kill()
                    self._describe_end()
                    yield make_failure(task, "timeout", f"took longer than {timeout:g} s: give a larger --timeout")
                    return
                yield self._connection.recv()
                if is_stopping():
                    self._connection.send(None)
        except (EOFError, OSError):
            ended = self._describe_end()
            kind = "memory" if any(word in ended for word in OUT_OF_MEMORY) else "crash"
            if not is_stopping():
                yield make_failure(task, kind, f"its process {ended}")

    def _describe_end(self) -> str:
        """Describe how the process ended, with its last words; kill it where it does not end by itself."""
        assert self._process is not None
        code = None
        try:
            code = self._process.wait(LEAVE_SECONDS)
        except subprocess.TimeoutExpired:
            self.kill()
        self._stderr.seek(0)
        said = sanitize_line(self._stderr.read().decode("utf-8", "replace").strip().rpartition("\n")[2])
        self.close()
        if code is None:
            how = "did not answer"
        elif code >= 0:
            how = f"ended with code {code}"
        elif code == -signal.SIGKILL:
            how = "was killed (SIGKILL): out of memory?"
        else:
            how = f"crashed ({signal.Signals(-code).name})"
        return f"{how}: {said}" if said else how
