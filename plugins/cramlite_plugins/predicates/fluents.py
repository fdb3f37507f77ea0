"""Fluents, static definitions and goal phrases of the shipped predicates: what planning needs of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np
from msgspec.structs import replace

from cramlite.model import EntityName, Floats, Thing, thing_of
from cramlite.plugin import (
    EFFECTOR,
    Bound,
    Fact,
    Fluent,
    GoalCondition,
    GoalPhrase,
    Manner,
    Pattern,
    SymbolicWorld,
    UserError,
    contents,
    nearest,
)

from ..shapes.bounds import corners
from ..shapes.nesting import room_under
from ..shapes.standing_up import stood_up
from ..shapes.surfaces import SUNK, resting_height

PEG, SURFACE, CAVITY = "vrps:Peg", "vrps:SurfaceFeature", "cram:Cavity"
REGIONS = (SURFACE, CAVITY)
"""Features that a goal may name as a place of their own."""
HAND = "soma:Gripper"
"""What the hand that acts is."""
CLOSED = 0.1
"""Share of a joint's range below which a thing is closed at the start."""
DEFAULT_DOF = 1.0
"""What a contact constrains if nothing is said: a plane stops motion in one direction."""
ON, IN, AT = "supports", "in_or_above", "touches"
"""The relations that say where a thing is: what carries it, what it is over, and the peg that it touches."""
OPEN = 0.2
"""Share of a joint's range from which a thing is open: the rule of opening asks for as much."""
FLAT = 0.25
"""Height of what is flat, as a share of its shorter side: a plate has 0.13, a carton that lies 0.4 and more."""
EXACT = 0.05
"""Share of a joint's range by which what was opened by an amount may be off: 10 mm of a drawer's 200."""
CONTROL = "cram:Control"
"""What can be turned on and off."""
STANDS_WITHIN = 0.005
"""Between a thing's lowest point and the top of what it stands on [m]."""
STANDS = ("is", "hangs", "stands", "lies")


def is_effector(_scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate effector(X) in a symbolic world."""
    return entity == EFFECTOR


def is_thing(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate thing(X) in a symbolic world."""
    return entity in scene.types and entity == thing_of(entity)


def is_flat(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate flat(Thing) in a symbolic world: of what can be moved."""
    thing = scene.world.thing(entity) if is_thing(scene, entity) else None
    return thing is not None and thing.movable and bool(thing.geoms) and low(np.ptp(corners(thing, thing.pose), axis=0))


def low(size: Floats) -> bool:
    """Check whether sides (3,) [m] are those of something flat: so low fingers get no hold of it from the side."""
    return float(size[2]) <= FLAT * float(min(size[:2]))


def is_a(scene: SymbolicWorld, entity: str, class_: str) -> bool:
    """Evaluate isa(X, Class) in a symbolic world."""
    return scene.taxonomy.is_a(HAND, class_) if entity == EFFECTOR else scene.is_a(entity, class_)


def on_joint(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate on_joint(Thing) in a symbolic world."""
    return is_thing(scene, entity) and scene.world.thing(entity).joint is not None


def has(scene: SymbolicWorld, entity: str, class_: str) -> bool:
    """Evaluate has(X, Class) in a symbolic world: it is one, or a part of it is."""
    return is_a(scene, entity, class_) or scene.has(entity, class_)


def is_part(_scene: SymbolicWorld, thing: str, part: str) -> bool:
    """Evaluate part(Thing, Part) in a symbolic world."""
    return thing_of(part) == thing != part


def in_chain(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate chain(X) in a symbolic world: the hand, what it holds, and the parts of that."""
    return thing_of(entity) in {EFFECTOR, *scene.held}


def constrained_dof(scene: SymbolicWorld, thing: str, _other: str) -> float:
    """Evaluate constrained_dof(Thing, Other): the most degrees of freedom that any part of the thing takes, by its class."""
    features = scene.world.thing(thing).features if thing in scene.types and thing == thing_of(thing) else ()
    classes = [scene.types.get(thing, ""), *(f.type for f in features)]
    said = (f for c in classes for f in scene.taxonomy.fillers(c, "cram:constrainedDof"))
    return max((float(f) for f in said), default=DEFAULT_DOF)


def _touching(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    """What hangs touches the hanger and its peg; what stands touches what is under it."""
    for thing, below in _carried(scene):
        peg = scene.world.thing(thing_of(below)).feature(PEG)
        parts = (thing_of(below), str(EntityName(thing_of(below), peg.name)) if peg else below) if _hanger(thing, scene) else (below,)
        yield from ((thing.name, part) for part in parts)


def _supporting(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    yield from ((thing_of(below), thing.name) for thing, below in _carried(scene))


def _carried(scene: SymbolicWorld) -> Iterator[tuple[Thing, str]]:
    """Things that hang, lie in what moves on a joint, or stand, with what they hang from, lie in or stand on."""
    inside, boxes = {t.name: c.name for t, c in _contained(scene) if c.joint is not None}, _tops(scene)
    for thing in scene.world.things:
        below = _hanger(thing, scene) or inside.get(thing.name)
        if below is None and thing.movable and thing.joint is None:
            below = _stacked(thing, scene, boxes) or _below(thing, scene)
        if below is not None:
            yield thing, below


def _contained(scene: SymbolicWorld) -> Iterator[tuple[Thing, Thing]]:
    """Things whose middle is in the cavity of another, with that one."""
    hollow = [(t, f) for t in scene.world.things for f in t.features if f.type == CAVITY]
    for thing in scene.world.things:
        for container, cavity in hollow:
            if thing.movable and thing.joint is None and thing.name != container.name:
                x, y, z = (container.pose * cavity.pose).inverse().apply(thing.pose.position).tolist()
                if _within((x, y, z), cavity.size):
                    yield thing, container


def _within(point: tuple[float, float, float], size: Mapping[str, float]) -> bool:
    """Whether a point is in a cavity, whose frame is in the middle of its opening, z out of it."""
    x, y, z = point
    if "height" not in size or not {"radius", "width"} & set(size):
        return False
    beside = math.hypot(x, y) > size["radius"] if "radius" in size else abs(x) > size["width"] / 2 or abs(y) > size["depth"] / 2
    return not beside and -size["height"] <= z <= 0.0


def _tops(scene: SymbolicWorld) -> list[tuple[str, Floats, Floats]]:
    """Things that can be moved, with the lowest and the highest corner of the box around each [m]."""
    movable = [t for t in scene.world.things if t.movable and t.joint is None and t.geoms]
    points = [corners(t, t.pose) for t in movable]
    return [(t.name, p.min(axis=0), p.max(axis=0)) for t, p in zip(movable, points, strict=True)]


def _stacked(thing: Thing, scene: SymbolicWorld, boxes: list[tuple[str, Floats, Floats]]) -> str | None:
    """The thing that can be moved itself, and whose surface is what another stands on, or that it leans on; None where there is none."""
    (low, high) = next(((low, high) for name, low, high in boxes if name == thing.name), (None, None))
    if low is None or high is None:
        return None
    around = (n for n, a, b in boxes if n != thing.name and all(a[:2] <= high[:2]) and all(low[:2] <= b[:2]) and a[2] <= low[2])
    below = [scene.world.thing(n) for n in around]
    height, owner = resting_height(thing, thing.pose, [(b, b.pose) for b in below])
    if abs(low[2] - height) < STANDS_WITHIN:
        return owner
    upright = stood_up(thing, thing.pose) is thing.pose
    return None if upright or _stands(thing, float(low[2]), scene) else _leans_on(thing, below)


def _leans_on(thing: Thing, below: list[Thing]) -> str | None:
    """What a thing that stands on no surface would meet if it were let down: the nearest, if that is as good as touched."""
    found = min(((abs(room_under(thing, thing.pose, b, b.pose)), b.name) for b in below), default=(math.inf, ""))
    return found[1] if found[0] < STANDS_WITHIN else None


def _stands(thing: Thing, low: float, scene: SymbolicWorld) -> bool:
    """Whether the lowest point of a thing is on a surface of what cannot be moved."""
    fixed = [(t, t.pose) for t in scene.world.things if not t.movable and t.joint is None]
    return abs(low - resting_height(thing, thing.pose, fixed)[0]) < STANDS_WITHIN


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


def _joints(scene: SymbolicWorld) -> Iterator[tuple[Thing, float]]:
    """Things with a joint, and how far it is open as a share of its range."""
    for thing in scene.world.things:
        if (joint := thing.joint) is not None and _hanger(thing, scene) is None:
            yield thing, (joint.value - joint.lower) / (joint.upper - joint.lower)


def let_go(thing: str) -> frozenset[Pattern]:
    """Nobody holds it, and the hand has left it."""
    return frozenset({("grasps", None, thing), ("touches", EFFECTOR, thing)})


def _held(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(needs=frozenset({("grasps", EFFECTOR, thing)}))


def _on(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """On a thing with a peg it hangs; of a cavity, on is in."""
    if place != thing_of(place):
        return _at_region(scene, thing, place)
    peg = scene.world.thing(place).feature(PEG)
    there = ("touches", thing, str(EntityName(place, peg.name))) if peg else ("supports", place, thing)
    return GoalCondition(frozenset({there}), let_go(thing), spot=peg is None)


def _off(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """It may be in the hand."""
    if place != thing_of(place):
        raise UserError(f"'off' is said of a whole thing: '{thing_of(place)}'.")
    return GoalCondition(without=frozenset(_on(scene, thing, place).needs))


def _in(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """Over a place is in it for planning; of a container a run must show that it is inside."""
    if place != thing_of(place):
        return _at_region(scene, thing, place)
    on_peg = scene.world.thing(place).feature(PEG) is not None
    hollow = scene.world.thing(place).feature(CAVITY) is not None
    shown = frozenset({("in_cavity", thing, place)} if hollow else ())
    return GoalCondition(frozenset({("in_or_above", thing, place)}), let_go(thing), spot=not on_peg, shown=shown)


def _at_region(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """In a cavity, or on an area of a surface, of a thing that has several: a run must show in which."""
    whole, region = thing_of(place), EntityName.parse(place).part
    features = {f.name: f for f in scene.world.thing(whole).features if f.type in REGIONS}
    if region not in features:
        raise UserError(f"'{place}' is no surface and no cavity that things could be put on or in; {nearest(region, features)}.")
    feature = features[region]
    point = (scene.world.thing(whole).pose * feature.pose).inverse().apply(scene.world.thing(thing).pose.position)
    there = ("in_or_above", thing, whole) if feature.type == CAVITY else ("supports", whole, thing)
    return GoalCondition(
        frozenset({there}), let_go(thing), spot=True, shown=frozenset({("in_region", thing, place)}),
        manner=Manner({"region": region}, holds=in_extent(feature.type, feature.size, point)),
    )  # fmt: skip


def in_extent(type_: str, size: Mapping[str, float], point: Floats) -> bool:
    """Check whether a point, in the frame of a cavity or of a surface, is in the one or over the other; an area that says no height has
    none."""
    x, y, z = map(float, point)
    if type_ == CAVITY:
        return _within((x, y, z), size)
    wide, deep = (size.get(name, 0.0) / 2 for name in ("width", "depth"))
    beside = math.hypot(x, y) > size["radius"] if "radius" in size else abs(x) > wide or abs(y) > deep
    return not beside and -SUNK <= z <= size.get("height", math.inf)


def _poured_into(scene: SymbolicWorld, source: str, destination: str) -> GoalCondition:
    """The first vessel is lifted: the rule of pouring does not ask for it, but nobody tilts what stands."""
    if source not in {t.name for t in scene.filled()}:
        raise UserError(f"'{source}' holds nothing that could be poured.")
    return GoalCondition(frozenset({("contains", destination, contents(source))}), frozenset({("supports", None, source)}))


def _is_open(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_open", thing)}), frozenset({("touches", EFFECTOR, thing)}))


def _is_closed(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_closed", thing)}), frozenset({("touches", EFFECTOR, thing)}))


def _opened_by(scene: SymbolicWorld, thing: str, amount: str) -> GoalCondition:
    """Open by so much of what its joint can; less than what counts as open is no goal, as no task ends there."""
    from cramlite.plugin import parse_quantity  # it loads pydantic

    joint = scene.world.thing(thing).joint
    if joint is None:
        raise UserError(f"'{thing}' has no joint to be opened by.")
    try:
        value = parse_quantity(amount, "length" if joint.kind == "slide" else "angle")
    except ValueError as error:
        raise UserError(f"{error}.") from error
    span = joint.upper - joint.lower
    share, (least, most) = value / span, (_amount(joint.kind, s * span) for s in (OPEN, 1.0))
    if not OPEN <= share <= 1.0:
        raise UserError(f"'{thing}' opens by {most} at most, and is open from {least} on.")
    bound = Bound(("joint_share", thing), share - EXACT, share + EXACT)
    now = (joint.value - joint.lower) / span
    return replace(_is_open(scene, thing), bounds=(bound,), manner=Manner(parameters={"share": share}, holds=abs(now - share) <= EXACT))


def _amount(kind: str, value: float) -> str:
    return f"{1000 * value:.0f} mm" if kind == "slide" else f"{math.degrees(value):.0f} deg"


def _turned(scene: SymbolicWorld, thing: str, on: bool) -> GoalCondition:
    if not scene.is_a(thing, CONTROL):
        raise UserError(f"'{thing}' is no knob and no switch ({CONTROL}) that could be turned on or off.")
    return (_is_open if on else _is_closed)(scene, thing)


def _two_in_hand(_scene: SymbolicWorld, fact: Fact, other: Fact) -> bool:
    """A hand holds one thing."""
    return fact[0] == other[0] and fact[1] == other[1] and fact[2] != other[2]


def _two_places(scene: SymbolicWorld, fact: Fact, other: Fact) -> bool:
    """Nothing is at two places that stand still and apart: over both, or, if it is carried, farther apart than it is long."""
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


GRASPS = Fluent(in_hand=True, implies=("touches",), contrary=_two_in_hand, phrases=(GoalPhrase("THING held", _held),))
SUPPORTS = Fluent(
    implies=("touches",), undoes=("touches",), carrier=0, contrary=_two_places, initial=_supporting,
    phrases=(GoalPhrase("THING on PLACE", _on, STANDS), GoalPhrase("THING off PLACE", _off, STANDS)),
)  # fmt: skip
TOUCHES = Fluent(
    symmetric=True, of_wholes=True, by_moving=True, implies_when_carried=("supports",), contrary=_two_places,
    initial=_touching,
)  # fmt: skip
"""What is brought to touch something while it is in the hand is supported by it."""
COLLIDES = Fluent(denial=(("touches", EFFECTOR, None),))
"""That nothing collides means that the hand touches nothing."""
CONTAINS = Fluent(
    of_contents=True, initial=_holding, phrases=(GoalPhrase("VESSEL poured into VESSEL", _poured_into),)
)
IN_OR_ABOVE = Fluent(initial=_lying_in, carrier=1, contrary=_two_places, phrases=(GoalPhrase("THING in PLACE", _in, STANDS),))
JOINT_OPEN = Fluent(
    excludes=("joint_closed",), initial=_open,
    phrases=(
        GoalPhrase("THING open", _is_open, ("is", "stands")), GoalPhrase("THING open by AMOUNT", _opened_by, ("is", "stands")),
        GoalPhrase("THING turned on", partial(_turned, on=True)),
    ),
)  # fmt: skip
JOINT_CLOSED = Fluent(
    excludes=("joint_open",), initial=_closed,
    phrases=(GoalPhrase("THING closed", _is_closed, ("is", "stands")), GoalPhrase("THING turned off", partial(_turned, on=False))),
)
