"""The command line: the only package that prints and that knows exit codes."""

from __future__ import annotations

import logging
import os
import signal
import sys

import click

from ..errors import BldsimpError, InternalError, UsageError
from .commands import bldsimp

DONE, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130


def main(arguments: list[str] | None = None) -> int:
    """Run the program.

    Parameters
    ----------
    arguments : list of str, optional
        Those of the process where left out.

    Returns
    -------
    int
        0 done, 1 a file unreadable or not written, 2 wrong usage, 130 interrupted.
    """
    # What trimesh says of a file that it cannot read ends in our own one line.
    logging.getLogger("trimesh").addHandler(logging.NullHandler())
    try:
        # A termination unwinds like an interruption, so that no half-written file stays behind.
        signal.signal(signal.SIGTERM, _terminate)
        bldsimp.main(arguments, prog_name="bldsimp", standalone_mode=False)
        sys.stdout.flush()
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
    except (click.Abort, KeyboardInterrupt):
        return _fail("interrupted", INTERRUPTED)
    except MemoryError:
        return _fail("out of memory", FAILED)
    except BrokenPipeError:
        # Whoever read the output is gone; the interpreter must not flush into the pipe once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED


def _fail(message: str, code: int) -> int:
    """One line on stderr."""
    click.echo("bldsimp: error: " + " ".join(message.split()), err=True)
    return code


def _terminate(number: int, frame: object) -> None:
    sys.exit(128 + number)
