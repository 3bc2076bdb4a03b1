"""Read files into scenes and write them: the only package that knows formats."""

from .file_scene import FileScene
from .read import SUFFIXES, read
from .write import WRITABLE, Written, write

__all__ = ["SUFFIXES", "WRITABLE", "FileScene", "Written", "read", "write"]
