"""Handles and knobs of drawers and doors: by their names, else by parts that stick out of the front."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from cramlite.model import Feature, Floats, Geom, Joint, Pose, Thing, Value

from ...shapes.bounds import box_around

NAMED = re.compile(r"handle|knob|pull(?!ey)|lever", re.IGNORECASE)
OUT = 0.010
"""Least length by which a handle sticks out of its front [m]: with less there is no room behind it for a finger."""
SHARE = 0.5
"""A handle has at most this share of the area of its front, seen from outside."""
SLIM = 0.06
"""Largest thickness of a handle [m]: a thicker one does not fit between fingers."""
MIDDLE = 0.5
"""Central share of a thing's width in which the hinge of a knob lies; the hinge of a door lies at the edge."""


class Handle(Value):
    """Handle of a drawer or door, as found in a scene file.

    Args:
        feature: its pose, z out of the front; for hinges x along the bar, for slides across it.
        parts: indices of its geoms.
        why: it is taken for one.
    """

    feature: Feature
    parts: tuple[int, ...]
    why: str


def find_handle(geoms: Sequence[Geom], names: Sequence[str], joint: Joint) -> Handle | None:
    """Find the handle of a drawer or a door.

    Args:
        geoms: in the thing's frame, each with the name of the file's geom, mesh or body.
        joint: it opens with a growing value.
    """
    named = tuple(k for k, name in enumerate(names) if NAMED.search(name))
    rest = [g for k, g in enumerate(geoms) if k not in named]
    outs = _outward(rest or list(geoms), joint)
    if named:
        out = max(outs, key=lambda o: max(_reach(geoms[k], o) for k in named))
        return _handle(geoms, named, out, joint, f"named '{names[named[0]]}'")
    for out in outs:
        plate = max(geoms, key=lambda g: _area(g, out))
        front, area = _reach(plate, out), _area(plate, out)
        parts = tuple(k for k, g in enumerate(geoms) if _reach(g, out) > front + OUT and _area(g, out) < SHARE * area)
        if parts:
            far = max(_reach(geoms[k], out) for k in parts) - front
            return _handle(geoms, parts, out, joint, f"it sticks out of the front by {1000 * far:.0f} mm")
    return None


def _outward(geoms: Sequence[Geom], joint: Joint) -> list[Floats]:
    """Return the directions in which a front may face: the slide axis of a drawer, or both normals of a door.

    The side to which the door opens comes first.
    """
    axis = joint.pose.rotation[:, 2]
    if joint.kind == "slide":
        return [axis]
    plate = max(geoms, key=lambda g: float(np.prod(g.half_extents)))
    thin = plate.pose.rotation[:, int(np.argmin(plate.half_extents))]
    way = np.cross(axis, np.asarray(plate.pose.position) - np.asarray(joint.pose.position))
    if abs(float(thin @ axis)) > 0.7 or np.linalg.norm(way) < OUT or _about(geoms, joint):  # a knob turns about what it sticks out along
        return [axis, -axis]
    return [thin, -thin] if thin @ way > 0 else [-thin, thin]


def _about(geoms: Sequence[Geom], joint: Joint) -> bool:
    """Whether a hinge goes through the middle of the part that it turns."""
    low, high = _boxes(geoms, joint.pose)
    return bool((np.abs(low + high)[:2] < MIDDLE * (high - low)[:2]).all())


def _frame(out: Floats) -> Pose:
    up = (0.0, 0.0, 1.0) if abs(out[2]) < 0.9 else (1.0, 0.0, 0.0)
    return Pose.from_axes((0, 0, 0), out, up)


def _boxes(geoms: Sequence[Geom], frame: Pose) -> tuple[Floats, Floats]:
    from msgspec.structs import replace

    return box_around(replace(g, pose=frame.inverse() * g.pose) for g in geoms)


def _reach(geom: Geom, out: Floats) -> float:
    return float(_boxes([geom], _frame(out))[1][2])


def _area(geom: Geom, out: Floats) -> float:
    low, high = _boxes([geom], _frame(out))
    return float(np.prod((high - low)[:2]))


def _post(geom: Geom, out: Floats) -> bool:
    """Whether a part sticks out of the front farther than it is wide, as a knob or the post of a lever does."""
    low, high = _boxes([geom], _frame(out))
    return bool((high - low)[2] > (high - low)[:2].max())


def _handle(geoms: Sequence[Geom], parts: tuple[int, ...], out: Floats, joint: Joint, why: str) -> Handle | None:
    """Return a handle made of parts that stick out of a front: its bar is the outermost part, preferably not a
    post; fingers close across the bar's thinner side."""
    frame = _frame(out)
    bar = max((geoms[k] for k in parts), key=lambda g: (not _post(g, out), round(_reach(g, out), 4), _area(g, out)))
    low, high = _boxes([bar], frame)
    size, middle = high - low, frame.apply((low + high) / 2)
    along = 0 if size[0] > size[1] else 1
    if size[1 - along] > SLIM:
        return None
    bar_axis = frame.rotation[:, along]
    x = bar_axis if joint.kind == "hinge" else np.cross(bar_axis, out)
    pose = Pose.from_axes(tuple(float(v) for v in middle), out, x)
    length = {"radius": round(float(size[1 - along]) / 2, 5), "length": round(float(size[along]), 5)}
    return Handle(Feature("handle", "cram:Handle", pose, length), parts, why)


def with_handle(thing: Thing, names: Sequence[str]) -> tuple[Thing, str]:
    """Return a jointed thing with its handle, and a note on it.

    Args:
        names: what the file calls each of its geoms.
    """
    from msgspec.structs import replace

    assert thing.joint is not None
    if any(f.type == "cram:Handle" and "radius" in f.size for f in thing.features):
        return thing, "its handle is a site of the file"
    found = find_handle(thing.geoms, names, thing.joint)
    if found is None:
        return thing, "no handle was found: nothing is called so or sticks out of its front, slim enough for fingers"
    geoms = tuple(replace(g, part="handle") if k in found.parts else g for k, g in enumerate(thing.geoms))
    others = tuple(f for f in thing.features if f.name != "handle")
    said = f"a handle {2000 * found.feature.size['radius']:.0f} mm thick: {found.why}"
    return replace(thing, geoms=geoms, features=(*others, found.feature)), said
