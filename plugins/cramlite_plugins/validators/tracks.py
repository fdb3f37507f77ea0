"""Validator of tracks: tasks of the plan must explain each time that a thing is held, falls or is moved along."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby

import numpy as np

from cramlite.model import Floats, Handover, Pose, Rollout, Value
from cramlite.plugin import Allowance, Candidate, Cost, Finding, Validator, hookimpl

from ..shapes.bounds import box_around, lowest
from .carries import carries
from .explained import EARLY, LATE, ExplainedGrip, explained_grips
from .grips import Grip
from .movers import rests
from .rest import hangs
from .slides import slides
from .swings import declared
from .task_times import inner_tasks, origins

DROP = 0.03
"""Largest fall of a released thing, in excess of the height of its place and of that of falling over [m]: poses are believed to 2 mm, a
guarded motion ends within 20 mm, and one thing stands on others."""
SETTLES = 3.0
"""Longest time in which a released thing comes to rest [s]: a block that topples off an edge takes 0.5 s, a can that rolls in a bowl 2
s."""
SLIDES = 0.015
"""Largest displacement of a payload along a surface that it touches, in a task that does not slide it [m]: closing fingers centre a
thing whose believed pose is off by some millimetres, and lifts begin aslant."""
BACK = 0.01
"""Largest distance by which a thing may move back before the end of the task that moved it [m]."""
RANGE = 0.1
"""Share of a joint's range by which the fingers may push a handle when they leave it."""


class Tracks(Value):
    """Validator of tracks: tasks of the plan must explain each time that a thing is held, falls or is moved along.

    A grip is explained by steps that take the thing and let go of it, a fall by the place of the release, and
    other motions by a task that may move or slide the thing.
    """

    name: str = "tracks"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        found = explained_grips(candidate)
        wrong = [f for part in (_unexplained, _interrupted, _fallen, _slid, _taken_along, _returned) for f in part(candidate, found)]
        yield from wrong
        if not wrong:
            things = sorted({f.grip.thing for f in found})
            what = f"{', '.join(map(repr, things))} ({len(found)} times)" if found else "nothing"
            yield Finding(self.name, True, f"the hand held {what}, always as tasks of the plan explain")


def _unexplained(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Findings on grips that no task of the plan explains."""
    rollout, tasks = candidate.ran, inner_tasks(candidate)
    for grip, wrong, at, _, _ in found:
        if wrong:
            span = f"from {rollout.times[grip.first]:.1f} to {rollout.times[grip.last]:.1f} s"
            way = _way(rollout.poses[grip.thing][grip.first : grip.last + 1])
            said = f"'{grip.thing}' was in the hand {span} and moved by {1000 * way:.0f} mm: {wrong}"
            yield Finding("tracks", False, said, way, origin=tasks[at], things=True)


def _way(track: Floats) -> float:
    """Largest distance of a track (N, 7) from its start [m]."""
    return float(np.linalg.norm(track[:, :3] - track[0, :3], axis=1).max())


def _interrupted(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Findings on times at which the hand did not hold a thing that, by the plan, it had taken and not let go of.

    Steps that the plan may leave out are not regarded.
    """
    rollout, tasks = candidate.ran, inner_tasks(candidate)
    came_from = np.array(origins(candidate))
    for taken, left in _held_between(candidate.handovers or ()):
        begun = np.flatnonzero(came_from == taken.by) if taken.by else np.array([0])
        ended = np.flatnonzero(came_from == left.by)
        held = {k for grip, *_ in found if grip.thing == taken.thing for k in range(grip.first, grip.last + 1)}
        gone = [k for k in range(begun[-1], ended[0]) if k not in held] if len(begun) and len(ended) else []
        if gone and rollout.times[gone[-1]] - rollout.times[gone[0]] > LATE:
            when = f"from {rollout.times[gone[0]]:.1f} to {rollout.times[gone[-1]]:.1f} s"
            said = f"'{taken.thing}' was not in the hand {when}, between {taken.by} and {left.by}"
            yield Finding("tracks", False, said, origin=tasks[gone[0]], things=True)


def _held_between(handovers: Iterable[Handover]) -> Iterator[tuple[Handover, Handover]]:
    """Pairs of steps of the plan: one that takes a thing into the hand, and the next one, which lets go of it.

    Pairs with a step that the plan may leave out are not among them.
    """
    taken: Handover | None = None
    for one in handovers:
        if taken is not None and not one.taken and one.thing == taken.thing and not (one.optional or taken.optional):
            yield taken, one
        taken = one if one.taken else None


def _fallen(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Findings on falls after a release that are longer than the place of the release predicts, or on
    things that come to rest too late."""
    rollout, tasks = candidate.ran, inner_tasks(candidate)
    for grip, wrong, _, left, _ in found:
        if wrong or left is None or left.rest is None:
            continue
        who, when = f"'{grip.thing}', let go at {rollout.times[grip.last]:.1f} s,", tasks[grip.last]
        rest = min(rests(rollout, grip.thing, grip.last), len(rollout.times) - 1)
        height = rollout.poses[grip.thing][grip.last : rest + 1, 2]
        drop, limit = float(height[0] - height.min()), left.rest.fall + DROP + _topples(rollout, grip)
        if drop > limit:
            said = f"{who} fell by {1000 * drop:.0f} mm after {left.by}, limit {1000 * limit:.0f} mm"
            yield Finding("tracks", False, said, drop, limit, "m", when, things=True)
        lasted = float(rollout.times[rest] - rollout.times[grip.last])
        if lasted > SETTLES and not hangs(rollout, grip.thing, rest):
            said = f"{who} kept moving for {lasted:.1f} s, limit {SETTLES:g} s"
            yield Finding("tracks", False, said, lasted, SETTLES, "s", when, things=True)


def _topples(rollout: Rollout, grip: Grip) -> float:
    """Height that a thing's origin loses when the thing falls over after its release [m]."""
    thing, row = rollout.world.thing(grip.thing), rollout.poses[grip.thing][grip.last]
    low, high = box_around(thing.geoms)
    upright = -lowest(thing, Pose.from_row(row))
    return max(0.0, upright - float(np.min(high - low)) / 2)


def _slid(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Findings on payloads that were dragged along a surface by a task that does not declare to slide them.

    Dragging during a declared turn of the payload in the hand is left out.
    """
    rollout, tasks, turns = candidate.ran, inner_tasks(candidate), declared(candidate)
    for grip, _, _, _, taken in found:
        for task, rows in () if not taken else _stretches(tasks):
            if candidate.allowances.get(task, Allowance()).slides:
                continue
            free = (s for s in slides(rollout, grip, rows) if not any(t.first <= s.last and s.first <= t.last for t in turns))
            worst = max(free, key=lambda s: s.way, default=None)
            if worst is not None and worst.way > SLIDES:
                span = f"from {rollout.times[worst.first]:.1f} to {rollout.times[worst.last]:.1f} s"
                said = f"'{grip.thing}' was dragged along '{worst.along}' by {1000 * worst.way:.0f} mm {span}"
                limit = f"limit {1000 * SLIDES:.0f} mm in a task that may not slide a thing"
                yield Finding("tracks", False, f"{said}, {limit}", worst.way, SLIDES, "m", task, things=True)


def _taken_along(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Findings on things that the open hand takes along without holding them: before their grasp, or after
    their release until they rest."""
    rollout, tasks, limit = candidate.ran, inner_tasks(candidate), candidate.limits.bystander_motion
    for grip, wrong, _, _, _ in found:
        rest = min(rests(rollout, grip.thing, grip.last), len(rollout.times) - 1)
        free = {task for task in set(tasks) if grip.thing in candidate.allowances.get(task, Allowance()).moves}
        let_go = range(grip.last, grip.last if wrong else rest + 1)
        early = range(int(np.searchsorted(rollout.times, rollout.times[grip.first] - EARLY)), grip.first + 1)
        for rows, most, when in ((early, SLIDES, "before it was held"), (let_go, limit, "after its release")):
            worst = max((c for c in carries(rollout, grip.thing, rows) if tasks[c.last] not in free), key=lambda c: c.way, default=None)
            if worst is not None and worst.way > most:
                span = f"from {rollout.times[worst.first]:.1f} to {rollout.times[worst.last]:.1f} s"
                said = f"'{grip.thing}' was taken along by the hand by {1000 * worst.way:.0f} mm {span}, {when}"
                said = f"{said}, limit {1000 * most:g} mm"
                yield Finding("tracks", False, said, worst.way, most, "m", tasks[worst.last], things=True)


def _stretches(tasks: list[str]) -> Iterator[tuple[str, range]]:
    """Stretches of samples in which the code of the same task runs, each with that task."""
    for task, stretch in groupby(range(len(tasks)), key=lambda k: tasks[k]):
        rows = list(stretch)
        yield task, range(rows[0], rows[-1] + 1)


def _returned(candidate: Candidate, found: Iterable[ExplainedGrip]) -> Iterator[Finding]:
    """Yield objections to tasks that moved a thing that then came back before the task ended."""
    rollout, tasks = candidate.ran, inner_tasks(candidate)
    for task, rows in _stretches(tasks):
        carried = _carried(rollout, found, rows)
        for name in sorted((candidate.allowances.get(task, Allowance()).moves & rollout.poses.keys()) - carried):
            ways, limit, unit = _ways(rollout, name, rows)
            back = float(ways.max() - ways[-1])
            if back > limit:
                said = f"'{name}' was moved by {_said(ways.max(), unit)} and came back by {_said(back, unit)}"
                yield Finding("tracks", False, f"{said}, limit {_said(limit, unit)}", back, limit, unit, task, things=True)


def _carried(rollout: Rollout, found: Iterable[ExplainedGrip], rows: range) -> set[str]:
    """Names of the loose things that the hand lets go of at a sample in ``rows``, as tasks of the plan explain."""
    let_go = {grip.thing for grip, wrong, *_ in found if not wrong and grip.last in rows}
    return {name for name in let_go if rollout.world.thing(name).joint is None}


def _ways(rollout: Rollout, name: str, rows: range) -> tuple[Floats, float, str]:
    """Return a thing's distance from its first position in some samples, at each of them; how far the thing may go back
    towards that position; and the unit of both. For a thing on a joint, these are differences of joint values."""
    joint = rollout.world.thing(name).joint
    if joint is None or name not in rollout.values:
        track = rollout.poses[name][rows, :3]
        return np.linalg.norm(track - track[0], axis=1), BACK, "m"
    values = rollout.values[name][rows]
    return np.abs(values - values[0]), RANGE * (joint.upper - joint.lower), "rad" if joint.kind == "hinge" else "m"


def _said(value: float, unit: str) -> str:
    return f"{1000 * value:.0f} mm" if unit == "m" else f"{np.degrees(value):.0f} deg"


@hookimpl
def validators() -> Iterable[Validator]:
    return [Tracks()]
