"""Queries of OMPL's RRTConnect between joint positions.

OMPL's generator is global to the process, so queries of one process run one after the other. Every decision
depends on counted work: the wall clock only ends a run that is far beyond any normal one.

Source: Kuffner and LaValle, RRT-Connect, ICRA 2000; OMPL (Sucan, Moll, Kavraki, 2012).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from cramlite.model import Value
from cramlite.plugin import checkpoint, stop_asked

from .space import FreeLines, Joints, Space

RANGE = 0.5
"""Longest tree extension [rad]. Of 16 queries in cages 16 were solved with it in 6,000 samples, 15 with
1.0 and 12 with 0.3."""


class Answer(Value):
    """Outcome of one path search: the path, if one was found, and the work spent on it.

    Args:
        points: of a path from the start to one of the goals; None where none was found.
        samples: tree extensions that were spent.
        truncated: whether the wall clock ended it.
    """

    points: tuple[Joints, ...] | None
    samples: int
    truncated: bool = False


_ONE_QUERY = threading.Lock()
"""Lock for path queries, since OMPL's random generator belongs to the process: from the setting of its seed
to the found path one query must have it alone."""
PATIENCE = 0.1
"""Interval at which a thread that waits for another thread's query checks whether it should go on waiting
[s]."""


@contextmanager
def _alone() -> Iterator[None]:
    """Hold the lock that lets one thread at a time query OMPL in this process."""
    while not _ONE_QUERY.acquire(timeout=PATIENCE):
        checkpoint()
    try:
        yield
    finally:
        _ONE_QUERY.release()


def connected(
    scene: Space,
    lines: FreeLines,
    origin: Joints,
    goals: Sequence[Joints],
    box: Sequence[tuple[float, float]],
    seed: int,
    budget: int,
    ends: float,
) -> Answer:
    """Look for a path from a joint position to one of several.

    Args:
        scene: in which positions are free.
        lines: in which the lines between them are.
        box: that is sampled [rad], each joint's.
        seed: of OMPL's generator, above 0.
        budget: samples at most.
        ends: ``time.monotonic`` after which it is cut [s].
    """
    with _alone():
        return _query(scene, lines, origin, goals, box, seed, budget, ends)


def _query(
    scene: Space, lines: FreeLines, origin: Joints, goals: Sequence[Joints],
    box: Sequence[tuple[float, float]], seed: int, budget: int, ends: float,
) -> Answer:  # fmt: skip
    """Run one path query of OMPL. All objects of OMPL are local to this function, and none refers back to
    it, so that all are freed at its end."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed)
    space = base.RealVectorStateSpace(len(origin))
    bounds = base.RealVectorBounds(len(origin))
    for i, (low, high) in enumerate(box):
        bounds.setLow(i, low)
        bounds.setHigh(i, high)
    space.setBounds(bounds)
    info = base.SpaceInformation(space)
    info.setStateValidityChecker(lambda state: scene.free(state[0 : len(origin)]))
    info.setMotionValidator(_motion_validator(base, info, lines, len(origin)))
    info.setup()
    problem = base.ProblemDefinition(info)
    problem.addStartState(_state(space, origin))
    targets = base.GoalStates(info)
    for goal in goals:
        targets.addState(_state(space, goal))
    problem.setGoal(targets)
    planner = geometric.RRTConnect(info)
    planner.setRange(RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    counter = _Counter(budget, ends)
    planner.solve(base.PlannerTerminationCondition(counter))
    checkpoint()
    if not problem.hasExactSolution():
        return Answer(None, counter.count, counter.late)
    found = (tuple(map(float, state[0 : len(origin)])) for state in problem.getSolutionPath().getStates())
    return Answer(tuple(found), counter.count)


def _state(space: Any, q: Joints) -> Any:
    state = space.allocState()
    state[0 : len(q)] = list(q)
    return state


def _motion_validator(base: Any, info: Any, lines: FreeLines, size: int) -> Any:
    class Line(base.MotionValidator):  # type: ignore[misc]  # OMPL's class is only known at run time
        """Motion validator that checks an edge as the straight line that the robot will drive."""

        def checkMotion(self, a: Any, b: Any) -> bool:
            return lines.line_free(a[0:size], b[0:size])

    return Line(info)


class _Counter:
    """Condition that ends a query after a number of evaluations; the planner asks it once per extension.
    An exception must not pass through OMPL."""

    def __init__(self, budget: int, ends: float) -> None:
        self.count, self.budget, self.ends = 0, budget, ends
        self.late = self.stopped = False

    def __call__(self) -> bool:
        self.count += 1
        if self.count % 64 == 0:
            self.late = self.late or time.monotonic() > self.ends
        self.stopped = self.stopped or stop_asked()
        return self.stopped or self.late or self.count > self.budget
