"""Validator of steps: each step of the program has code in the text, runs in its turn, and moves as far as it
should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from typing import NamedTuple

import numpy as np

from cramlite.model import (
    AnyStep,
    Code,
    CompliantSlide,
    Control,
    Drive,
    Floats,
    ForceMove,
    MoveJoints,
    MoveLinear,
    SetGripper,
    SetPayload,
    Value,
    Wait,
    ZeroSensor,
    enclosing_names,
    task_of,
    walk,
)
from cramlite.plugin import Allowance, Candidate, Cost, Finding, Validator, hookimpl

from ..kinematics.forward import forward, twist
from .grips import held_at
from .step_ends import wrong_end
from .task_times import origins

SHORT = 0.04  # ways below are not judged [m]: a tool that is led lags by up to 5 mm, and touches begin up to 30 mm early
SHARE = 0.4  # of its way a step covers at least: half of a tilt empties a jug, and a tenth is left for lag
LEAN = np.radians(10.0)  # of what is held, when a task ends: as far from the vertical is upright (predicates/attitudes.py)
AHEAD = 0.01  # lead of a pushed thing over the hand's way [m]: as far as a hand may be off (``step_ends``)
LEVER = 0.1  # a turn of 1 rad counts as so much way [m]: what is held reaches about as far from the tool centre point


class Stage(NamedTuple):
    """Consecutive steps of one origin, or a control step with all steps inside of it.

    Args:
        origin: of the first.
        known: origins of all, also of those in a control step.
        steps: of the program's own level.
    """

    origin: str
    known: frozenset[str]
    steps: tuple[AnyStep, ...]


class Ran(NamedTuple):
    """Samples of a run at which the code of a stage (a group of steps) ran: the first one, and the one after
    the last."""

    first: int
    end: int


class Turns(NamedTuple):
    """Order in which the stages of a program (groups of steps) ran.

    Args:
        ran: number of a stage -> when its code ran.
        late: numbers of stages whose code ran after that of a later one, with the first sample and the number of the latter.
    """

    ran: Mapping[int, Ran]
    late: tuple[tuple[int, int, int], ...]


class Steps(Value):
    """Check that every step of the program was carried out.

    Each that has code in the text that was proven has some in the text that ran. Steps that move the arm, the fingers or the
    platform run in their order. Each motion to a stated pose covers its way: from where the hand is when the step's code
    begins it goes at least ``SHARE`` of the way to that pose, measured along that way, position and rotation taken together. A motion that
    feels ends as it is meant to, in the range that the plan gives it (``step_ends``). What a task pushes gets, in one step, as far
    as the hand was to go from where it was, and ``AHEAD``. What is in the hand when a task has moved the arm
    for the last time leans as the plan has it there: the tasks that follow begin with that.

    Steps inside a control step are left to the run, which decides about them.
    """

    name: str = "steps"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        stages = _stages(candidate.program.steps)
        wrong = list(self._objections(candidate, stages))
        yield from wrong
        if stages and not wrong:
            count = sum(len(s.steps) for s in stages)
            yield Finding(self.name, True, f"each of the program's {count} steps has code, ran in its turn and moved as far as planned")

    def _objections(self, candidate: Candidate, stages: list[Stage]) -> Iterator[Finding]:
        gone = _without_code(candidate.written, stages)
        lost = sorted({*gone} - {*_without_code(candidate.proven, stages)}) if candidate.proven is not None else ()
        yield from (Finding(self.name, False, said, origin=origin) for origin, said in _left_out(stages, lost))
        if candidate.ran.outcome != "finished":
            return  # what came after was never reached
        turns = _turns(candidate, stages)
        yield from (self._late(candidate, stages, turn) for turn in turns.late)
        judged = [k for k in range(len(stages)) if k not in {*gone, *(late for late, _, _ in turns.late)}]
        for k in judged:
            yield from self._way(candidate, stages[k], _when(turns, k))
            yield from self._felt(candidate, stages[k], _when(turns, k))
            yield from self._pushed(candidate, stages[k], _when(turns, k))
        yield from self._leaning(candidate, [(stages[k], _when(turns, k)) for k in judged])

    def _late(self, candidate: Candidate, stages: list[Stage], turn: tuple[int, int, int]) -> Finding:
        late, sample, later = turn
        when = candidate.ran.times[sample]
        said = f"the code of {stages[late].origin} ran at {when:.2f} s, after that of {stages[later].origin}"
        said = f"{said}, which comes later in the program"
        return Finding(self.name, False, said, origin=stages[late].origin)

    def _way(self, candidate: Candidate, stage: Stage, ran: Ran) -> Iterator[Finding]:
        target = _target(candidate, stage)
        if target is None:
            return
        start, end = (_hand(candidate, k) for k in ran)
        way = _way(start, target)
        length = float(np.linalg.norm(way))
        if length < SHORT:
            return
        share = float(_covered(start, end, way) @ way) / length**2
        if share < SHARE:
            said = f"{stage.origin} was not carried out: the hand covered {max(share, 0):.0%} of its way of {1000 * length:.0f} mm"
            yield Finding(self.name, False, f"{said}, {SHARE:.0%} is needed", share, SHARE, "", stage.origin)

    def _felt(self, candidate: Candidate, stage: Stage, ran: Ran) -> Iterator[Finding]:
        reason = wrong_end(candidate, stage.steps, ran)
        if reason:
            yield Finding(self.name, False, f"{stage.origin} was not carried out: {reason}", origin=stage.origin)

    def _pushed(self, candidate: Candidate, stage: Stage, ran: Ran) -> Iterator[Finding]:
        target = _target(candidate, stage)
        if target is None or any(s.relative for s in stage.steps):
            return
        planned = float(np.linalg.norm((target - _hand(candidate, ran.first))[:3, 3]))
        pushed = _pushes(candidate, stage.origin)
        held = held_at(candidate.ran)[ran.first : ran.end] if pushed else ()
        for thing in sorted(pushed - {*held}):
            first, end = (candidate.ran.poses[thing][k, :3] for k in ran)
            far = float(np.linalg.norm(end - first))
            if far > planned + AHEAD:
                said = f"{stage.origin} pushed '{thing}' by {1000 * far:.0f} mm, where the hand was to go {1000 * planned:.0f} mm"
                said = f"{said}; a pushed thing may go {1000 * AHEAD:.0f} mm farther than the hand"
                yield Finding(self.name, False, said, far, planned + AHEAD, "m", stage.origin, things=True)

    def _leaning(self, candidate: Candidate, ran: Iterable[tuple[Stage, Ran]]) -> Iterator[Finding]:
        held, loose = held_at(candidate.ran), {t.name for t in candidate.world.things if t.joint is None}
        last = {task_of(stage.origin): (stage, when) for stage, when in ran if _leads(stage)}
        for stage, when in last.values():
            target, thing = _target(candidate, stage), held[when.end]
            lean = _lean(_hand(candidate, when.end), target) if target is not None and thing in loose else 0.0
            if lean > LEAN:
                said = f"{stage.origin} was not carried out: '{thing}' leans {np.degrees(lean):.0f} deg from the step's goal attitude"
                yield Finding(self.name, False, f"{said}, limit {np.degrees(LEAN):.0f} deg", lean, LEAN, "rad", stage.origin)


def _stages(steps: Iterable[AnyStep]) -> list[Stage]:
    """Stages of a program: consecutive steps that share an origin; steps without an origin are left out."""
    found = []
    for origin, same in groupby(steps, lambda s: s.origin or next((i.origin for i in walk([s]) if i.origin), "")):
        own = tuple(same)
        known = frozenset(s.origin for s in walk(own) if s.origin)
        found += [Stage(origin, known, own)] if known else []
    return found


def _without_code(code: Code, stages: list[Stage]) -> list[int]:
    """Indices of the stages (consecutive steps of one origin) for which a program text has no line of code."""
    there = {origin for line, origin in code.origins.items() if code.lines_of(line)}
    return [k for k, stage in enumerate(stages) if not stage.known & there]


def _left_out(stages: list[Stage], lost: Iterable[int]) -> Iterator[tuple[str, str]]:
    """Origin of each stage, or of a whole task, whose code is missing in the text, and a sentence that says so."""
    names = [stages[k].origin for k in lost]
    kept = {task_of(s.origin) for s in stages if s.origin not in names}
    for origin in dict.fromkeys(o if task_of(o) in kept else task_of(o) for o in names):
        yield origin, f"{origin} has no line of code in this text, while the proven text had some"


def _turns(candidate: Candidate, stages: list[Stage]) -> Turns:
    """Assign each stretch of a run to a stage (a group of steps) of the program; find stretches that run after
    a later stage has begun.

    A stretch belongs to the next stage that has its origin; it is late if all such stages are before the last
    assigned one.
    """
    now, ran, late = 0, dict[int, Ran](), list[tuple[int, int, int]]()
    for origin, first, end in _stretches(origins(candidate)):
        own = [k for k, stage in enumerate(stages) if origin in stage.known and _moves(stage)]
        following = next((k for k in own if k >= now), None)
        if following is not None:
            now = following
            ran[now] = Ran(ran[now].first if now in ran else first, end)
        elif own:
            late.append((own[-1], first, now))
    return Turns(ran, tuple(late))


def _stretches(each: list[str]) -> Iterator[tuple[str, int, int]]:
    """Stretches of a run in which code of one step ran: the origin of the code, the first sample, and the one
    after the last."""
    first = 0
    for origin, same in groupby(each):
        end = first + sum(1 for _ in same)
        yield origin, first, min(end, len(each) - 1)
        first = end


def _moves(stage: Stage) -> bool:
    """Whether a stage (a group of steps) of the program moves the arm, the fingers or the platform.

    The order of stages that move nothing is not checked.
    """
    return any(not isinstance(s, SetPayload | ZeroSensor | Wait | Control) for s in walk(stage.steps))


def _leads(stage: Stage) -> bool:
    """Check whether a stage (a group of a program's steps) may move the arm or the platform."""
    return any(not isinstance(s, SetPayload | ZeroSensor | Wait | SetGripper) for s in stage.steps)


def _lean(hand: Floats, other: Floats) -> float:
    """Angle between two poses of the tool (4, 4), without the turn about the vertical [rad]."""
    return float(np.arccos(np.clip(hand[2, :3] @ other[2, :3], -1.0, 1.0)))


def _when(turns: Turns, stage: int) -> Ran:
    """Samples at which the code of a stage (a group of steps) ran; if none of it ran, an empty span after the
    earlier stages."""
    if stage in turns.ran:
        return turns.ran[stage]
    before = max((ran.end for k, ran in turns.ran.items() if k < stage), default=0)
    return Ran(before, before)


def _target(candidate: Candidate, stage: Stage) -> Floats | None:
    """Target of the last motion in a stage (a group of steps), as a (4, 4) pose of the tool in the base frame;
    None if that motion states none."""
    for step in reversed(stage.steps):
        if isinstance(step, Control | Drive):
            return None
        if isinstance(step, MoveJoints):
            return _tool(candidate, step.path[-1])
        if isinstance(step, MoveLinear):
            return step.target.matrix
        if isinstance(step, ForceMove | CompliantSlide):
            return step.waypoints[-1].matrix
    return None


def _hand(candidate: Candidate, sample: int) -> Floats:
    """Pose (4, 4) of the tool in the base frame at a sample."""
    return _tool(candidate, candidate.ran.joints[sample])


def _pushes(candidate: Candidate, origin: str) -> set[str]:
    """Names of the loose things that the task of a step may move without holding them."""
    loose = {t.name for t in candidate.world.things if t.joint is None}
    allowed = (candidate.allowances.get(task, Allowance()).moves for task in enclosing_names(origin))
    return loose & set[str]().union(*allowed)


def _tool(candidate: Candidate, joints: Iterable[float]) -> Floats:
    return forward(candidate.robot, tuple(joints)).matrix


def _way(start: Floats, end: Floats) -> Floats:
    """Motion of the tool from one pose to another (6,): translation, and rotation vector times ``LEVER``
    [m]."""
    way: Floats = twist(start, end) * np.repeat([1.0, LEVER], 3)
    return way


def _covered(start: Floats, end: Floats, planned: Floats) -> Floats:
    """Motion of the tool from one pose to another (6,); a rotation by more than a quarter turn
    is given in the direction that is nearer to the planned motion."""
    way = _way(start, end)
    angle = float(np.linalg.norm(way[3:])) / LEVER
    if angle < np.pi / 2:
        return way
    round_ = np.hstack((way[:3], way[3:] * (1 - 2 * np.pi / angle)))
    return min(way, round_, key=lambda w: float(np.linalg.norm(w - planned)))


@hookimpl
def validators() -> Iterable[Validator]:
    return [Steps()]
