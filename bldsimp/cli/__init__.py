"""The command line: the only package that prints and that knows exit codes."""

from __future__ import annotations

import os
import sys
from typing import TextIO

from .signals import INTERRUPTED, handle_signals

DONE, FAILED, WRONG_USAGE = 0, 1, 2


def main(arguments: list[str] | None = None) -> int:
    """Run the program.

    Parameters
    ----------
    arguments : list of str, optional
        Those of the process by default.

    Returns
    -------
    int
        0 done, 1 a file unreadable or not written, 2 wrong usage, 130 interrupted.
    """
    with handle_signals():
        try:
            return _run(arguments)
        except KeyboardInterrupt:
            return _fail("interrupted", INTERRUPTED)
        except MemoryError:
            return _fail("out of memory", FAILED)
        except BrokenPipeError:
            # The reader of the output is gone; that is no error to report.
            _mute(sys.stdout, sys.stderr)
            return FAILED
        except OSError as error:
            _mute(sys.stdout)
            return _fail(f"{error.filename or 'standard output or error'}: {error.strerror or error}", FAILED)


def _run(arguments: list[str] | None) -> int:
    """Run a command. Its modules, which take most of a short run, are loaded here and not before."""
    import logging

    import click

    from ..errors import BldsimpError, InternalError, UsageError
    from .commands import bldsimp

    # Our own message covers what trimesh logs of a file that it cannot read.
    logging.getLogger("trimesh").addHandler(logging.NullHandler())
    # A name may contain letters that the terminal's encoding does not have.
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        bldsimp.main(arguments, prog_name="bldsimp", standalone_mode=False)
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        return DONE
    except InternalError:
        raise
    except UsageError as error:
        return _fail(str(error), WRONG_USAGE)
    except BldsimpError as error:
        return _fail(str(error), FAILED)
    except click.UsageError as error:
        where = f" (try '{error.ctx.command_path} --help')" if error.ctx else ""
        return _fail(error.format_message().rstrip(".") + where, WRONG_USAGE)
    except click.Abort:
        return _fail("interrupted", INTERRUPTED)


def _fail(message: str, code: int) -> int:
    """Print one line on stderr, if it can be written, and return the exit code."""
    from ..display import sanitize_line

    try:
        if sys.stderr is not None:
            print("bldsimp: error: " + sanitize_line(message), file=sys.stderr, flush=True)
    except OSError:
        _mute(sys.stderr)
    return code


def _mute(*streams: TextIO | None) -> None:
    """Discard what is still buffered: at its end the interpreter would try, and fail, to write it."""
    for stream in streams:
        if stream is not None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
