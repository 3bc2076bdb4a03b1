"""Files to scenes and back: the only package that knows formats."""

from .read import SUFFIXES, read
from .write import WRITABLE, Written, write

__all__ = ["SUFFIXES", "WRITABLE", "Written", "read", "write"]
