"""Fluents, static definitions and goal phrases of the shipped predicates: what planning needs of them."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite.model import EntityName, Thing, thing_of
from cramlite.plugin import EFFECTOR, Fluent, GoalCondition, GoalPhrase, Pattern, SymbolicWorld, UserError, contents

PEG, SURFACE = "vrps:Peg", "vrps:SurfaceFeature"
HAND = "soma:Gripper"
"""What the hand that acts is."""
CLOSED = 0.1
"""Share of a joint's range below which a thing is closed at the start."""
DEFAULT_DOF = 1.0
"""What a contact constrains if nothing is said: a plane stops motion in one direction."""
STANDS = ("is", "hangs", "stands", "lies")


def is_effector(_scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate effector(X) in a symbolic world."""
    return entity == EFFECTOR


def is_thing(scene: SymbolicWorld, entity: str) -> bool:
    """Evaluate thing(X) in a symbolic world."""
    return entity in scene.types and entity == thing_of(entity)


def is_a(scene: SymbolicWorld, entity: str, class_: str) -> bool:
    """Evaluate isa(X, Class) in a symbolic world."""
    return scene.taxonomy.is_a(HAND, class_) if entity == EFFECTOR else scene.is_a(entity, class_)


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
    classes = (class_ for entity, class_ in scene.types.items() if thing in (entity, thing_of(entity)))
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
    """Things that hang or stand, with what they hang from or stand on."""
    for thing in scene.world.things:
        below = _hanger(thing, scene) or (_below(thing, scene) if thing.movable and thing.joint is None else None)
        if below is not None:
            yield thing, below


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
            if abs(x) <= size.get("width", 0.0) / 2 and abs(y) <= size.get("depth", 0.0) / 2 and z >= 0.0:
                found.append((float(z), other.name))
    return min(found)[1] if found else None


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


def _let_go(thing: str) -> frozenset[Pattern]:
    """Nobody holds it, and the hand has left it."""
    return frozenset({("grasps", None, thing), ("touches", EFFECTOR, thing)})


def _held(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(needs=frozenset({("grasps", EFFECTOR, thing)}))


def _on(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """On a thing with a peg it hangs."""
    peg = scene.world.thing(place).feature(PEG)
    there = ("touches", thing, str(EntityName(place, peg.name))) if peg else ("supports", place, thing)
    return GoalCondition(frozenset({there}), _let_go(thing), spot=peg is None)


def _off(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """It may be in the hand."""
    return GoalCondition(without=frozenset(_on(scene, thing, place).needs))


def _in(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    on_peg = scene.world.thing(place).feature(PEG) is not None
    return GoalCondition(frozenset({("in_or_above", thing, place)}), _let_go(thing), spot=not on_peg)


def _poured_into(scene: SymbolicWorld, source: str, destination: str) -> GoalCondition:
    """The first vessel is lifted: the rule of pouring does not ask for it, but nobody tilts what stands."""
    if source not in {t.name for t in scene.filled()}:
        raise UserError(f"'{source}' holds nothing that could be poured.")
    return GoalCondition(frozenset({("contains", destination, contents(source))}), frozenset({("supports", None, source)}))


def _is_open(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_open", thing)}), frozenset({("touches", EFFECTOR, thing)}))


def _is_closed(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_closed", thing)}), frozenset({("touches", EFFECTOR, thing)}))


GRASPS = Fluent(in_hand=True, implies=("touches",), phrases=(GoalPhrase("THING held", _held),))
SUPPORTS = Fluent(
    implies=("touches",), undoes=("touches",), initial=_supporting,
    phrases=(GoalPhrase("THING on PLACE", _on, STANDS), GoalPhrase("THING off PLACE", _off, STANDS)),
)  # fmt: skip
TOUCHES = Fluent(
    symmetric=True, of_wholes=True, by_moving=True, implies_when_carried=("supports",), initial=_touching
)
"""What is brought to touch something while it is in the hand is supported by it."""
COLLIDES = Fluent(denial=(("touches", EFFECTOR, None),))
"""That nothing collides means that the hand touches nothing."""
CONTAINS = Fluent(
    of_contents=True, initial=_holding, phrases=(GoalPhrase("VESSEL poured into VESSEL", _poured_into),)
)
IN_OR_ABOVE = Fluent(phrases=(GoalPhrase("THING in PLACE", _in, STANDS),))
JOINT_OPEN = Fluent(initial=_open, phrases=(GoalPhrase("THING open", _is_open, ("is", "stands")),))
JOINT_CLOSED = Fluent(initial=_closed, phrases=(GoalPhrase("THING closed", _is_closed, ("is", "stands")),))
