"""Twins: worlds as they may really be, drawn from an error model around the believed one; no plan knows them.

Each source of error has random numbers of its own, so that a source that is left out changes nothing of what the others draw.
Where things are, and how large: ``twin_places``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.entity_name import thing_of
from ..model.error_model import ErrorModel
from ..model.geometry import Vector3
from ..model.twin_verdict import Draw
from ..model.world import Disturbance, Inertia, Thing, World
from .thing_boxes import extents
from .twin_drawing import DEG, MM, Drawing
from .twin_places import Sight, place

if TYPE_CHECKING:
    from ..model.belief import Relation
    from ..model.robot import Robot

class Twin(Value):
    """Twin of a believed world.

    Args:
        world: as it may really be.
        draws: the numbers that make it differ.
    """

    world: World
    draws: tuple[Draw, ...]


def draw_twin(
    world: World, relations: Iterable[Relation], robot: Robot, errors: ErrorModel, seed: int, sight: Sight | None = None
) -> Twin:
    """Draw a twin.

    Args:
        world, relations: as believed; ("hangs_on", thing, hanger) are the relations that matter.
        robot: of the first mount.
        seed: the same one gives the same twin.
        sight: of the camera that the belief comes from; None where poses are known.

    Raises:
        UserError: the error model names a thing that the world does not have.
    """
    names = [t.name for t in world.things]
    for name in errors.things:
        if name not in names:
            raise UserError(f"The errors of the twin are about '{name}', which is no thing of this world; {nearest(name, names)}.")
    draw = Drawing(errors, seed)
    hangers = {thing: thing_of(place) for predicate, thing, place in relations if predicate == "hangs_on"}
    things = tuple(_made(t, draw) for t in place(world, hangers, draw, sight))
    pads = world.physics.pad_friction * draw.share("friction", "pads: friction", errors.friction)
    disturbance = replace(_disturbance(robot, draw), centres=_centres(world, draw))
    twin = replace(world, things=things, physics=replace(world.physics, pad_friction=pads), disturbance=disturbance)
    return Twin(twin, tuple(draw.draws))


def _made(thing: Thing, draw: Drawing) -> Thing:
    """A thing with its real friction and mass."""
    rub = draw.share("friction", f"{thing.name}: friction", draw.errors.friction)
    geoms = tuple(g if g.friction is None else replace(g, friction=g.friction * rub) for g in thing.geoms)
    thing = replace(thing, geoms=geoms, friction=thing.friction * rub)
    if thing.mass is None:
        return thing
    heavy = draw.share("mass", f"{thing.name}: mass", draw.errors.mass)
    inertia = thing.inertia and Inertia(thing.inertia.centre, tuple(m * heavy for m in thing.inertia.moments))  # type: ignore[arg-type]
    filling = thing.filling and replace(thing.filling, mass=thing.filling.mass * heavy, friction=thing.filling.friction * rub)
    return replace(thing, mass=thing.mass * heavy, inertia=inertia, filling=filling)


def _centres(world: World, draw: Drawing) -> Mapping[str, Vector3]:
    """How far the centre of mass of each free thing is from where its shape has it, along the sides of the box around it [m]."""
    found = {}
    for thing in (t for t in world.things if not t.furniture and t.geoms):
        sides = zip("xyz", extents(thing), strict=True)
        x, y, z = (draw.number("centre", f"{thing.name}: centre of mass {a}", draw.errors.centre * side, "mm", MM) for a, side in sides)
        found[thing.name] = (x, y, z)
    return found if any(map(any, found.values())) else {}


def _disturbance(robot: Robot, draw: Drawing) -> Disturbance:
    """What is off of robot, sensor and gripper."""
    errors, count, sensor = draw.errors, len(robot.joints), draw.errors.sensor or robot.sensor_errors
    link = errors.scale * errors.kinematics / max(count, 1) ** 0.5
    links = tuple(_times(link, draw.sphere("arm")) for _ in range(count))
    zeros = tuple(draw.number("arm", f"{j}: zero", errors.calibration, "deg", DEG) for j in robot.joints)
    return Disturbance(
        force_noise=errors.scale * sensor.noise,
        force_bias=draw.ball("force sensor", "zero:", sensor.precision, "N"),
        force_turning=draw.ball("force sensor", "as if weight:", sensor.precision, "N"),
        force_drift=draw.ball("force sensor", "drift:", sensor.drift, "N/s"),
        latency=draw.between("latency", "latency", errors.latency, "ms", 1000.0),
        links=links if link else (),
        joint_zeros=zeros if any(zeros) else (),
        backlash=errors.scale * errors.backlash,
        gripper_force=draw.share("gripper force", "grip force", errors.gripper_force),
    )


def _times(factor: float, way: Vector3) -> Vector3:
    x, y, z = way
    return (factor * x, factor * y, factor * z)
