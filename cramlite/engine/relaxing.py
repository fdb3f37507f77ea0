"""Remedies for an unsolvable scenario: the smallest declared changes that make it solvable.

The changes are: the robot's base nearer to a thing that the goal or the tasks name, and another thing further away from such a one, each in
steps of 20 mm; and a gripper that opens wider, in steps of 10 %, where such a thing is wider than it opens. A change is told only if a
program was proven with it, and if with one step less none was.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import copy
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.geometry import Pose, Vector3
from ..model.wider_gripper import with_wider_gripper
from ..model.world.thing_boxes import extents
from ..planning.search.budget import Budget, budget_of
from ..planning.spoken_goals import spoken
from ..planning.task_goals import Goal
from ..planning.trace import Trace

if TYPE_CHECKING:
    from ..model.robot import Robot
    from ..scenario.scenario import Scenario
    from .engine import Engine
    from .setting import Setting

STEP = 0.02
"""Step by which a scenario is changed [m]."""
MOST = 32
"""Largest number of steps by which a scenario is changed: 0.64 m."""
CLOSE = 0.35
"""Distance from a named thing within which another thing may be in its way [m]."""


WIDER, WIDEST = 0.1, 10
"""Step by which a gripper is made wider, as a share of its largest opening, and the largest number of such steps."""


class WiderGripper(Value):
    """Gripper of the robot that opens wider, by an amount that is still open."""

    says: str
    most = WIDEST
    does = "made"

    def of(self, setting: Setting, steps: int) -> Setting:
        """Return the setting with a robot whose gripper opens wider by a number of steps.

        Raises:
            UserError: there is no model of such a robot.
        """
        robot = setting.robot
        wider = with_wider_gripper(robot, WIDER * steps * robot.gripper.opening[1])
        if wider is None:
            raise UserError(f"The gripper of '{robot.type}' has no wider model.")
        return replace(setting, robot=wider)

    def amount(self, steps: int) -> str:
        """Return the change of a number of steps in words."""
        return f"{100 * WIDER * steps:.0f} %"


class Change(Value):
    """Displacement of the robot's base or of a thing in one direction, by an amount that is still open.

    Args:
        says: what is changed, without how much: "the base of 'arm' nearer to 'cup'".
        way: direction in which it is, a unit vector in the world.
        thing: that is moved; "" for the robot's base.
    """

    says: str
    way: Vector3
    thing: str = ""
    most = MOST
    does = "brought"

    def amount(self, steps: int) -> str:
        """Return the displacement of a number of steps in words."""
        return f"{1000 * STEP * steps:.0f} mm"

    def of(self, setting: Setting, steps: int) -> Setting:
        """Return the setting in which the thing, or else the robot's base, is displaced by a number of steps of ``STEP`` metres."""
        x, y, z = (STEP * steps * v for v in self.way)
        off = Pose((x, y, z))
        world = setting.world
        if self.thing:
            return replace(setting, world=world.moved({self.thing: off * world.thing(self.thing).pose}))
        mount = replace(world.robots[0], base=off * world.robots[0].base)
        return replace(setting, world=replace(world, robots=(mount, *world.robots[1:])))


class Relaxation(Value):
    """Smallest amount of a change that makes a scenario solvable.

    Args:
        change: what is changed.
        steps: how many of its steps.
    """

    change: Change | WiderGripper
    steps: int

    def __str__(self) -> str:
        """Describe the change that makes the scenario solvable, and the next smaller one, with which no program was proven."""
        change, steps = self.change, self.steps
        return f"{change.does} {change.says} by {change.amount(steps)}; by {change.amount(steps - 1)} nothing was proven"


def relaxations(scenario: Scenario, setting: Setting, engine: Engine, say: Callable[[str], None] = lambda _: None) -> list[Relaxation]:
    """Return changes that make a scenario solvable, the smallest first.

    For each, resolving has shown that it suffices, and that one step less fails.

    Args:
        say: is told each attempt.
    """
    setting, budget, engine = replace(setting, doubts=replace(setting.doubts, twins=0)), budget_of(scenario), engine.suited(scenario)
    found = list[Relaxation]()
    if scenario.spec.goal is not None:  # what "the left one" means does not change when things are moved
        goal = spoken(Goal(scenario.spec.goal), setting.symbolic(engine.knowledge.taxonomy), engine.knowledge)
        scenario = scenario.with_goal(goal.says) if goal.says != scenario.spec.goal else scenario
    for change in changes(scenario, setting):
        most = min((r.steps for r in found), default=change.most)
        steps = _smallest(lambda k, c=change: _solves(c, k, scenario, setting, engine, budget, say), most)  # type: ignore[misc]
        found += [Relaxation(change, steps)] if steps else []
    return sorted(found, key=lambda r: r.steps)


def changes(scenario: Scenario, setting: Setting) -> Iterator[Change | WiderGripper]:
    """Generate the changes that could make a scenario solvable: first the robot's base nearer to a thing,
    then a thing farther from another, then a wider gripper."""
    world, base = setting.world, setting.world.robots[0].base
    said = " ".join(map(str, (*(scenario.spec.goal or ()), *(scenario.spec.tasks or ()), scenario.spec.designator or "")))
    named = [t for t in world.things if t.name in said.replace("/", " ").replace("'", " ").replace(",", " ").split()]
    for thing in named:
        if way := _level(np.subtract(thing.pose.position, base.position)):
            yield Change(f"the base of '{world.robots[0].name}' nearer to '{thing.name}'", way)
    for other in (t for t in world.things if not t.furniture and t not in named):
        near = min(named, key=lambda t: math.dist(t.pose.position, other.pose.position), default=None)
        close = near is not None and math.dist(near.pose.position, other.pose.position) <= CLOSE
        way = _level(np.subtract(other.pose.position, near.pose.position)) if near is not None and close else None
        if near is not None and way:
            yield Change(f"'{other.name}' further from '{near.name}'", way, other.name)
    opening = setting.robot.gripper.opening[1]
    wide = any(t.movable and t.geoms and min(extents(t)[:2]) > opening for t in named)
    if wide and with_wider_gripper(setting.robot, WIDER) is not None:
        yield WiderGripper(f"the gripper of '{world.robots[0].name}' wider")


def _smallest(solves: Callable[[int], bool], most: int) -> int:
    """Return by how many steps at least a scenario must be changed to be solvable; 0 if ``most`` steps are too few.

    The number is found by doubling and halving.
    """
    low, high = 0, 1
    while high <= most and not solves(high):
        low, high = high, 2 * high
    if high > most:
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if solves(middle) else (middle, high)
    return high


def _solves(
    change: Change | WiderGripper, steps: int, scenario: Scenario, setting: Setting, engine: Engine, budget: Budget,
    say: Callable[[str], None],
) -> bool:  # fmt: skip
    """Check whether a program can be proven after a change of ``steps`` steps."""
    try:
        changed = change.of(setting, steps)
        engine = engine if changed.robot is setting.robot else _with_robot(engine, changed.robot)
        engine.knowledge.simulator.check(changed.world, engine.knowledge.robots_of(changed.world))
        solved = next(engine.resolve(scenario, setting=changed, budget=budget, trace=Trace()), None) is not None
    except UserError:  # it reaches into something there
        solved = False
    say(f"{change.says} by {change.amount(steps)}: {'solved' if solved else 'nothing was proven'}")
    return solved


def _with_robot(engine: Engine, robot: Robot) -> Engine:
    """Return an engine with another model for a robot's type."""
    changed = copy(engine)
    changed.knowledge = engine.knowledge.with_robot(robot)
    return changed


def _level(way: object) -> Vector3 | None:
    """Return the horizontal direction of a vector as a unit vector; None for a vertical vector."""
    x, y, _ = np.asarray(way, dtype=float).tolist()
    length = math.hypot(x, y)
    return (x / length, y / length, 0.0) if length > 1e-6 else None
