"""Sampling-based planning of collision-free joint paths: RRTConnect over all inverse solutions, then shortened.

Every decision depends on counted work (tree extensions, shortening attempts), never on the
clock: the same seed gives the same path. OMPL's generator is global to the process, so
queries of one process run one after the other. The wall clock only ends a run that is far
beyond any normal one, and the answer then says so (``truncated``).

Source: Kuffner and LaValle, RRT-Connect, ICRA 2000; OMPL (Sucan, Moll, Kavraki, 2012).
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import Refused, checkpoint, stop_asked

from ..kinematics.timing import duration, leading
from .round_off import blend_radii
from .shorten import shortened
from .space import Joints, Space, refusal

RANGE = 1.0  # longest tree extension [rad], with which 200 of 200 shelf problems were solved, in 3.3 ms (median)
GOALS = 16  # nearest free inverse solutions that are used as goals
DIRECT = 6  # nearest of them that a straight line is tried to
FARTHER = 2.0
"""A straight line that takes so many times as long as one to a nearer goal would, were it free, is compared with ways around what is
there: with an arm that turns over where a peg is beside the straight way."""
MARGINS = (1.0, math.pi, 2 * math.pi)  # how far beyond start and goals each round samples [rad]
AWAY, AWAYS = 0.05, 500
"""Length of a short way [rad, largest joint difference], and in how many directions one is looked for. Where none is free no tree can
grow: 4,000 extensions then took 2 s, and 500 ways take 15 ms (a drawer at its walls, in which a thing is held by mistake)."""
SAFETY_S = 120.0  # wall time after which a query is cut and marked truncated


Goals = Sequence[tuple[int, Joints]]
"""Joint positions, each with its index among those that were asked for."""


class Path(Value):
    """Collision-free joint path.

    Args:
        points: joint positions, start included; the lines between them are free [rad].
        goal: index of the goal that it ends at.
        samples: tree extensions that were spent; 0 for a straight line.
        duration: at the speed that was planned for [s].
        first: duration of the first solution, before shortening, with stops at its points [s].
        radii: of the blend at each point between start and end, 0 for a stop [m].
    """

    points: tuple[Joints, ...]
    goal: int
    samples: int
    duration: float
    first: float
    radii: tuple[float, ...] = ()


def plan(
    scene: Space,
    start: Sequence[float],
    goals: Sequence[Sequence[float]],
    *,
    seed: int,
    samples: int = 4000,
    speed: float = 1.05,
    acceleration: float = 1.4,
    attempts: int = 120,
) -> Path | Refused:
    """Plan a short collision-free path from a joint position to one of several.

    Args:
        goals: joint positions, usually every inverse solution of a pose, in order of preference.
        seed: of this query; the same seed gives the same path in every process.
        samples: tree extensions to spend at most.
        speed, acceleration: of the leading axis, to compare durations [rad/s, rad/s2]; the defaults are
            URScript's for movej.
        attempts: tries to shorten the path.
    """
    origin = _joints(start)
    if not goals:
        return refusal("there is no inverse solution to plan to")
    if no := start_blocked(scene, origin):
        return no
    law = (speed, acceleration)
    chosen = _free_goals(scene, origin, [_joints(g) for g in goals])
    if not chosen:
        return _blocked_goals(scene, goals)
    eased = scene.relaxed([origin, *(q for _, q in chosen)])
    straight = _straight(eased, origin, chosen, law)
    if straight is not None:
        most = straight.duration / FARTHER
        nearer = [(k, q) for k, q in chosen if duration((origin, q), *law) < most]
        around = _around(eased, origin, nearer, law, seed, samples // len(MARGINS), attempts) if nearer else straight
        return around if isinstance(around, Path) and around.duration < straight.duration else straight
    return _around(eased, origin, chosen, law, seed, samples, attempts)


def _straight(scene: Space, origin: Joints, goals: Goals, law: tuple[float, float]) -> Path | None:
    """The straight line to the nearest goal to which there is one."""
    for index, goal in goals[:DIRECT]:
        checkpoint()
        if scene.line_free(origin, goal):
            time_s = duration((origin, goal), *law)
            return Path((origin, goal), index, 0, time_s, time_s)
    return None


def _around(
    scene: Space, origin: Joints, goals: Goals, law: tuple[float, float], seed: int, samples: int, attempts: int
) -> Path | Refused:
    """A path to any of the goals by way of other positions."""
    if no := _enclosed(scene, origin, [q for _, q in goals]):
        return no
    points, spent, truncated = _search(scene, origin, [q for _, q in goals], seed, samples)
    if points is None:
        return _no_path(scene, origin, goals[0][1], spent, truncated)
    short = shortened(scene, points, *law, seed=seed, attempts=attempts)
    index = next(i for i, q in goals if q == points[-1])
    radii, time_s = blend_radii(scene, short, *law)
    return Path(short, index, spent, time_s, duration(points, *law), radii)


def start_blocked(scene: Space, start: Joints) -> Refused | None:
    """Return why nothing can begin at a joint position; None where it is free, but for contacts that are there already."""
    eased = scene.relaxed([start])
    reason = eased.why(start)
    if not reason:
        return None
    said = f"start is blocked: {reason}"
    return refusal(said, blocking=in_the_way(eased, [start]), collision=eased.collision(start))


def in_the_way(scene: Space, positions: Sequence[Sequence[float]]) -> tuple[tuple[str, ...], ...]:
    """Return of each blocked joint position, that moving things can free, the things that must be moved: none is free while of each
    set one is left. Sets that have another one in them say nothing more, and are left out."""
    found = set(filter(None, map(scene.blocking, positions)))
    return tuple(sorted(one for one in found if not any(set(other) < set(one) for other in found)))


def _joints(q: Sequence[float] | Floats) -> Joints:
    return tuple(float(v) for v in q)


def _free_goals(scene: Space, origin: Joints, goals: list[Joints]) -> list[tuple[int, Joints]]:
    """The nearest goals that are free, each with its index: whole turns of a blocked one are blocked too."""
    known: dict[tuple[float, ...], bool] = {}
    result: list[tuple[int, Joints]] = []
    for index, q in sorted(enumerate(goals), key=lambda item: (leading(origin, item[1]), item[0])):
        key = tuple(round(math.remainder(v, 2 * math.pi), 6) for v in q)
        if key not in known:
            checkpoint()
            known[key] = not scene.relaxed([q]).why(q)
        if known[key] and all(low <= v <= high for v, (low, high) in zip(q, scene.limits, strict=True)):
            result.append((index, q))
        if len(result) == GOALS:
            break
    return result


def _blocked_goals(scene: Space, goals: Sequence[Sequence[float]]) -> Refused:
    at: dict[str, list[Sequence[float]]] = {}
    for q in goals:
        at.setdefault(scene.relaxed([q]).why(q), []).append(q)
    listed = sorted(at, key=lambda r: (-len(at[r]), r))[:3]
    said = f"all {len(goals)} goal positions are blocked: {'; '.join(listed)}"
    first = at[listed[0]][0]
    return refusal(said, blocking=in_the_way(scene, goals), collision=scene.relaxed([first]).collision(first))


def _enclosed(scene: Space, origin: Joints, goals: Sequence[Joints]) -> Refused | None:
    """Why no tree can grow from the start, or from any goal; None where both can."""
    if not _leaves(scene, origin):
        at, what = origin, "the start"
    elif not any(_leaves(scene, q) for q in goals):
        at, what = goals[0], "any goal"
    else:
        return None
    blocked = next((q for q in _ways(at) if scene.why(q)), at)
    said = f"no path: none of {AWAYS} short ways away from {what} is free: {scene.why(blocked)}"
    return refusal(said, blocking=None, collision=scene.collision(blocked))


def _leaves(scene: Space, q: Joints) -> bool:
    """Whether any short way from a joint position is free."""
    return any(scene.line_free(q, end) for end in _ways(q))


def _ways(q: Joints) -> Iterator[Joints]:
    """Ends of short ways from a joint position in all directions, the same each time."""
    rng = np.random.default_rng(0)
    for _ in range(AWAYS):
        checkpoint()
        way = rng.uniform(-1.0, 1.0, len(q))
        yield _joints(np.asarray(q) + AWAY / float(np.abs(way).max()) * way)


def _no_path(scene: Space, origin: Joints, goal: Joints, spent: int, truncated: bool) -> Refused:
    part = scene.blocked(origin, goal)
    at = [a + (part or 0.0) * (b - a) for a, b in zip(origin, goal, strict=True)]
    cut = f" (cut after {SAFETY_S:.0f} s of wall time)" if truncated else ""
    said = f"no path in {spent} samples{cut}; the straight way is blocked: {scene.why(at)}"
    return refusal(said, samples=spent, truncated=float(truncated), blocking=None, collision=scene.collision(at))


def _search(
    scene: Space, origin: Joints, goals: list[Joints], seed: int, samples: int
) -> tuple[tuple[Joints, ...] | None, int, bool]:
    """Rounds of RRTConnect in growing boxes around start and goals: most answers are near the direct way."""
    spent, ends = 0, time.monotonic() + SAFETY_S
    for number, margin in enumerate(MARGINS, 1):
        share = (samples - spent) // 2 if number < len(MARGINS) else samples - spent
        box = _box(scene, [origin, *goals], margin)
        with _alone():
            points, used, truncated = _rrt(scene, origin, goals, box, 1 + (seed * 3 + number) % (2**31 - 2), share, ends)
        spent += used
        if points is not None or truncated:
            return points, spent, truncated
    return None, spent, False


def _box(scene: Space, positions: list[Joints], margin: float) -> list[tuple[float, float]]:
    low, high = np.min(positions, axis=0) - margin, np.max(positions, axis=0) + margin
    return [(max(a, c), min(b, d)) for (a, b), c, d in zip(scene.limits, low, high, strict=True)]


_ONE_QUERY = threading.Lock()
"""OMPL's random generator belongs to the process: from its seed to the path a query has it alone."""
PATIENCE = 0.1
"""Seconds of waiting for another thread's query between two questions whether to go on."""


@contextmanager
def _alone() -> Iterator[None]:
    """No other query of this process runs meanwhile."""
    while not _ONE_QUERY.acquire(timeout=PATIENCE):
        checkpoint()
    try:
        yield
    finally:
        _ONE_QUERY.release()


def _rrt(
    scene: Space,
    origin: Joints,
    goals: list[Joints],
    box: list[tuple[float, float]],
    seed: int,
    budget: int,
    ends: float,
) -> tuple[tuple[Joints, ...] | None, int, bool]:
    """One query. Everything of OMPL lives in this frame: nothing it holds refers back to it."""
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
    info.setMotionValidator(_motion_validator(base, info, scene, len(origin)))
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
        return None, counter.count, counter.late
    found = [_joints(state[0 : len(origin)]) for state in problem.getSolutionPath().getStates()]
    return tuple(found), counter.count, False


def _state(space: Any, q: Joints) -> Any:
    state = space.allocState()
    state[0 : len(q)] = list(q)
    return state


def _motion_validator(base: Any, info: Any, scene: Space, size: int) -> Any:
    class Line(base.MotionValidator):  # type: ignore[misc]  # OMPL's class is only known at run time
        """Checks an edge as the straight line that the robot will drive."""

        def checkMotion(self, a: Any, b: Any) -> bool:
            return scene.line_free(a[0:size], b[0:size])

    return Line(info)


class _Counter:
    """Ends a query after so many evaluations: the planner asks once an extension. An exception must not pass through OMPL."""

    def __init__(self, budget: int, ends: float) -> None:
        self.count, self.budget, self.ends = 0, budget, ends
        self.late = self.stopped = False

    def __call__(self) -> bool:
        self.count += 1
        if self.count % 64 == 0:
            self.late = self.late or time.monotonic() > self.ends
        self.stopped = self.stopped or stop_asked()
        return self.stopped or self.late or self.count > self.budget


def resampled(points: Sequence[Joints], step: float) -> Floats:
    """Resample a path so that no joint moves more than ``step`` between samples: (n, joints) [rad]."""
    rows = [np.asarray(points[0], dtype=float)[None]]
    for a, b in pairwise(points):
        count = max(1, math.ceil(leading(a, b) / step))
        rows.append(np.asarray(a) + np.outer(np.arange(1, count + 1) / count, np.subtract(b, a)))
    return np.vstack(rows)
