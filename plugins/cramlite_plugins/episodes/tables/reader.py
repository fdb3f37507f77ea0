"""Plugin that reads a recording of poses by its mapping file: motion capture, game engines, tables of one's own."""

from __future__ import annotations

from pathlib import Path

from cramlite.model import Episode
from cramlite.plugin import hookimpl

NAME = "recording.yaml"
"""Name of the mapping file in a folder."""


@hookimpl
def read_episode(path: Path) -> Episode | None:
    """Read a recording, given its mapping file or the folder of that file; None if there is no mapping file."""
    file = path / NAME if path.is_dir() else path
    if file.suffix.lower() not in (".yaml", ".yml") or not file.is_file():
        return None
    from .assembly import read_recording

    return read_recording(file)
