"""Describe the machine in a few lines of Markdown: versions, processor, system.

usage: python benchmarks/machine.py
"""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

PACKAGES = (
    "bldsimp", "numpy", "trimesh", "fast-simplification", "manifold3d", "triangle", "scipy", "libigl"
)  # fmt: skip


def read_processor() -> str:
    """Read the name of the processor, as far as the system knows it."""
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text().splitlines() if listed.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def read_version(package: str) -> str:
    """Read the installed version of a package."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def main() -> None:
    """Print them."""
    print(f"- {read_processor()}, {os.cpu_count()} cores; {platform.system()}; Python {platform.python_version()}")
    print("- " + ", ".join(f"{package} {read_version(package)}" for package in PACKAGES))


if __name__ == "__main__":
    main()
