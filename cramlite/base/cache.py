"""Cache of results in files: a folder that can be deleted at any time, and files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def cache_folder() -> Path:
    """Return the folder of cached files: $CRAMLITE_CACHE, else the platform's cache folder."""
    if "CRAMLITE_CACHE" in os.environ:
        return Path(os.environ["CRAMLITE_CACHE"])
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(base) if base else Path.home() / ".cache") / "cramlite"


def keep_file(path: Path, content: bytes) -> None:
    """Keep content in a file, so that no other process reads half of it; keep nothing where the folder cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(content)
        os.replace(file.name, path)
    except OSError:
        return
