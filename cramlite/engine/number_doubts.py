"""Numbers of a scenario that are possible, but probably in another unit: positions, angles, sizes and masses."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from ..model.world.thing_boxes import around, box

if TYPE_CHECKING:
    from ..model.robot import Robot
    from ..model.world.thing import Thing
    from ..model.world.world import World
    from ..scenario.pose_spec import PoseSpec
    from ..scenario.scenario import Scenario

FAR = 20.0
"""Position, or size of a fixed thing, above which the number was probably given in millimetres [m]: the largest shipped world is 8 m
long."""
LONG = 5.0
"""Size of a loose thing above which the number was probably given in millimetres [m]. No arm here reaches half as far."""
TIMES = 10.0
"""Multiple of the arm's payload above which a mass was probably given in grams."""


def number_doubts(scenario: Scenario, world: World, robot: Robot) -> Iterator[str]:
    """Generate warnings about a scenario's numbers, each with file and line."""
    own = {spec.name for spec in scenario.spec.things}
    things = [t for t in world.things if t.name in own]
    yield from _poses(scenario)
    yield from doubted_sizes(scenario, things)
    yield from _masses(scenario, things, robot)


def doubted_sizes(scenario: Scenario, things: Iterable[Thing]) -> Iterator[str]:
    """Generate warnings about things that are too large for their numbers to be metres, each with file and line."""
    for thing in things:
        low, high = around([box(g.pose, g) for g in thing.geoms] or [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))])
        size = max(b - a for a, b in zip(low, high, strict=True))
        if size > (FAR if thing.furniture else LONG):
            said = f"'{thing.name}' is {size:.4g} m long; write '{size:.4g} mm' if millimetres are meant"
            yield f"{scenario.where_thing(thing.name)}: {said}"


def _masses(scenario: Scenario, things: Iterable[Thing], robot: Robot) -> Iterator[str]:
    for thing in things:
        if thing.mass is not None and thing.joint is None and thing.mass > TIMES * robot.payload:
            said = f"'{thing.name}' weighs {thing.mass:g} kg, and '{robot.type}' carries {robot.payload:g} kg"
            yield f"{scenario.where_thing(thing.name)}: {said}; write '{thing.mass:g} g' if grams are meant"


def _poses(scenario: Scenario) -> Iterator[str]:
    spec = scenario.spec
    yield from _pose(scenario, spec.robot.at, "robot", "at")
    for k, thing in enumerate(spec.things):
        if thing.at is not None:
            yield from _pose(scenario, thing.at, "things", k, "at")
    if spec.camera is not None:
        yield from _pose(scenario, spec.camera.at, "camera", "at")


def _pose(scenario: Scenario, pose: PoseSpec, *place: str | int) -> Iterator[str]:
    for turn in ("roll", "pitch", "yaw"):
        value = getattr(pose, turn)
        if abs(value) > 2 * math.pi + 1e-6:
            yield f"{scenario.where(*place, turn)}: '{turn}' is {value:g} rad, more than a turn; write '{value:g} deg' if degrees are meant"
    for value in pose.position:
        if abs(value) > FAR:
            yield f"{scenario.where(*place, 'position')}: {value:g} m is far away; write '{value:g} mm' if millimetres are meant"
            return
