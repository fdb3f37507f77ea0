"""Plugin that reads recordings of real cameras as views. The reader is in ``view_files``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cramlite.plugin import hookimpl

if TYPE_CHECKING:
    from cramlite.model import View

KINDS = (".npz", ".ply", ".pcd")


@hookimpl
def read_view(path: Path) -> View | None:
    """Read a folder with depth.png, an NPZ of arrays, or a PLY or PCD cloud with its camera beside it; else None."""
    if path.suffix.lower() not in KINDS and not (path / "depth.png").is_file():
        return None
    from .view_files import read_view as read

    return read(path)
