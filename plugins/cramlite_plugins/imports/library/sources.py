"""Files of a folder from which object models are made: MJCF files, and meshes that are no part of another model."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from cramlite.model import Value

from ...shapes.files import KINDS
from ..scenes.source import root_tag

FILE = re.compile(r"\bfile\s*=\s*[\"']([^\"']+)[\"']")
COLLIDES = re.compile(r"(^|[_.-])(col|coll|collision|hull|convex)([_.-]|$|\d)", re.IGNORECASE)
"""Names of meshes that are collision shapes of others."""
GENERAL = frozenset({"textured", "texture", "mesh", "model", "visual", "object", "base", "nontextured", "textured_simple"})
"""Names of files that do not name the kind; their folder does."""


class Sources(Value):
    """Files that make an object model each, sorted by the model's name; and the number of files that are
    parts of them."""

    files: tuple[tuple[str, Path], ...]
    parts: int


def sources(folder: Path) -> Sources:
    """Find the files, in a folder and all folders below, that make an object model each.

    An MJCF file's model includes the meshes beside it, and the folders below that it names files of; so no file there
    makes a model of its own.
    """
    every = sorted(p for p in folder.rglob("*") if p.is_file())
    scenes = [p for p in every if p.suffix.lower() in (".xml", ".mjcf") and root_tag(p) == "mujoco"]
    taken = {below for p in scenes for below in _folders(p)}
    roots = [p for p in scenes if not any(t in p.parents for t in taken - set(_folders(p)))]
    meshes = [p for p in every if p.suffix[1:].lower() in KINDS]
    owned = {p.parent for p in scenes} | taken
    alone = [m for m in meshes if not any(o == m.parent or o in m.parents for o in owned) and not COLLIDES.search(m.stem)]
    found = [(_name(p), p) for p in (*roots, *_once(alone))]
    return Sources(tuple(sorted(found, key=lambda f: (f[0], str(f[1])))), len(scenes) + len(meshes) - len(found))


def _folders(scene: Path) -> list[Path]:
    """Return the top-level folders beside a scene file that contain the files which the scene names."""
    try:
        named = FILE.findall(scene.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return []
    return [scene.parent / Path(n).parts[0] for n in named if len(Path(n).parts) > 1 and Path(n).parts[0] not in ("..", "/")]


def _once(meshes: Iterable[Path]) -> list[Path]:
    """Keep one file of each mesh that exists in several formats, preferably in a format that carries textures."""
    order = {k: i for i, k in enumerate(("glb", "obj", "ply", "off", "stl"))}
    best: dict[Path, Path] = {}
    for mesh in meshes:
        key = mesh.with_suffix("")
        if key not in best or order[mesh.suffix[1:].lower()] < order[best[key].suffix[1:].lower()]:
            best[key] = mesh
    return list(best.values())


def _name(path: Path) -> str:
    stem = path.parent.name if path.stem.lower() in GENERAL and path.parent.name else path.stem
    plain = re.sub(r"\W", "_", stem, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z]", plain) else f"kind_{plain}"
