"""glTF 2.0: documents read, patched and built."""
