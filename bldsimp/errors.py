"""The few errors that bldsimp raises: each says what, where and what to do, in one line."""


class BldsimpError(Exception):
    """Base of all errors that bldsimp raises on purpose.

    Examples
    --------
    >>> import bldsimp
    >>> try:
    ...     bldsimp.simplify("no mesh")
    ... except bldsimp.BldsimpError as error:
    ...     print(error)
    the mesh is of type str: give a trimesh.Trimesh or (points, faces)
    """


class InputError(BldsimpError):
    """A file or array that cannot be read as a mesh: missing, corrupt, non-finite, index out of range.

    Examples
    --------
    >>> import bldsimp
    >>> bldsimp.simplify(([[0, 0, 0]], [[0, 1, 2]]))
    Traceback (most recent call last):
    bldsimp.errors.InputError: faces [0] use points that are not there: there are 1
    """


class OutputError(BldsimpError):
    """A result that cannot be written: no permission, disk full.

    Examples
    --------
    >>> import bldsimp
    >>> raise bldsimp.OutputError("out.glb: the disk is full: free some space")
    Traceback (most recent call last):
    bldsimp.errors.OutputError: out.glb: the disk is full: free some space
    """


class UsageError(BldsimpError):
    """An option or path that is wrong before anything is read.

    Examples
    --------
    >>> import bldsimp
    >>> bldsimp.Options(normals="round")
    Traceback (most recent call last):
    bldsimp.errors.UsageError: normals 'round': choose one of auto, flat, smooth, none
    """


class TopologyError(BldsimpError):
    """Segments that cannot form a triangulation; `segments` has their rows in the input.

    Examples
    --------
    >>> import bldsimp
    >>> try:
    ...     bldsimp.triangulate([[0, 0], [2, 2], [0, 2], [2, 0]], [[0, 1], [2, 3]])
    ... except bldsimp.TopologyError as error:
    ...     print(error.segments)
    (0, 1)
    """

    def __init__(self, message: str, segments: tuple[int, int] | None = None) -> None:
        super().__init__(message)
        self.segments = segments


class InternalError(BldsimpError):
    """A broken invariant: a bug in bldsimp, not in the input; the message names the stage."""
