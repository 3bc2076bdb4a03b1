"""Read files into scenes and write them: the only package that knows formats."""

from .file_scene import FileScene, Written
from .read import SUFFIXES, read
from .write import WRITABLE, write

__all__ = ["SUFFIXES", "WRITABLE", "FileScene", "Written", "read", "write"]
