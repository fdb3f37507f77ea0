"""Functions that make things of the object models of a library."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec import DecodeError, json
from msgspec.structs import replace

from cramlite.model import Inertia, MeshFile, Pose, Thing, Vector3
from cramlite.plugin import Angle, Length, Mass, ModelMaker, UserError, nearest, read_value

from .entries import Entry

DIRECTIONS = ("x", "-x", "y", "-y", "z", "-z")


def maker(name: str, entry: Entry, folder: Path) -> ModelMaker:
    """Return the ``ModelMaker`` that makes things of an object model, from the model's entry in a library's
    file.

    Raises:
        UserError: a file is missing, or its usual side up is no axis.
    """
    for part in (entry.thing, entry.look):
        if not (folder / part).is_file():
            raise UserError(f"{folder}: model '{name}' names '{part}', and there is no such file; add its folder again.")
    if entry.up is not None and entry.up not in DIRECTIONS:
        raise UserError(f"{folder}: model '{name}': up is one of {', '.join(DIRECTIONS)}, not '{entry.up}'.")

    def make(
        *, name: str, pose: Pose, mass: Mass | None = None, fixed: bool | None = None, joints: Mapping[str, Any] | None = None
    ) -> Thing:
        thing = _read(folder / entry.thing)
        still = entry.fixed if fixed is None else fixed
        weight = None if still else _heavy(thing, entry.mass if mass is None else _kilograms(mass), f"model '{name}'")
        look = MeshFile(str(folder / entry.look), 1.0, _direction(entry.up), thing.mesh.joints if thing.mesh else ())
        inertia = None if weight is None or thing.inertia is None or not thing.mass else _scaled(thing.inertia, weight / thing.mass)
        parts = tuple(_with_look(p, folder) for p in thing.parts) if still else ()
        made = replace(thing, name=name, pose=pose, type=entry.type, mass=weight, inertia=inertia, mesh=look, parts=parts)
        made = replace(made, looks=entry.looks.value)
        return made.at_joints({n: _at(made, n, value) for n, value in (joints or {}).items()})

    return ModelMaker(name, make, product=True)


def _with_look(part: Thing, folder: Path) -> Thing:
    return replace(part, mesh=MeshFile(str(folder / part.mesh.path))) if part.mesh else part


def _at(model: Thing, name: str, value: Any) -> float:
    """Read a stated value of a model's joint [m, rad]."""
    known = {j.name: j.joint for j in model.mesh.joints} if model.mesh else {}
    if name not in known:
        raise UserError(f"'joints': model has no joint '{name}'; {nearest(name, known)}.")
    joint = known[name]
    found = float(read_value(Length if joint.kind == "slide" else Angle, value))
    if not joint.lower <= found <= joint.upper:
        raise UserError(f"'joints': '{name}' goes from {joint.lower:g} to {joint.upper:g}, not to {found:g}.")
    return found


def _kilograms(mass: Any) -> float:
    return float(read_value(Mass, mass))


def _heavy(thing: Thing, stated: float | None, where: str) -> float:
    found = stated if stated is not None else thing.mass
    if found is None:
        raise UserError(f"{where} has no mass: write 'mass' in its library's file, or 'fixed: true'.")
    return found


def _scaled(inertia: Inertia, factor: float) -> Inertia:
    xx, yy, zz, xy, xz, yz = (factor * m for m in inertia.moments)
    return Inertia(inertia.centre, (xx, yy, zz, xy, xz, yz))


def _direction(up: str | None) -> Vector3 | None:
    from .attitudes import NAMES

    return None if up is None else NAMES[up]


def _read(file: Path) -> Thing:
    try:
        return json.decode(file.read_bytes(), type=Thing)
    except (OSError, DecodeError) as error:
        raise UserError(f"'{file}' cannot be read as a library's model ({error}); add its folder again.") from error
