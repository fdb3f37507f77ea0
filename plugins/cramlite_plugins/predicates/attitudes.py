"""Orientation predicates, and goals of putting down: upright, upside down, direction of a thing's front."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from cramlite.model import Feature, Floats, Pose
from cramlite.plugin import Fluent, GoalCondition, GoalPhrase, Manner, Phase, Predicate, Row, SymbolicWorld, UserError

from ..shapes.front import front
from .goal_phrases import let_go
from .phase_poses import each, pairs, pose_of

UPRIGHT = math.radians(10.0)
"""Largest angle of an upright thing from the vertical: a thing that stands is within 1 deg, and a can that leans on another is not."""
FACES = math.radians(15.0)
"""Largest angle between a front and the direction to the faced thing, seen from above: a hand that lets go turns things by some degrees."""
OVER = 0.005
"""Distance between two origins, seen from above, below which neither thing faces the other, as one is over the other [m]."""


def all_predicates() -> tuple[Predicate, ...]:
    """Return the predicates on orientation, such as ``stands_upright`` and ``faces``."""
    return (
        Predicate(
            "stands_upright", 1, stands_upright, cost=4, doc="A thing's z axis is within 10 deg of straight up.", fluent=_UPRIGHT
        ),
        Predicate(
            "stands_upside_down", 1, stands_upside_down, cost=4, doc="A thing's z axis is within 10 deg of straight down.",
            fluent=_UPSIDE_DOWN,
        ),
        Predicate(
            "faces", 2, faces, cost=5, doc="Seen from above, a thing's front looks at another within 15 deg.",
            fluent=_FACES,
        ),
    )


def stands_upright(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate stands_upright(Thing): its z axis points up at the end of the phase."""
    return _oriented(phase, name, 1.0)


def stands_upside_down(phase: Phase, name: str | None) -> Iterator[Row]:
    """Evaluate stands_upside_down(Thing): its z axis points down at the end of the phase."""
    return _oriented(phase, name, -1.0)


def _oriented(phase: Phase, name: str | None, way: float) -> Iterator[Row]:
    for one in each(phase, name):
        pose = pose_of(phase, one, phase.end)
        if pose is not None and upward(pose, way):
            yield (one,)


def faces(phase: Phase, name: str | None, other: str | None) -> Iterator[Row]:
    """Evaluate faces(Thing, Other): Thing's front looks at Other's origin at the end of the phase."""
    for one, another in pairs(phase, name, other):
        here, there = pose_of(phase, one, phase.end), pose_of(phase, another, phase.end)
        if here is not None and there is not None and looks_at(_front(phase, one), here, there):
            yield one, another


def _front(phase: Phase, name: str) -> Floats:
    """Direction of a thing's front, in its frame."""
    parts = [e for e in phase.timeline.entities.values() if e.part_of == name]
    return front([Feature(p.name, p.types[0], p.pose) for p in parts if p.types and p.pose is not None])


def _stands_up(scene: SymbolicWorld, thing: str, attitude: str) -> GoalCondition:
    """Goal that a thing stands upright or upside down, reached by putting it down in this attitude."""
    _movable(scene, thing, attitude)
    name = "stands_" + attitude.replace(" ", "_")
    holds = (thing,) in set(_standing(scene, {"upright": 1.0, "upside down": -1.0}[attitude]))
    return GoalCondition(
        shown=frozenset({(name, thing)}), without=let_go(thing), manner=Manner({"attitude": attitude}, holds=holds)
    )


def _faces(scene: SymbolicWorld, thing: str, other: str) -> GoalCondition:
    """Goal that a thing faces another one, reached by putting the thing down with its front towards the other."""
    _movable(scene, thing, "put down so that it faces anything")
    if thing == other:
        raise UserError(f"'{thing}' cannot face itself.")
    return GoalCondition(
        shown=frozenset({("faces", thing, other)}), without=let_go(thing),
        manner=Manner({"facing": other}, holds=(thing, other) in set(_facing(scene))),
    )  # fmt: skip


def _movable(scene: SymbolicWorld, thing: str, what: str) -> None:
    if scene.world.thing(thing).furniture:
        raise UserError(f"'{thing}' cannot be moved, so it cannot be {what}.")


def _standing(scene: SymbolicWorld, way: float) -> Iterator[tuple[str]]:
    """Names of the movable things whose z axis points up (``way`` = 1.0) or down (``way`` = -1.0)."""
    for thing in scene.world.things:
        if not thing.furniture and upward(thing.pose, way):
            yield (thing.name,)


def _facing(scene: SymbolicWorld) -> Iterator[tuple[str, str]]:
    for thing in scene.world.things:
        if not thing.furniture:
            others = (o for o in scene.world.things if o.name != thing.name)
            yield from ((thing.name, o.name) for o in others if looks_at(front(thing.features), thing.pose, o.pose))


def upward(pose: Pose, way: float) -> bool:
    """Check whether a frame's z axis points up (1.0), or down (-1.0), within ``UPRIGHT``."""
    return way * float(pose.rotate((0.0, 0.0, 1.0))[2]) >= math.cos(UPRIGHT)


def looks_at(ahead: Floats, pose: Pose, other: Pose) -> bool:
    """Check whether a thing's front, (3,) in its frame, looks at the origin of another within ``FACES``, seen from above."""
    (x, y, _), to = pose.rotate(ahead), np.subtract(other.position, pose.position)
    if math.hypot(x, y) < math.sin(UPRIGHT) or math.hypot(to[0], to[1]) < OVER:
        return False  # it looks up or down, or the other is over or under it
    return abs(math.remainder(math.atan2(to[1], to[0]) - math.atan2(y, x), 2 * math.pi)) <= FACES


UP = (
    "upright|up|the_right_way_up|the_proper_way_up|the_right_way|on_end|up_right|standing|standing_up|right_side_up|right_way_up|"
    "on_its_base|on_its_feet|the_right_way_round|open_end_up|mouth_up|opening_up|with_the_opening_up|with_its_opening_up|"
    "with_the_open_end_up|with_its_open_end_up|with_the_mouth_up|with_its_mouth_up|with_the_open_side_up|bottom_down|"
    "vertically|in_an_upright_position|with_its_axis_vertical|with_its_long_axis_vertical"
)
DOWN = (
    "upside_down|over|bottom_up|on_its_head|face_down|wrong_way_up|the_wrong_way_up|top_down|bottom_side_up|mouth_down|on_its_rim|"
    "opening_down|with_the_opening_down|with_its_opening_down|with_the_open_end_down|with_its_open_end_down|with_its_bottom_up|"
    "with_the_bottom_up|with_its_mouth_down|with_the_mouth_down"
)
TOWARD = (
    "to_face|towards|toward|facing|face|faces|so_that_it_faces|so_it_faces|to_look_at|until_it_faces|till_it_faces|such_that_it_faces|"
    "so_that_its_front_points_at|such_that_its_front_points_at"
)
"""Words of sentences for how a thing shall stand."""
_UPRIGHT = Fluent(
    excludes=("stands_upside_down",), initial=partial(_standing, way=1.0),
    phrases=(GoalPhrase("THING upright", partial(_stands_up, attitude="upright"), ("is", "stands"), (
        f"stand|put|set|place|turn|make|get|sit|tilt|bring|keep|leave THING {UP}",
        "straighten|straighten_up|stand_up|right|set_up|erect|upright THING")),),
)  # fmt: skip
_UPSIDE_DOWN = Fluent(
    excludes=("stands_upright",), initial=partial(_standing, way=-1.0),
    phrases=(GoalPhrase("THING upside down", partial(_stands_up, attitude="upside down"), ("is", "stands"), (
        f"turn|flip|put|place|set|lay|stand|get|tip|roll|make|keep|leave THING {DOWN}",
        "invert|flip_over|turn_over|flip|upend|turn_upside_down|overturn THING")),),
)  # fmt: skip
_FACES = Fluent(initial=_facing, phrases=(
    GoalPhrase("THING facing THING", _faces, ("is", "stands"), (
        f"turn|rotate|point|orient|orientate|aim|make|twist|spin|swivel THING {TOWARD}|at|to THING",
        f"set|put|place|stand THING {TOWARD} THING")),
))
