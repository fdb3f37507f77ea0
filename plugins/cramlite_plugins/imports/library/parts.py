"""Things of which a model with joints consists, as the reader of scenes makes them: cabinet, drawers, doors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import ImportedScene, KindJoint, MeshFile, Pose, Thing

from ..scenes.reader import read_scene
from . import look

if TYPE_CHECKING:
    from ..scenes.source import Source


def parts_of(path: Path, source: Source, frame: Pose, moving: Sequence[KindJoint]) -> tuple[tuple[Thing, ...], tuple[KindJoint, ...]]:
    """Return the parts of a model in its frame, and its joints, each with the name of its part; no parts if the model is not fixed.

    Args:
        path: of the model's file, from which ``source`` was read.
        frame: of the model, in the file's world.
    """
    scene = read_scene(path, {}, "", {}) if moving else None
    if scene is None or scene.things[0].movable or any(not t.furniture for t in scene.things):
        return (), tuple(moving)
    to_model = frame.inverse()
    things = tuple(replace(t, pose=to_model * t.pose, notes=()) for t in scene.things)
    owners = {source.model.joint(j).name or f"joint {j}": _owner(source.model, j, scene) for j in range(source.model.njnt)}
    return things, tuple(replace(j, part=owners[j.name]) for j in moving)


def _owner(model: Any, joint: int, scene: ImportedScene) -> str:
    """Name of the jointed thing that a joint of the file moves; "" for none."""
    body = model.body(int(model.jnt_bodyid[joint])).name or f"body_{int(model.jnt_bodyid[joint])}"
    return next((t.name for t in scene.things if t.joint is not None and body in (t.name, *scene.names[t.name])), "")


def write_looks(thing: Thing, mesh: Any, folder: Path) -> Thing:
    """Write the triangles of each part of a model as a GLB file, and return the model whose parts name their files.

    Args:
        mesh: trimesh.Trimesh of the whole model, in its frame [m].
        folder: of the library.
    """
    return replace(thing, parts=tuple(_looked(part, thing, mesh, folder) for part in thing.parts))


def _looked(part: Thing, whole: Thing, mesh: Any, folder: Path) -> Thing:
    faces = np.flatnonzero(_owners(whole, len(mesh.faces)) == part.name)
    if not len(faces):
        return part
    own = mesh.submesh([faces], append=True, repair=False)
    own.apply_transform(part.pose.inverse().matrix)
    file = f"{whole.name}.{part.name}.glb"
    look.write(own, folder / file)
    return replace(part, mesh=MeshFile(file))


def _owners(whole: Thing, count: int) -> Any:
    """Name of the part that each triangle belongs to: the first part's, where no joint moves it, else that of the last joint that does."""
    found = np.full(count, whole.parts[0].name, dtype=object)
    for part, first, last in _moved(whole):
        found[first:last] = part
    return found


def _moved(whole: Thing) -> Iterator[tuple[str, int, int]]:
    for moving in whole.mesh.joints if whole.mesh else ():
        yield from ((moving.part, first, last) for first, last in moving.faces if moving.part)
