"""Sources of error of twins: how each is written, drawn and applied.

A source is declared at its field of ``ErrorModel``, and nowhere else: the keys of files, the value without errors and the drawing of
twins follow from the declaration. A source that acts inside a controller sets a field of ``Disturbance``, which simulators obey.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np
from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ..geometry import Vector3, vector3
from ..robot import Robot
from ..sensor_errors import SensorErrors
from ..world.thing import Inertia, Thing
from ..world.thing_boxes import extents
from ..world.world import World
from .twin_drawing import DEG, MM, Drawing

FURTHEST, WIDEST, LATEST = 0.5, 3.2, 1.0
"""Largest errors of lengths [m], angles [rad] and times [s]: beyond them nothing would be where it is believed to be."""
STEEPEST = 0.2
"""Largest lean of furniture [rad]: beyond it things on it would slide at a friction of .2."""


class Size(Value):
    """Limits on an error's size in scenario files: the kind of quantity, and the largest accepted value; the
    smallest is 0.

    Args:
        kind: of quantity; a "rate" is any number, a "share" is less than ``most``.
        most: largest that is accepted.
    """

    kind: Literal["share", "length", "angle", "force", "time", "rate"]
    most: float = math.inf


class Around(Value):
    """Believed world, to which the errors of a twin are added.

    Args:
        world: as believed.
        robot: of its first mount.
    """

    world: World
    robot: Robot


class ErrorSource(Value):
    """Source of error, declared in a field of ``ErrorModel`` that holds the error's size.

    Args:
        name: for people and of its random numbers; fields of one name are one source.
        rank: place among the sources: those that break programs most often come first.
        size: in files, under the name of the field; of both numbers of a pair.
        keys: where the field is a value: key of files -> attribute and size. None if files write the value as a whole.
        nothing: value without error.
        thing: gives a thing as it really is.
        world: gives a twin as it really is, once its things are made.
    """

    name: str
    rank: int = 100
    size: Size | None = None
    keys: Mapping[str, tuple[str, Size]] = field(default_factory=dict)
    nothing: Any = 0.0
    thing: Callable[[Thing, Any, Drawing], Thing] | None = None
    world: Callable[[World, Any, Drawing, Around], World] | None = None


def rubbing(thing: Thing, size: float, draw: Drawing) -> Thing:
    """Return a thing with its friction multiplied by a random factor."""
    rub = draw.share("friction", f"{thing.name}: friction", size)
    geoms = tuple(g if g.friction is None else replace(g, friction=g.friction * rub) for g in thing.geoms)
    filling = thing.filling and replace(thing.filling, friction=thing.filling.friction * rub)
    return replace(thing, geoms=geoms, friction=thing.friction * rub, filling=thing.filling if thing.mass is None else filling)


def rubbing_pads(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin with the friction of the gripper's pads multiplied by a random factor."""
    pads = around.world.physics.pad_friction * draw.share("friction", "pads: friction", size)
    return replace(twin, physics=replace(twin.physics, pad_friction=pads))


def weighing(thing: Thing, size: float, draw: Drawing) -> Thing:
    """Return a thing with its mass multiplied by a random factor."""
    if thing.mass is None:
        return thing
    heavy = draw.share("mass", f"{thing.name}: mass", size)
    inertia = thing.inertia and Inertia(thing.inertia.centre, tuple(m * heavy for m in thing.inertia.moments))  # type: ignore[arg-type]
    filling = thing.filling and replace(thing.filling, mass=thing.filling.mass * heavy)
    return replace(thing, mass=thing.mass * heavy, inertia=inertia, filling=filling)


def with_links(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin whose arm has random errors in the lengths of its links."""
    count = len(around.robot.joints)
    link = draw.scale * size / max(count, 1) ** 0.5
    links = tuple(vector3(link * np.array(draw.sphere("arm"))) for _ in range(count))
    return _disturbed(twin, links=links if link else ())


def with_zeros(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin whose true joint positions differ from the encoder readings."""
    zeros = tuple(draw.number("arm", f"{j}: zero", size, "deg", DEG) for j in around.robot.joints)
    return _disturbed(twin, joint_zeros=zeros if any(zeros) else ())


def with_backlash(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin whose joints have play."""
    return _disturbed(twin, backlash=draw.scale * size)


def with_sensor(twin: World, size: SensorErrors | None, draw: Drawing, around: Around) -> World:
    """Return a twin whose force sensor has random errors: noise, a wrong zero, and drift."""
    sensor, name = size or around.robot.sensor_errors, "force sensor"
    return _disturbed(
        twin, force_noise=draw.scale * sensor.noise, force_bias=draw.ball(name, "zero:", sensor.precision, "N"),
        force_turning=draw.ball(name, "as if weight:", sensor.precision, "N"),
        force_drift=draw.ball(name, "drift:", sensor.drift, "N/s"),
    )  # fmt: skip


def with_latency(twin: World, size: tuple[float, float], draw: Drawing, around: Around) -> World:
    """Return a twin whose measurements are late."""
    return _disturbed(twin, latency=draw.between("latency", "latency", size, "ms", 1000.0))


def with_grip(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin with the gripper's force multiplied by a random factor."""
    return _disturbed(twin, gripper_force=draw.share("gripper force", "grip force", size))


def with_centres(twin: World, size: float, draw: Drawing, around: Around) -> World:
    """Return a twin whose free things have displaced centres of mass, along the sides of their boxes."""
    found: dict[str, Vector3] = {}
    for thing in (t for t in around.world.things if not t.furniture and t.geoms):
        sides = zip("xyz", extents(thing), strict=True)
        x, y, z = (draw.number("centre", f"{thing.name}: centre of mass {a}", size * side, "mm", MM) for a, side in sides)
        found[thing.name] = (x, y, z)
    return _disturbed(twin, centres=found if any(map(any, found.values())) else {})


def _disturbed(twin: World, **changes: Any) -> World:
    return replace(twin, disturbance=replace(twin.disturbance, **changes))


