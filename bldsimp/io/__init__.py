"""Files to scenes and back: the only package that knows formats."""

from .read import SUFFIXES, read

__all__ = ["SUFFIXES", "read"]
