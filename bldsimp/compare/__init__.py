"""Compare methods on the same buildings: rows, table, chart, and a page in 3D."""
