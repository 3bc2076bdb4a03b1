"""Side-by-side views of meshes before and after; needs the extra ``pictures``."""
