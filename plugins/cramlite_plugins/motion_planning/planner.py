"""Sampling-based planning of collision-free joint paths: RRTConnect over all inverse solutions, then
shortened.

Lines are only probed while a path is looked for and shortened: of the many that are tried few are used. Those
of the path are then checked all along (``mend``).

Every decision depends on counted work (tree extensions, shortening attempts), never on the
clock: the same seed gives the same path. The wall clock only ends a run that is far
beyond any normal one, and the answer then says so (``truncated``).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import Refused, checkpoint

from ..kinematics.inverse import postures, unturned
from ..kinematics.timing import duration, leading
from .joint_line import PROBED
from .mend import box, made_free
from .round_off import blend_radii
from .rrt import connected
from .shorten import shortened
from .space import FreeLines, Joints, Probed, Space, Twice, refusal

GOALS = 16  # nearest free inverse solutions that are used as goals
DIRECT = 6  # nearest of them that a straight line is tried to
FARTHER = 2.0
"""Ratio of durations from which on a free straight line is compared with ways around obstacles to a nearer
goal: its own to that of a straight line to the nearer goal. An example is a line on which the arm turns over,
since a peg is beside the straight way."""
MARGINS = (2.0, math.pi, 2 * math.pi)
"""Margins around start and goals within which each round samples [rad]. In 6,000 samples 3 of 16 queries
in cages were solved within 1 rad and 16 within pi; two cages took half of the samples within 2 rad, and
were hardly ever solved within 2 pi."""
GROWN = 0.1
"""Largest joint difference [rad] between two places at which lines are probed while trees grow: shortening,
which probes more places, replaces most of these lines."""
AWAY, AWAYS = 0.05, 500
"""Length of the short lines that probe whether a joint position has a way out [rad, largest joint
difference], and their number. Where none is free no tree can grow: 4,000 extensions then took 2 s, and 500
ways take 15 ms (a drawer at its walls, in which a thing is held by mistake)."""
SAFETY_S = 120.0  # wall time after which a query is cut and marked truncated


Points = tuple[Joints, ...]
Goals = Sequence[tuple[int, Joints]]
"""Goal joint positions, each with its index in the list of goals that the caller gave."""


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
        around = (
            _around(eased, origin, nearer, law, seed, samples // len(MARGINS), attempts)
            if nearer
            else straight
        )
        return around if isinstance(around, Path) and around.duration < straight.duration else straight
    return _around(eased, origin, chosen, law, seed, samples, attempts)


def _straight(scene: Space, origin: Joints, goals: Goals, law: tuple[float, float]) -> Path | None:
    """Straight joint-space line from the start to the first of the ``DIRECT`` nearest goals that can be
    reached so; None if none can."""
    for index, goal in goals[:DIRECT]:
        checkpoint()
        if scene.line_probed(origin, goal) and scene.line_free(origin, goal):
            time_s = duration((origin, goal), *law)
            return Path((origin, goal), index, 0, time_s, time_s)
    return None


def _around(
    scene: Space,
    origin: Joints,
    goals: Goals,
    law: tuple[float, float],
    seed: int,
    samples: int,
    attempts: int,
) -> Path | Refused:
    """Find a path to any of the goals that leads through sampled joint positions."""
    if no := _enclosed(scene, origin, [q for _, q in goals]):
        return no
    first, path, spent, truncated = _search(
        scene, origin, [q for _, q in goals], law, seed, samples, attempts
    )
    if not path:
        return _no_path(scene, origin, goals[0][1], spent, truncated)
    index = next(i for i, q in goals if q == path[-1])
    radii, time_s = blend_radii(scene, path, *law)
    return Path(path, index, spent, time_s, duration(first, *law), radii)


def start_blocked(scene: Space, start: Joints) -> Refused | None:
    """Return why no motion can begin at a joint position, such as a limit or a deep collision; None if one
    can."""
    eased = scene.relaxed([start])
    reason = eased.why(start)
    if not reason:
        return None
    said = f"start is blocked: {reason}"
    return refusal(said, blocking=in_the_way(eased, [start]), collision=eased.collision(start))


def in_the_way(scene: Space, positions: Sequence[Sequence[float]]) -> tuple[tuple[str, ...], ...]:
    """Return the minimal sets of things that must be moved to free a blocked joint position, each once."""
    found = set(filter(None, map(scene.blocking, postures(map(_joints, positions)).values())))
    return tuple(sorted(one for one in found if not any(set(other) < set(one) for other in found)))


def _joints(q: Sequence[float] | Floats) -> Joints:
    return tuple(float(v) for v in q)


def _free_goals(scene: Space, origin: Joints, goals: list[Joints]) -> list[tuple[int, Joints]]:
    """Return the goals (joint positions) free of collision, nearest to the start first, each with its index;
    at most ``GOALS``.

    Goals that are whole turns apart are checked once.
    """
    known: dict[tuple[float, ...], bool] = {}
    result: list[tuple[int, Joints]] = []
    for index, q in sorted(enumerate(goals), key=lambda item: (leading(origin, item[1]), item[0])):
        key = unturned(q)
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
    """Whether at least one of some short joint-space lines from a joint position, in random directions, is
    free."""
    return any(scene.line_probed(q, end) for end in _ways(q))


def _ways(q: Joints) -> Iterator[Joints]:
    """Yield joint positions at a short distance from a given one, in random directions that are the same at
    each call."""
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
    return refusal(
        said, samples=spent, truncated=float(truncated), blocking=None, collision=scene.collision(at)
    )


def _search(
    scene: Space,
    origin: Joints,
    goals: list[Joints],
    law: tuple[float, float],
    seed: int,
    samples: int,
    attempts: int,
) -> tuple[Points, Points, int, bool]:
    """Search for a path: the first one found, the shortened one, the number of samples used, and whether it
    was cut short.

    Each round samples a larger box around start and goals.

    Once a path cannot be made free, what probes find is not to be trusted: further rounds check the lines of
    trees all along.
    """
    spent, ends = 0, time.monotonic() + SAFETY_S
    lines: FreeLines = Probed(scene, GROWN)
    for number, margin in enumerate(MARGINS, 1):
        share = (samples - spent) // 2 if number < len(MARGINS) else samples - spent
        query = 1 + (seed * 3 + number) % (2**31 - 2)
        found = connected(
            scene, lines, origin, goals, box(scene, [origin, *goals], margin), query, share, ends
        )
        spent += found.samples
        if found.points is not None:
            closer = Probed(scene, PROBED)
            short = shortened(closer, found.points, *law, seed=seed, attempts=attempts)
            for points in (short, found.points):
                if sure := made_free(scene, closer, points, law, query, ends):
                    return found.points, sure, spent, False
            lines = Twice(scene)
        if found.truncated:
            return (), (), spent, True
    return (), (), spent, False


def resampled(points: Sequence[Joints], step: float) -> Floats:
    """Resample a path so that no joint moves more than ``step`` between samples: (n, joints) [rad]."""
    rows = [np.asarray(points[0], dtype=float)[None]]
    for a, b in pairwise(points):
        count = max(1, math.ceil(leading(a, b) / step))
        rows.append(np.asarray(a) + np.outer(np.arange(1, count + 1) / count, np.subtract(b, a)))
    return np.vstack(rows)
