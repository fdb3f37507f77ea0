"""Arrays that are made from a known model once, and kept in the user's cache by a hash of the model's file."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import MeshFile
from cramlite.plugin import UserError, cache_folder, keep_file, read_arrays

from ...shapes.skins import skin_of

VERSION = 3
"""Version of the way arrays are made; another version makes those of every model anew."""
WHOLE = ".glb"
"""Suffix of mesh files that hold their textures."""
MOST_BYTES = 20_000_000
"""Largest size of a file of arrays [bytes]: a grid of 100 cells a side takes 4 MB."""
Arrays = Mapping[str, Any]
"""Name -> numpy array."""


def file_of(mesh: MeshFile | None) -> Path | None:
    """Return where arrays of a mesh are kept; None for no mesh."""
    if mesh is None or not Path(mesh.path).is_file():
        return None
    whole = hashlib.sha256(f"{VERSION}|{mesh.scale}|{mesh.up}|{mesh.joints}|{mesh.values}".encode())
    for part in _parts(mesh):
        whole.update(part)
    return cache_folder() / "kinds" / f"{whole.hexdigest()}.npz"


def kept(file: Path | None) -> Arrays | None:
    """Return the arrays of a file; None where there is none that can be read."""
    try:
        return read_arrays(file, MOST_BYTES) if file is not None and file.is_file() else None
    except UserError:
        return None


def keep(file: Path | None, arrays: Arrays) -> None:
    """Keep arrays in a file, if there is one."""
    if file is not None:
        np.savez(content := io.BytesIO(), **arrays)
        keep_file(file, content.getvalue())


def _parts(mesh: MeshFile) -> list[bytes]:
    """Content of a mesh file that holds its texture; else of the surface and the texture as they were read."""
    path = Path(mesh.path)
    if path.suffix.lower() == WHOLE:
        return [path.read_bytes()]
    skin = skin_of(mesh)
    arrays = (skin.corners.astype(np.float32), skin.places.astype(np.float32), skin.image) if skin else ()
    return [np.ascontiguousarray(a).tobytes() for a in arrays]
