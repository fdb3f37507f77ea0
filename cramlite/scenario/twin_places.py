"""Sizes and places of the things in a twin, each with its errors and moved with its carrier.

What hangs goes on to hang: it moves with what it hangs on, along the peg and about the vertical. What stands goes on to stand: it goes up,
down and over with what it stands on. What is mounted moves with what carries it. What is fixed leans about its base, but for what a
robot's platform stands on: that is level with the robot, wherever it drives. What is free is scaled about the point that it stands or
hangs on. Furniture keeps its size: a drawer has 3 mm in its cabinet, and where their faces are is what errors of poses are about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.value import Value
from ..model.geometry import Pose, Vector3, vector3
from ..model.twins.error_model import ErrorModel
from ..model.twins.twin_drawing import DEG, MM, Drawing
from ..model.world.thing import Feature, Thing
from ..model.world.thing_boxes import Box, around, boxes
from ..model.world.world import World
from .scaled_thing import scaled

if TYPE_CHECKING:
    from ..model.robot import Robot

INSIDE = 0.01
"""Depth by which a believed pose may put a thing into its support, so that it still counts as standing on it [m]. The thing settles when
the world is simulated."""
NANOMETRE = 9
"""Number of decimals to which the height [m] of a point on a leaning or scaled support is rounded. Other supports leave the things on them
unchanged, to the last bit."""


class Sight(Value):
    """View of a camera: the pose of the camera, and the things whose poses come from its picture.

    Args:
        camera: its optical frame in the world.
        things: names.
    """

    camera: Pose
    things: frozenset[str]


class _Placing:
    """Places of a twin's things: the drawn errors of all things, and the things that were placed so far."""

    def __init__(
        self, world: World, hangers: Mapping[str, str], robot: Robot, errors: ErrorModel, draw: Drawing, sight: Sight | None
    ) -> None:
        self.world, self.hangers = world, hangers
        self.offs = _offsets(world, errors, draw, sight)
        self.waiting = {t.name for t in world.things}
        self.factors = {t.name: draw.share("size", f"{t.name}: size", errors.size) for t in world.things if _free(t)}
        self.boxes = {t.name: boxes(t) for t in world.things}
        level = _driven_on(world, robot, self.boxes)
        self.leans = {t.name: _lean(t, errors, draw) for t in world.things if not t.movable and t.geoms and t.name not in level}
        self.found = dict[str, Thing]()

    def put(self, thing: Thing) -> None:
        """Place a thing after its carrier, since scene files may list a drawer before its cabinet."""
        self.waiting.discard(thing.name)
        carrier = self.hangers.get(thing.name, thing.joint.parent if thing.joint else "")
        if carrier in self.waiting:
            self.put(self.world.thing(carrier))
        placed = self._carried(thing, self.world.thing(carrier)) if carrier in self.found else self._set(thing)
        self.found[thing.name] = placed

    def _carried(self, thing: Thing, before: Thing) -> Thing:
        """Return a hanging or mounted thing at the pose to which its displaced carrier takes it."""
        own, carrier = thing.pose, self.found[before.name].pose
        if thing.name in self.hangers:
            hung = replace(thing, pose=_hung(thing, before, self.factors.get(thing.name, 1.0)))
            own = _swung(hung, before, self.offs[thing.name])
        return replace(self._sized(thing), pose=carrier * before.pose.inverse() * own if carrier != before.pose else own)

    def _set(self, thing: Thing) -> Thing:
        """Return a thing that no other carries, with its own errors: displaced, leaning and scaled."""
        under, lifted = self._support(thing)
        lean = self.leans.get(under if thing.movable else thing.name, Pose())
        if thing.movable:
            self.leans[thing.name] = lean
        pose, height = _displaced(thing, self.offs[thing.name], lifted)
        if lean != Pose():
            pose = _about((*pose.position[:2], self._foot(thing) + height), lean) * pose
        return replace(self._sized(thing), pose=self._raised(thing, pose, lean))

    def _sized(self, thing: Thing) -> Thing:
        return scaled(thing, self.factors[thing.name]) if thing.name in self.factors else thing

    def _raised(self, thing: Thing, pose: Pose, lean: Pose) -> Pose:
        """Return the pose of a scaled thing, shifted so that its base stays in place."""
        more = self.factors.get(thing.name, 1.0) - 1.0
        if not more:
            return pose
        return _shifted(pose, vector3(lean.rotate((0.0, 0.0, more * (thing.pose.position[2] - self._foot(thing))))))

    def _support(self, thing: Thing) -> tuple[str, float]:
        """Return the support of a thing, and how far the support was raised below it [m]; "" and 0 if there
        is none."""
        if not thing.movable or not thing.geoms:
            return "", 0.0
        x, y, _ = thing.pose.position
        others = (o.name for o in self.world.things if o.name in self.found or o.name in self.waiting)
        tops = [(height, o) for o in others for height in _heights((x, y), self.boxes[thing.name], self.boxes[o])]
        if not tops:
            return "", 0.0
        height, name = max(tops)
        if name in self.waiting:
            self.put(self.world.thing(name))
        return name, self._lifted(name, (x, y, height))

    def _foot(self, thing: Thing) -> float:
        """Return the height of the lowest point of a thing at its believed pose [m]."""
        return min(low[2] for low, _ in self.boxes[thing.name])

    def _lifted(self, name: str, point: Vector3) -> float:
        """Return how much higher a point of a thing is in the twin, where the thing is shifted, scaled and
        tilted, than in the belief [m]."""
        before, after = self.world.thing(name).pose, self.found[name].pose
        arm = before.inverse().apply(point)
        there = after.rotate(self.factors.get(name, 1.0) * arm)[2] - before.rotate(arm)[2]
        return after.position[2] - before.position[2] + round(float(there), NANOMETRE)


def place(
    world: World, hangers: Mapping[str, str], robot: Robot, errors: ErrorModel, draw: Drawing, sight: Sight | None
) -> tuple[Thing, ...]:
    """Draw random size and pose errors of all things, and return the things with these errors.

    Args:
        hangers: thing -> what it hangs on.
        robot: of the first mount.
        sight: of the camera that the poses come from; None where they are known.
    """
    placing = _Placing(world, hangers, robot, errors, draw, sight)
    for thing in world.things:
        if thing.name in placing.waiting:
            placing.put(thing)
    return tuple(placing.found[t.name] for t in world.things)


def _free(thing: Thing) -> bool:
    return not thing.furniture and bool(thing.geoms)


def _driven_on(world: World, robot: Robot, found: Mapping[str, Sequence[Box]]) -> frozenset[str]:
    """Return the names of the fixed things that the first robot's platform stands on; none for an arm that is bolted down."""
    if robot.platform is None or not world.robots:
        return frozenset()
    x, y, z = world.robots[0].base.position
    below = ((t.name, low, high) for t in world.things if not t.movable for low, high in found[t.name])
    return frozenset(name for name, low, high in below if abs(high[2] - z) <= INSIDE and _over((x, y), low, high))


def _lean(thing: Thing, errors: ErrorModel, draw: Drawing) -> Pose:
    """Draw the lean of a fixed thing: a rotation about a horizontal axis."""
    x, y = draw.disc("lean", f"{thing.name}: leans about", errors.lean, "deg", DEG)
    return Pose.from_rotvec((0.0, 0.0, 0.0), (x, y, 0.0))


def _offsets(world: World, errors: ErrorModel, draw: Drawing, sight: Sight | None) -> dict[str, Pose]:
    """Draw the pose error of each thing: its own, combined with that of the camera that saw it."""
    seen, offs = _hand_eye(errors, draw, sight) if sight is not None else None, dict[str, Pose]()
    for thing in world.things:
        off = _offset(thing, errors, draw)
        offs[thing.name] = seen(thing.pose) * off if seen and sight and thing.name in sight.things else off
    return offs


def _offset(thing: Thing, errors: ErrorModel, draw: Drawing) -> Pose:
    """Draw a thing's own pose error: a shift in world axes, and a rotation about the vertical."""
    error = errors.of(thing.name)
    shift = draw.ball("poses", f"{thing.name}:", error.position, "mm", MM)
    turn = draw.number("poses", f"{thing.name}: turned", error.angle, "deg", DEG)
    return Pose.from_rotvec(shift, (0.0, 0.0, turn))


def _hand_eye(errors: ErrorModel, draw: Drawing, sight: Sight) -> Callable[[Pose], Pose]:
    """Draw an error of the camera's mounting; return a function from a thing's pose to the error of that pose: a
    shift, and a rotation about the vertical."""
    error = errors.hand_eye
    shift = draw.ball("hand-eye", "camera:", error.position, "mm", MM)
    turn = draw.ball("hand-eye", "camera: turned about", error.angle, "deg", DEG)
    moved = sight.camera * Pose.from_rotvec(shift, turn) * sight.camera.inverse()

    def at(pose: Pose) -> Pose:
        x, y, z = (b - a for a, b in zip(pose.position, moved.apply(pose.position), strict=True))
        return Pose.from_rotvec((float(x), float(y), float(z)), (0.0, 0.0, float(moved.rotvec[2])))

    return at


def _heights(middle: tuple[float, float], thing: Sequence[Box], other: Sequence[Box]) -> Iterator[float]:
    """Yield heights at which a support may carry a thing [m].

    They are those of parts under the thing's middle, and of parts under its base that have the middle between them.
    """
    foot = min(low[2] for low, _ in thing)
    below = [box for box in other if box[1][2] <= foot + INSIDE]
    yield from (high[2] for low, high in below if _over(middle, low, high))
    soles = [box for box in thing if box[0][2] <= foot + INSIDE]
    touched = [box for box in below if any(_meet(box, sole) for sole in soles)]
    for top in [max(high[2] for _, high in touched)] if touched else []:
        if _over(middle, *around([box for box in touched if box[1][2] >= top - INSIDE])):
            yield top


def _over(point: tuple[float, float], low: Vector3, high: Vector3) -> bool:
    """Check whether a point of the horizontal plane is inside a box as seen from above."""
    return all(low[k] <= point[k] <= high[k] for k in (0, 1))


def _meet(one: Box, other: Box) -> bool:
    """Check whether two boxes overlap as seen from above."""
    return all(one[0][k] <= other[1][k] and other[0][k] <= one[1][k] for k in (0, 1))


def _displaced(thing: Thing, off: Pose, lifted: float) -> tuple[Pose, float]:
    """Return a thing's pose with its drawn error added, and by how much the thing was raised [m].

    Fixed things have errors in every direction; movable ones keep their height above the support.
    """
    x, y, z = off.position
    height = lifted if thing.movable else z
    if off == Pose() and not lifted:
        return thing.pose, height
    turned = Pose(quaternion=off.quaternion) * Pose(quaternion=thing.pose.quaternion)
    return Pose(_plus(thing.pose.position, (x, y, height)), turned.quaternion), height


def _hung(thing: Thing, hanger: Thing, factor: float) -> Pose:
    """Return the pose of a scaled hanging thing whose hole rests on the peg at the same place as before."""
    resting = _resting(thing, hanger)
    if resting is None:
        return thing.pose
    hole = resting[0]
    top = (thing.pose * hole.pose).position[2] + hole.size.get("diameter", 0.0) / 2
    hx, hy, _ = (thing.pose * hole.pose).position
    x, y, z = ((1.0 - factor) * (a - b) for a, b in zip((hx, hy, top), thing.pose.position, strict=True))
    return _shifted(thing.pose, (x, y, z))


def _swung(thing: Thing, hanger: Thing, off: Pose) -> Pose:
    """Return the pose of a hanging thing with its error: shifted along its peg, rotated about the vertical
    through its hanging point."""
    resting = _resting(thing, hanger)
    if resting is None or off == Pose():
        return thing.pose
    hole, peg = resting
    axis, at = peg.rotate((0.0, 0.0, 1.0)), (thing.pose * hole.pose).position
    along = float(sum(a * b for a, b in zip(axis, off.position, strict=True)))
    return Pose(tuple(float(along * a) for a in axis)) * _about(at, Pose(quaternion=off.quaternion)) * thing.pose  # type: ignore[arg-type]


def _resting(thing: Thing, hanger: Thing) -> tuple[Feature, Pose] | None:
    """Return the feature of a hanging thing that is nearest to the axis of a feature of its hanger, and the pose of that axis.

    None if one of the two has no feature.
    """
    pairs = [(f, hanger.pose * g.pose) for f in thing.features for g in hanger.features]
    return min(pairs, key=lambda p: _from_axis(thing.pose * p[0].pose, p[1]), default=None)


def _from_axis(hole: Pose, peg: Pose) -> float:
    """Return the distance of a feature from another feature's axis [m]."""
    x, y, _ = peg.inverse().apply(hole.position)
    return math.hypot(x, y)


def _about(point: Vector3, turn: Pose) -> Pose:
    """Return a rotation about a point as a pose."""
    x, y, z = point
    return Pose(point) * turn * Pose((-x, -y, -z))


def _shifted(pose: Pose, by: Vector3) -> Pose:
    return Pose(_plus(pose.position, by), pose.quaternion)


def _plus(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
