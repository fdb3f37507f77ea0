"""Fluents and static definitions of the shipped predicates, for planning."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely

from cramlite.model import EntityName, Floats, Thing, thing_of, vector3
from cramlite.plugin import (
    EFFECTOR,
    Fact,
    Fluent,
    SymbolicWorld,
    contents,
)

from ..shapes.bounds import centre_of_mass, corners, lowest
from ..shapes.itself import remembered
from ..shapes.nesting import room_under
from ..shapes.standing_up import stood_up
from ..shapes.surfaces import SUNK, resting_height
from . import goal_phrases
from .extents import CAVITY, PEG, SURFACE, in_cavity

HAND = "soma:Gripper"
"""Class of the acting hand."""
CLOSED = 0.1
"""Share of a joint's range below which a thing is closed at the start."""
WIDE = 0.8
"""Share of a joint's range from which a thing is wide open: the least to which doors and drawers are opened."""
DEFAULT_DOF = 1.0
"""Degrees of freedom that a contact constrains if nothing is stated: a plane stops motion in one direction."""
ON, IN, AT = "supports", "in_or_above", "touches"
"""The relations that say where a thing is: its support, the thing that it is in or above, and the peg that it touches."""
FLAT = 0.25
"""Largest ratio of height to shorter side of a flat thing: a plate has 0.13, a lying carton 0.4 and more."""
LIFTED = 0.002
"""Least gap between a gripped thing and its support at which the thing counts as lifted [m]."""
STANDS_WITHIN = 0.005
"""Largest gap between a thing's lowest point and the top of its support [m]."""


def is_effector(_scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate effector(X) in a symbolic world: X is the robot's effector."""
    return entity == EFFECTOR


def is_thing(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate thing(X) in a symbolic world."""
    return entity in scene.types and entity == thing_of(entity)


def is_flat(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate flat(Thing) in a symbolic world: a movable thing is too low for fingers to grip it from the side."""
    thing = scene.world.thing(entity) if is_thing(scene, entity) else None
    return thing is not None and thing.movable and bool(thing.geoms) and low(np.ptp(corners(thing, thing.pose), axis=0))


def low(size: Floats) -> bool:
    """Check whether a thing of some length, width and height (3,) [m] is too low for fingers to grip it from
    the side."""
    return float(size[2]) <= FLAT * float(min(size[:2]))


def is_a(scene: SymbolicWorld, entity: str, class_: str) -> bool:
    """Evaluate isa(X, Class) in a symbolic world."""
    return scene.taxonomy.is_a(HAND, class_) if entity == EFFECTOR else scene.is_a(entity, class_)


def on_joint(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate on_joint(Thing) in a symbolic world."""
    return is_thing(scene, entity) and scene.world.thing(entity).joint is not None


def has(scene: SymbolicWorld, entity: str, class_: str) -> bool:
    """Evaluate has(X, Class) in a symbolic world: X is of the class, or a part of X is."""
    return is_a(scene, entity, class_) or scene.has(entity, class_)


def is_part(_scene: SymbolicWorld, thing: str, part: str) -> bool:
    """Evaluate part(Thing, Part) in a symbolic world: the second is a part of the first."""
    return thing_of(part) == thing != part


def in_chain(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate chain(X) in a symbolic world: the hand, its payload, and the payload's parts."""
    return thing_of(entity) in {EFFECTOR, *scene.held}


def constrained_dof(scene: SymbolicWorld, thing: str, _other: str) -> float:
    """Evaluate constrained_dof(Thing, Other): the most degrees of freedom that Thing or a feature of it
    constrains, going by their classes."""
    features = scene.world.thing(thing).features if thing in scene.types and thing == thing_of(thing) else ()
    classes = [scene.types.get(thing, ""), *(f.type for f in features)]
    said = (f for c in classes for f in scene.taxonomy.fillers(c, "cram:constrainedDof"))
    return max((float(f) for f in said), default=DEFAULT_DOF)


def _touching(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    """Contacts at the start: a hanging thing with hanger and peg, a standing one with its support."""
    for thing, below in _carried(scene):
        peg = scene.world.thing(thing_of(below)).feature(PEG)
        parts = (thing_of(below), str(EntityName(thing_of(below), peg.name)) if peg else below) if _hanger(thing, scene) else (below,)
        yield from ((thing.name, part) for part in parts)


def _supporting(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    yield from ((thing_of(below), thing.name) for thing, below in _carried(scene))


@remembered
def _carried(scene: SymbolicWorld) -> tuple[tuple[Thing, str], ...]:
    """Carried things, each with its carrier: a hanger, a container on a joint, such as a drawer, or a support."""
    found = list[tuple[Thing, str]]()
    inside, boxes = {t.name: c.name for t, c in _contained(scene) if c.joint is not None}, _tops(scene)
    for thing in scene.world.things:
        below = _hanger(thing, scene) or inside.get(thing.name)
        if below is None and thing.name == scene.in_hand:
            below = _stood_on(thing, scene)
        elif below is None and not thing.furniture:
            below = _stacked(thing, scene, boxes) or _below(thing, scene)
        if below is not None:
            found.append((thing, below))
    return tuple(found)


def _contained(scene: SymbolicWorld) -> Iterator[tuple[Thing, Thing]]:
    """Pairs of a thing and a container whose cavity holds the thing's middle."""
    hollow = [(t, f) for t in scene.world.things for f in t.features if f.type == CAVITY]
    for thing in scene.world.things:
        for container, cavity in hollow:
            if not thing.furniture and thing.name != container.name:
                point = vector3((container.pose * cavity.pose).inverse().apply(thing.pose.position))
                if in_cavity(point, cavity.size, below=SUNK):
                    yield thing, container


def _tops(scene: SymbolicWorld) -> tuple[list[str], Floats, Floats]:
    """Things that can be moved, and the lowest and the highest corners (n, 3) of the boxes around them [m]."""
    movable = [t for t in scene.world.things if not t.furniture and t.geoms]
    points = [corners(t, t.pose) for t in movable]
    lows, highs = ([getattr(p, bound)(axis=0) for p in points] for bound in ("min", "max"))
    return [t.name for t in movable], np.reshape(lows, (-1, 3)), np.reshape(highs, (-1, 3))


def _stacked(thing: Thing, scene: SymbolicWorld, boxes: tuple[list[str], Floats, Floats]) -> str | None:
    """Movable thing that another thing stands on or leans on; None without one."""
    names, lows, highs = boxes
    if thing.name not in names:
        return None
    low, high = (bounds[names.index(thing.name)] for bounds in (lows, highs))
    around = (lows[:, :2] <= high[:2]).all(axis=1) & (low[:2] <= highs[:, :2]).all(axis=1) & (lows[:, 2] <= low[2])
    below = [scene.world.thing(n) for n, near in zip(names, around, strict=True) if near and n != thing.name]
    height, owner = resting_height(thing, thing.pose, [(b, b.pose) for b in below])
    if abs(low[2] - height) < STANDS_WITHIN:
        return owner
    if (off := _off_furniture(thing, float(low[2]), scene)) < STANDS_WITHIN:
        return _leans_on(thing, below, off - LIFTED)
    upright = stood_up(thing, thing.pose) is thing.pose
    return _leans_on(thing, [b for b in below if _is_over(thing, b)] if upright else below)


def _stood_on(thing: Thing, scene: SymbolicWorld) -> str | None:
    """Return the support of a gripped thing that was not lifted from it yet; None if the thing was lifted."""
    height, owner = resting_height(thing, thing.pose, [(t, t.pose) for t in scene.world.things if t.name != thing.name])
    return owner if abs(lowest(thing, thing.pose) + thing.pose.position[2] - height) < LIFTED else None


def _leans_on(thing: Thing, below: list[Thing], within: float = STANDS_WITHIN) -> str | None:
    """Support of a thing that stands on no surface: the nearest thing below it, if within a distance [m]."""
    found = min(((abs(room_under(thing, thing.pose, b, b.pose)), b.name) for b in below), default=(math.inf, ""))
    return found[1] if found[0] < within else None


def _is_over(thing: Thing, other: Thing) -> bool:
    """Whether a thing's centre of mass is over another, seen from above."""
    outline = shapely.MultiPoint(corners(other, other.pose)[:, :2]).convex_hull
    return bool(outline.covers(shapely.Point(thing.pose.apply(centre_of_mass(thing))[:2])))


def _off_furniture(thing: Thing, low: float, scene: SymbolicWorld) -> float:
    """Height of the lowest point of a thing over a surface of furniture [m]."""
    fixed = [(t, t.pose) for t in scene.world.things if not t.movable and t.joint is None]
    return abs(low - resting_height(thing, thing.pose, fixed)[0])


def _hanger(thing: Thing, scene: SymbolicWorld) -> str | None:
    return next((o for p, s, o in scene.relations if (p, s) == ("hangs_on", thing.name)), None)


def _below(thing: Thing, scene: SymbolicWorld) -> str | None:
    """The fixed thing with the highest surface under a thing; None where there is none."""
    found = []
    for other in scene.world.things:
        for feature in other.features:
            if other.movable or other.joint is not None or feature.type != SURFACE:
                continue
            x, y, z = (other.pose * feature.pose).inverse().apply(thing.pose.position)
            size = feature.size
            if abs(x) <= size.get("width", 0.0) / 2 and abs(y) <= size.get("depth", 0.0) / 2 and z >= -SUNK:
                found.append((float(z), other.name))
    return min(found)[1] if found else None


def _lying_in(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    yield from ((thing.name, container.name) for thing, container in _contained(scene))


def _holding(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    yield from ((thing.name, contents(thing.name)) for thing in scene.filled())


def _closed(scene: SymbolicWorld) -> Iterator[tuple[str]]:
    yield from ((thing.name,) for thing, share in _joints(scene) if share < CLOSED)


def _open(scene: SymbolicWorld) -> Iterator[tuple[str]]:
    yield from ((thing.name,) for thing, share in _joints(scene) if share >= CLOSED)


def _wide(scene: SymbolicWorld) -> Iterator[tuple[str]]:
    yield from ((thing.name,) for thing, share in _joints(scene) if share >= WIDE)


def _joints(scene: SymbolicWorld) -> Iterator[tuple[Thing, float]]:
    """Things with a joint, and their opening as a share of its range."""
    for thing in scene.world.things:
        if (joint := thing.joint) is not None and _hanger(thing, scene) is None:
            yield thing, joint.opening(joint.value)


def _two_in_hand(_scene: SymbolicWorld, fact: Fact, other: Fact) -> bool:
    """Whether two facts say that one hand holds two things."""
    return fact[0] == other[0] and fact[1] == other[1] and fact[2] != other[2]


def _two_places(scene: SymbolicWorld, fact: Fact, other: Fact) -> bool:
    """Whether two facts put one thing at two fixed places that are too far apart for it to be at both.

    A thing that lies or hangs on both may bridge a gap up to its length; one that is in a place bridges none.
    """
    one, two = _put(scene, fact), _put(scene, other)
    if one is None or two is None or one[0] != two[0] or one[1] == two[1]:
        return False
    thing, *places = (scene.world.thing(n) for n in (one[0], one[1], two[1]))
    if any(p.movable or p.joint is not None or not p.geoms for p in places) or not thing.geoms:
        return False
    (low, high), (lowest, highest) = (_outline(p) for p in places)
    gap = float(np.linalg.norm(np.maximum(np.maximum(low - highest, lowest - high), 0.0)))
    carried = IN not in (fact[0], other[0])
    length = float(np.linalg.norm(np.ptp(corners(thing, thing.pose), axis=0)))
    return gap > (length if carried else 0.0)


def _put(scene: SymbolicWorld, fact: Fact) -> tuple[str, str] | None:
    """The thing and the place of a fact that says where something stands, lies or hangs."""
    relation, first, second = (*fact, "", "")[:3]
    if relation == ON:
        return second, thing_of(first)
    if relation == IN:
        return first, thing_of(second)
    on_peg = relation == AT and thing_of(second) != second and scene.is_a(second, PEG)
    return (first, thing_of(second)) if on_peg and first == thing_of(first) else None


def _outline(thing: Thing) -> tuple[Floats, Floats]:
    """Lowest and highest x and y of a thing in the world [m]."""
    points = corners(thing, thing.pose)[:, :2]
    return points.min(axis=0), points.max(axis=0)


GRASPS = Fluent(in_hand=True, implies=("touches",), contrary=_two_in_hand, phrases=goal_phrases.HELD)
SUPPORTS = Fluent(
    implies=("touches",), undoes=("touches",), carrier=0, contrary=_two_places, initial=_supporting,
    phrases=goal_phrases.ON_OR_OFF,
)  # fmt: skip
TOUCHES = Fluent(
    symmetric=True, of_wholes=True, by_moving=True, implies_when_carried=("supports",), contrary=_two_places,
    initial=_touching,
)  # fmt: skip
"""Relation of touching: a held thing that is brought into contact with another thing is supported by that thing."""
COLLIDES = Fluent(denial=(("touches", EFFECTOR, None),))
"""Relation of colliding: a goal that nothing collides asks that the hand touches nothing."""
CONTAINS = Fluent(
    of_contents=True, initial=_holding, phrases=goal_phrases.POURED
)
IN_OR_ABOVE = Fluent(initial=_lying_in, carrier=1, contrary=_two_places, phrases=goal_phrases.IN_PLACE)
JOINT_OPEN = Fluent(
    excludes=("joint_closed",), initial=_open,
    phrases=goal_phrases.OPENED,
)  # fmt: skip
JOINT_WIDE = Fluent(implies=("joint_open",), initial=_wide)
JOINT_CLOSED = Fluent(
    excludes=("joint_open",), initial=_closed,
    phrases=goal_phrases.SHUT,
)
