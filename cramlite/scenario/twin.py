"""Twins: worlds as they may really be, drawn from an error model around the believed one; no plan knows them.

Each source of error has random numbers of its own, so that a source that is left out changes nothing of what the others draw.
What hangs goes on to hang: it moves with what it hangs on, along the peg and about the vertical. What stands goes on to stand: it
moves up and down with what it stands on. What is mounted moves with what carries it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.seeds import derive_seed
from ..base.value import Value
from ..model.entity_name import thing_of
from ..model.error_model import ErrorModel, PoseError
from ..model.geometry import Pose, Vector3
from ..model.twin_verdict import Draw
from ..model.world import Disturbance, Geom, Inertia, Thing, World

if TYPE_CHECKING:
    from ..model.belief import Relation
    from ..model.robot import Robot

LEAST = 0.05
"""A share of friction, mass or force is drawn no lower, however large the error model's numbers are."""
GAP = 0.01
"""What stands may be this far above or inside what it stands on when the world is written [m]; it settles."""
MM, DEG = 1000.0, 180.0 / math.pi


class Twin(Value):
    """Twin of a believed world.

    Args:
        world: as it may really be.
        draws: the numbers that make it differ.
    """

    world: World
    draws: tuple[Draw, ...]


class Sight(Value):
    """Sight of a camera: which things are where it saw them, and where it was.

    Args:
        camera: its optical frame in the world.
        things: names.
    """

    camera: Pose
    things: frozenset[str]


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
    draw = _Drawing(errors, seed)
    hangers = {thing: thing_of(place) for predicate, thing, place in relations if predicate == "hangs_on"}
    places = _places(world, hangers, draw, sight)
    things = tuple(_made(replace(t, pose=places[t.name]), draw) for t in world.things)
    pads = world.physics.pad_friction * draw.share("friction", "pads: friction", errors.friction)
    disturbance = _disturbance(robot, draw)
    twin = replace(world, things=things, physics=replace(world.physics, pad_friction=pads), disturbance=disturbance)
    return Twin(twin, tuple(draw.draws))


class _Drawing:
    """The random numbers of a twin, and what was drawn with them."""

    def __init__(self, errors: ErrorModel, seed: int) -> None:
        self.errors, self.seed, self.draws = errors, seed, list[Draw]()
        self._random: dict[str, Any] = {}

    def random(self, source: str) -> Any:
        """The generator of a source."""
        import numpy as np

        if source not in self._random:
            self._random[source] = np.random.default_rng(derive_seed(self.seed, (), source))
        return self._random[source]

    def number(self, source: str, name: str, size: float, unit: str, per: float) -> float:
        """Uniform in plus or minus ``size`` times the scale; told in ``unit``, of which an SI unit has ``per``."""
        return self._noted(source, name, float(self.random(source).uniform(-1, 1)), size, unit, per)

    def share(self, source: str, name: str, size: float) -> float:
        """A factor around 1."""
        return max(LEAST, 1.0 + self.number(source, name, size, "%", 100.0))

    def ball(self, source: str, name: str, radius: float, unit: str, per: float = 1.0) -> Vector3:
        """Uniform in a ball."""
        x, y, z = self.sphere(source)
        far = float(self.random(source).uniform()) ** (1 / 3)
        return tuple(self._noted(source, f"{name} {a}", far * v, radius, unit, per) for a, v in zip("xyz", (x, y, z), strict=True))  # type: ignore[return-value]

    def sphere(self, source: str) -> Vector3:
        """Uniform on the unit sphere."""
        way = self.random(source).normal(size=3)
        x, y, z = (way / (way @ way) ** 0.5).tolist()
        return (x, y, z)

    def between(self, source: str, name: str, ends: tuple[float, float], unit: str, per: float) -> float:
        """Uniform between two ends."""
        low, high = ends
        return self._noted(source, name, float(self.random(source).uniform(low, high)) / (high or 1.0), high, unit, per)

    def _noted(self, source: str, name: str, share: float, size: float, unit: str, per: float) -> float:
        size *= self.errors.scale
        if size:
            self.draws.append(Draw(source, name, round(share * size * per, 6), round(size * per, 6), unit))
        return share * size


def _places(world: World, hangers: Mapping[str, str], draw: _Drawing, sight: Sight | None) -> dict[str, Pose]:
    """Where the things really are, each with what carries it."""
    seen = _hand_eye(draw, sight) if sight is not None else None
    offs, found = dict[str, Pose](), dict[str, Pose]()
    for thing in world.things:
        off = _offset(thing, draw)
        offs[thing.name] = seen(thing.pose) * off if seen and sight and thing.name in sight.things else off
    carriers = {t.name: hangers.get(t.name, t.joint.parent if t.joint else "") for t in world.things}

    def put(thing: Thing) -> None:
        carrier, off = carriers[thing.name], offs.pop(thing.name)
        if carrier in offs:  # files of others list drawers before their cabinets
            put(world.thing(carrier))
        if carrier in found:
            before = world.thing(carrier)
            own = _swung(thing, before, off) if thing.name in hangers else thing.pose
            moved = found[carrier] != before.pose
            found[thing.name] = found[carrier] * before.pose.inverse() * own if moved else own
        else:
            found[thing.name] = _displaced(thing, off, _support(thing, world, found))

    for thing in world.things:
        if thing.name in offs:
            put(thing)
    return found


def _offset(thing: Thing, draw: _Drawing) -> Pose:
    """How far a thing is off by itself: a shift in world axes, and a turn about the vertical."""
    error: PoseError = draw.errors.of(thing.name)
    shift = draw.ball("poses", f"{thing.name}:", error.position, "mm", MM)
    turn = draw.number("poses", f"{thing.name}: turned", error.angle, "deg", DEG)
    return Pose.from_rotvec(shift, (0.0, 0.0, turn))


def _hand_eye(draw: _Drawing, sight: Sight) -> Callable[[Pose], Pose]:
    """What an error of the camera's mounting does at a place: a shift, and a turn about the vertical."""
    error = draw.errors.hand_eye
    shift = draw.ball("hand-eye", "camera:", error.position, "mm", MM)
    turn = draw.ball("hand-eye", "camera: turned about", error.angle, "deg", DEG)
    moved = sight.camera * Pose.from_rotvec(shift, turn) * sight.camera.inverse()

    def at(pose: Pose) -> Pose:
        x, y, z = (b - a for a, b in zip(pose.position, moved.apply(pose.position), strict=True))
        return Pose.from_rotvec((float(x), float(y), float(z)), (0.0, 0.0, float(moved.rotvec[2])))

    return at


def _swung(thing: Thing, hanger: Thing, off: Pose) -> Pose:
    """Where something hangs that is off: shifted along what it hangs on, turned about the vertical through where it hangs."""
    pairs = [(thing.pose * f.pose, hanger.pose * g.pose) for f in thing.features for g in hanger.features]
    if not pairs or off == Pose():
        return thing.pose
    hole, peg = min(pairs, key=lambda p: _from_axis(*p))
    axis, (hx, hy, hz) = peg.rotate((0.0, 0.0, 1.0)), hole.position
    along = float(sum(a * b for a, b in zip(axis, off.position, strict=True)))
    about = Pose((hx, hy, hz)) * Pose(quaternion=off.quaternion) * Pose((-hx, -hy, -hz))
    return Pose(tuple(float(along * a) for a in axis)) * about * thing.pose  # type: ignore[arg-type]


def _from_axis(hole: Pose, peg: Pose) -> float:
    """How far a feature is from the axis of another one [m]."""
    x, y, _ = peg.inverse().apply(hole.position)
    return math.hypot(x, y)


def _displaced(thing: Thing, off: Pose, lifted: float) -> Pose:
    """What is fixed is off in every direction; what can move goes up and down with what it stands on."""
    if off == Pose() and not lifted:
        return thing.pose
    x, y, z = off.position
    px, py, pz = thing.pose.position
    turned = Pose(quaternion=off.quaternion) * Pose(quaternion=thing.pose.quaternion)
    return Pose((px + x, py + y, pz + (lifted if thing.movable else z)), turned.quaternion)


def _support(thing: Thing, world: World, found: Mapping[str, Pose]) -> float:
    """How far what a thing stands on was lifted [m]; 0 where it stands on nothing."""
    if not thing.movable or not thing.geoms:
        return 0.0
    x, y, _ = thing.pose.position
    bottom = min(box[0][2] for box in _boxes(thing))
    tops = [
        (high[2], other.name)
        for other in world.things
        if other.name in found
        for low, high in _boxes(other)
        if low[0] <= x <= high[0] and low[1] <= y <= high[1] and abs(high[2] - bottom) <= GAP
    ]
    if not tops:
        return 0.0
    name = max(tops)[1]
    return found[name].position[2] - world.thing(name).pose.position[2]


def _boxes(thing: Thing) -> list[tuple[Vector3, Vector3]]:
    """Lower and upper corner of the box around each geom, along the world's axes [m]."""
    return [_box(thing.pose * g.pose, g) for g in thing.geoms]


def _box(pose: Pose, geom: Geom) -> tuple[Vector3, Vector3]:
    reach = abs(pose.rotation) @ geom.half_extents
    low, high = ([p + s * r for p, r in zip(pose.position, reach.tolist(), strict=True)] for s in (-1.0, 1.0))
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def _made(thing: Thing, draw: _Drawing) -> Thing:
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


def _disturbance(robot: Robot, draw: _Drawing) -> Disturbance:
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
