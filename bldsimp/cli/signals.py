"""Ctrl-C and termination: the program leaves at once while nothing is written, and clears up once something is."""

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
def answered() -> Iterator[None]:
    """Leave at once on a signal, until `unwind` says otherwise; what was set before comes back at the end.

    An exception would not do: raised while modules load, it surfaces as whatever their loading makes of it.
    """
    before = {number: signal.getsignal(number) for number in _CODES}
    try:
        _answer(_leave)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def unwind() -> None:
    """From now on signals raise, so that no half-written file stays behind."""
    _answer(_raise)


def _answer(handler: _Handler) -> None:
    for number in _CODES:
        # What whoever started the program chose to ignore stays ignored.
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _leave(number: int, frame: FrameType | None) -> None:
    try:
        if number == signal.SIGINT:
            os.write(2, b"bldsimp: error: interrupted\n")
    finally:
        os._exit(_CODES[signal.Signals(number)])


def _raise(number: int, frame: FrameType | None) -> None:
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    sys.exit(TERMINATED)


class FirstInterrupt:
    """Answers the first Ctrl-C in its own way, and raises on the next.

    Attributes
    ----------
    came : bool
        Whether there was one.
    """

    def __init__(self, answer: Callable[[], None]) -> None:
        self.came = False
        self._answer = answer

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if self.came:
            raise KeyboardInterrupt
        self.came = True
        os.write(2, b"\nbldsimp: finishing what is running; Ctrl-C again stops now\n")
        self._answer()


def first_interrupt(answer: Callable[[], None]) -> FirstInterrupt:
    """Answer the first Ctrl-C from now on."""
    first = FirstInterrupt(answer)
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, first)
    return first
