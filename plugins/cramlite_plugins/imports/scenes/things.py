"""Conversion of a scene's bodies to things: bodies that are fixed to each other make one, with shape, mass
and joint.

Features come from names, sites and geometry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Inertia, Pose, StatedJoint, Thing, Value, vector3

from .bodies import Group
from .geoms import Shaped, collides, pose_of, shaped
from .handles import with_handle
from .joints import joint_of
from .sites import LARGE, NARROW, places

CLASSES = {
    "free": "cram:Product", "fixed": "soma:DesignedFurniture", "slide": "soma:Drawer", "hinge": "soma:Door",
    "knob": "cram:Knob", "lever": "cram:Latch",
}  # fmt: skip
"""Class of a thing by its joint, if its names give none."""
CONTAINER = "soma:DesignedContainer"
"""Class of a fixed thing with cavities at sites, if its names give none."""
MOST = 6
"""Largest number of surfaces of one thing that become features."""


class Made(Value):
    """A thing of a scene.

    Args:
        thing: without a class that its name would give it.
        names: what else the file calls it.
        found: what it is taken for, in words.
        notes: what was changed or left out.
        carrier: what a jointed one is mounted in.
    """

    thing: Thing
    names: tuple[str, ...]
    found: str
    notes: tuple[str, ...]
    carrier: str = ""


def make(source: Any, group: Group, name: str, parent: str, meets: bool, stated: StatedJoint) -> Made | None:
    """Make one thing of bodies that are fixed to each other; None if no shape of theirs collides.

    Args:
        source: a ``Source``.
        name: of the thing.
        parent: name of the fixed thing that it is mounted in; "" for none.
        meets: whether the two collide.
        stated: what the user says of its joint.
    """
    model, data = source.model, source.data
    frame = pose_of(data.xpos[group.root], data.xmat[group.root])
    shapes = [shaped(model, data, g, frame) for g in _geoms_of(model, group.bodies) if collides(model, g)]
    geoms = tuple(g for s in shapes for g in s.geoms)
    if not geoms:
        return None
    thing = Thing(name, CLASSES[group.kind if group.kind != "joint" else "slide"], frame, geoms)
    notes = [n for s in shapes for n in s.notes]
    if group.kind != "fixed":
        mass, inertia = inertia_of(model, data, group.bodies, frame)
        thing = replace(thing, mass=mass, inertia=inertia)
    if group.kind == "joint":
        joint, said = joint_of(source, group, parent, meets, stated)
        thing = replace(thing, joint=joint, type=CLASSES[joint.kind])
        notes += said
    names = (*(model.body(b).name for b in group.bodies), *(s.name for s in shapes))
    thing, found = _featured(source, group, thing, shapes)
    return Made(thing, tuple(dict.fromkeys(n for n in names if n)), found, tuple(dict.fromkeys(notes)))


def make_of_world(source: Any, geom: int, name: str) -> Made | None:
    """Make a fixed thing of a geom that belongs to no body."""
    made = shaped(source.model, source.data, geom, Pose())
    if not made.geoms:
        return None
    at = made.geoms[0].pose
    geoms = tuple(replace(g, pose=at.inverse() * g.pose) for g in made.geoms)
    thing, found = _surfaced(Thing(name, CLASSES["fixed"], at, geoms, made.features))
    return Made(thing, (made.name,), found, made.notes)


def _geoms_of(model: Any, bodies: Iterable[int]) -> list[int]:
    return [g for b in bodies for g in range(int(model.body_geomadr[b]), int(model.body_geomadr[b]) + int(model.body_geomnum[b]))]


def inertia_of(model: Any, data: Any, bodies: Iterable[int], frame: Pose) -> tuple[float, Inertia]:
    """Compute the mass [kg] and inertia of bodies together, by Steiner's theorem, in a frame of the world."""
    rows = [b for b in bodies if model.body_mass[b] > 0]
    masses = np.array([model.body_mass[b] for b in rows])
    centres = np.array([data.xipos[b] for b in rows])
    centre = masses @ centres / masses.sum()
    whole = np.zeros((3, 3))
    for b, mass, at in zip(rows, masses, centres, strict=True):
        turn, off = data.ximat[b].reshape(3, 3), at - centre
        whole += turn @ np.diag(model.body_inertia[b]) @ turn.T + mass * (off @ off * np.eye(3) - np.outer(off, off))
    own: Floats = frame.rotation.T @ whole @ frame.rotation
    xx, yy, zz, xy, xz, yz = (float(own[i]) for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return float(masses.sum()), Inertia(vector3(frame.inverse().apply(centre)), (xx, yy, zz, xy, xz, yz))


def _featured(source: Any, group: Group, thing: Thing, shapes: list[Shaped]) -> tuple[Thing, str]:
    """Thing with features from sites, else from geometry: openings, surfaces, a handle."""
    sites = places(source.model, source.data, group.bodies, thing)
    found = {f.name: f for s in shapes for f in s.features} | {f.name: f for f in sites if f.type == "cram:Cavity"}
    thing, said = _surfaced(replace(thing, features=tuple(found.values())))
    areas = tuple(f for f in sites if f.type != "cram:Cavity")
    if group.kind == "fixed" and len(areas) < len(sites):
        thing = replace(thing, type=CONTAINER)
    thing = replace(thing, features=(*thing.features, *areas))
    said += "".join(f", area '{f.name}'" for f in areas)
    if thing.joint is not None:
        names = [s.name for s in shapes for _ in s.geoms]
        thing, handle = with_handle(thing, names)
        said = f"{said}; {handle}"
        lever = thing.joint is not None and bool(thing.joint.spring and thing.joint.parent)
        thing = replace(thing, type=CLASSES["lever" if lever else "knob"]) if _turns_in_place(thing) else thing
    return thing, said


def _turns_in_place(thing: Thing) -> bool:
    """Whether a thing's hinge turns its handle on the spot, as a knob's does."""
    handle = thing.feature("cram:Handle")
    if thing.joint is None or thing.joint.kind != "hinge" or handle is None:
        return False
    axis = thing.joint.pose.rotation[:, 2]
    return abs(float(axis @ handle.pose.rotation[:, 2])) > math.cos(math.radians(30.0))


def _surfaced(thing: Thing) -> tuple[Thing, str]:
    """Add a thing's cavity and its large level faces to its features; return also a description of them.

    A movable thing without either gets its largest level face, such as a bottle's cap.
    """
    from ...shapes.cavities import cavity
    from ...shapes.surfaces import surfaces

    hollow = None if thing.feature("cram:Cavity") else cavity(thing, thing.pose)
    every = list(surfaces(thing, thing.pose))
    wide = [s for s in every if s.area.area > LARGE]
    small = sorted((s for s in every if thing.mass and not hollow), key=lambda s: -float(s.area.area))[:1]
    level = [(s.pose, _largest(s.area)) for s in wide or small]
    tops = [
        Feature(f"surface{k + 1 if k else ''}", "vrps:SurfaceFeature", thing.pose.inverse() * pose, size)
        for k, (pose, size) in enumerate((p, s) for p, s in level[:MOST] if min(s.values()) > NARROW)
    ]
    features = (*thing.features, *([hollow] if hollow else ()), *(tops or _floors(hollow)))
    said = [f"{len(tops)} surface{'s' * (len(tops) != 1)}"] if tops else []
    for feature in features:
        if feature.type != "vrps:SurfaceFeature" and feature.name != "handle":
            said.append(f"{feature.name} of {' x '.join(f'{1000 * v:.0f}' for v in feature.size.values())} mm")
    return replace(thing, features=features), ", ".join(said) or "no surfaces"


def _floors(hollow: Feature | None) -> list[Feature]:
    """Floor of a cavity, also a round one: the supporting surface of a thing without a level face."""
    if hollow is None:
        return []
    floor = hollow.pose * Pose((0.0, 0.0, -hollow.size["height"]))
    return [Feature("floor", "vrps:SurfaceFeature", floor, {k: hollow.size[k] for k in ("width", "depth")})]


def _largest(area: Any) -> dict[str, float]:
    """Scale an area's bounding box down about the origin until it fits into the area, and return its sides [m]."""
    import shapely

    x, y, x1, y1 = area.bounds
    wide = area.buffer(1e-6)  # rounding
    shares = [k / 50 for k in range(50, 0, -1)]
    share = next((s for s in shares if wide.covers(shapely.box(s * x, s * y, s * x1, s * y1))), 0.0)
    return {"width": round(share * (x1 - x), 4), "depth": round(share * (y1 - y), 4)}
