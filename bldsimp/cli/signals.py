"""Ctrl-C and termination: the program ends at once until it writes something, and then cleans up first."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

INTERRUPTED, TERMINATED = 130, 143
_CODES = {signal.SIGINT: INTERRUPTED, signal.SIGTERM: TERMINATED}
_Handler = Callable[[int, "FrameType | None"], None]


@contextmanager
def handle_signals() -> Iterator[None]:
    """End at once on a signal, until `raise_on_signals` changes that; restore the previous handlers at the end.

    An exception would not do: raised while modules load, it becomes whatever error their loading makes of it.
    """
    before = {number: signal.getsignal(number) for number in _CODES}
    try:
        _set_handlers(_exit, *_CODES)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def raise_on_signals() -> None:
    """Raise an exception on a signal from now on, so that no half-written file remains."""
    _set_handlers(_raise, *_CODES)


class GracefulInterrupt:
    """Call a function on the first Ctrl-C from now on, and raise on the next.

    Attributes
    ----------
    came : bool
        Whether there was one.
    """

    def __init__(self, stop: Callable[[], None]) -> None:
        self.came = False
        self._stop = stop
        _set_handlers(self, signal.SIGINT)

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle Ctrl-C."""
        if self.came:
            raise KeyboardInterrupt
        self.came = True
        os.write(2, b"\nbldsimp: finishing the files that are running; press Ctrl-C again to stop now\n")
        self._stop()


def _set_handlers(handler: _Handler, *numbers: signal.Signals) -> None:
    """Handle signals, but not those that whoever started the program chose to ignore."""
    for number in numbers:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _exit(number: int, frame: FrameType | None) -> None:
    try:
        if number == signal.SIGINT:
            os.write(2, b"bldsimp: error: interrupted\n")
    finally:
        os._exit(_CODES[signal.Signals(number)])


def _raise(number: int, frame: FrameType | None) -> None:
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    sys.exit(TERMINATED)
