"""The few errors that bldsimp raises: each says what, where and what to do, in one line."""


class BldsimpError(Exception):
    """Base of all errors that bldsimp raises on purpose."""


class InputError(BldsimpError):
    """A file or array that cannot be read as a mesh: missing, corrupt, non-finite, index out of range."""


class OutputError(BldsimpError):
    """A result that cannot be written: no permission, disk full."""


class UsageError(BldsimpError):
    """An option or path that is wrong before anything is read."""


class TopologyError(BldsimpError):
    """Segments that cannot form a triangulation; carries the INPUT's segment indices in `segments`."""

    def __init__(self, message: str, segments: tuple[int, int] | None = None) -> None:
        super().__init__(message)
        self.segments = segments


class InternalError(BldsimpError):
    """A broken invariant: a bug in bldsimp, not in the input."""
