"""Contact forces: the most that each task may press or pull with, as declared, else by the motions of its
program, else by default."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cramlite.model import (
    GRAVITY,
    AnyStep,
    CompliantSlide,
    Floats,
    ForceExtract,
    ForceInsert,
    ForceMove,
    MoveUntilContact,
    Rollout,
    SpiralSearch,
    Touch,
    enclosing_names,
    thing_of,
    walk,
)
from cramlite.plugin import HAND, Candidate, checkpoint

from ..motions.motion_kinds import LIMIT
from ..motions.ontology_limits import Known, lowest
from .grips import held_at
from .task_times import inner_tasks, origins

STOPPED = 1.15  # a program that stops at its task's force limit has gone beyond it by then: 28.3 N at 25 N, measured
RISE = 750.0
"""Excess force of a guarded motion over its force threshold, per speed [N s/m]: one that ends at 3 N peaks at 9 N with 10 mm/s and at 18
N with 20 mm/s, in simulation."""
IN_DOUBT = 0.2
"""Share of a payload's weight that the arm may feel although the controller compensates it: masses are in doubt by this
(``ErrorModel``)."""
SPREAD = 2
"""Number of samples before and after a contact that belong to it: a sample has the peak of the cycles before it, and the sensor lags by
16 ms."""

Forced = ForceMove | SpiralSearch | ForceInsert | ForceExtract | CompliantSlide


class TaskForce(NamedTuple):
    """Largest force that a task may press or pull with [N], the source of this limit, and whether the task
    declares it."""

    most: float
    source: str
    declared: bool = False


def task_forces(candidate: Candidate) -> dict[str, TaskForce]:
    """Return for each task of a program the largest force that it may press or pull with.

    The force limit of the whole program, which no task may exceed, is not regarded.
    """
    steps = _steps(candidate)
    names = {"", *(a.name for a in (*candidate.actions, *candidate.parts))}
    return {name: _of(name, candidate, steps.get(name, ())) for name in names}


def _of(name: str, candidate: Candidate, steps: Iterable[AnyStep]) -> TaskForce:
    own = candidate.allowances[name].force if name in candidate.allowances else None
    if own is not None:
        return TaskForce(own, f"of {name}", declared=True)
    most = max((f for step in steps if (f := _force(step)) is not None), default=0.0)
    if most > LIMIT.default:
        return TaskForce(most, f"of the motions of {name}")
    return TaskForce(LIMIT.default, "of every task that declares none")


def _force(step: AnyStep) -> float | None:
    """Largest force that a step's end condition allows [N]; None for steps without force sensing."""
    if isinstance(step, Forced):
        return step.force_limit
    return _guard_force(step) if isinstance(step, MoveUntilContact) else None


def _guard_force(step: MoveUntilContact) -> float:
    return step.force + RISE * step.speed


def _steps(candidate: Candidate) -> Mapping[str, list[AnyStep]]:
    """Steps by the name of the innermost task, or part of a task, that they belong to."""
    known, found = {a.name for a in (*candidate.actions, *candidate.parts)}, dict[str, list[AnyStep]]()
    for step in walk(candidate.program.steps):
        task = next((n for n in enclosing_names(step.origin) if n in known), "")
        found.setdefault(task, []).append(step)
    return found


def guard_forces(candidate: Candidate) -> list[TaskForce | None]:
    """Return for each sample the force threshold of the guarded motion that runs then; None without one, and
    at the first samples of the motion, where force peaks of the code before it still show."""
    guards: dict[str, TaskForce] = {}
    for step in walk(candidate.program.steps):
        if isinstance(step, MoveUntilContact):
            own = TaskForce(_guard_force(step), f"of {step.origin}, which ends at {step.force:g} N")
            guards[step.origin] = max(own, guards.get(step.origin, own), key=lambda guard: guard.most)
    known = origins(candidate)
    return [guards.get(origin) if origin == known[max(k - SPREAD, 0)] else None for k, origin in enumerate(known)]


class ForceLimits(NamedTuple):
    """Force limit of the arm at each sample (N,) [N], its source, and the task."""

    most: Floats
    source: list[str]
    tasks: list[str]


def force_limits(candidate: Candidate) -> ForceLimits:
    """Return the force limit of the arm at each sample: that of the current task while something is touched, else the program's.

    A task that declares a force has that all through. A guarded motion has what its own force and speed lead to, where that is less: a
    text that goes on pressing beyond the force of the plan is refused. What is carried may be heavier than believed; what bears little
    lowers the limit.
    """
    program, rollout, tasks = candidate.program, candidate.ran, inner_tasks(candidate)
    own, fragile, held = task_forces(candidate), _fragile(candidate), held_at(rollout)
    guards = guard_forces(candidate)
    weights = {t.name: GRAVITY * (t.mass or 0.0) for t in candidate.world.things if t.joint is None}
    most, source = np.full(len(tasks), program.force_limit), [program.force_limit_source] * len(tasks)
    for k, touched in enumerate(touched_at(rollout, held)):
        force = own[tasks[k]]
        if not touched and not force.declared:
            continue
        force = min(force, (guards[k] if touched else None) or force, key=lambda one: one.most)
        limit, whose = STOPPED * force.most, f"{force.source} ({force.most:g} N, plus {STOPPED - 1:.0%} while the arm stops)"
        least = min((fragile[one] for one in touched if one in fragile), key=lambda known: known.value, default=None)
        if least is not None and least.value < force.most:
            limit, whose = STOPPED * least.value, f"{least} ({least.value:g} N, plus {STOPPED - 1:.0%} while the arm stops)"
        limit += 0.0 if force.declared else IN_DOUBT * weights.get(held[k], 0.0)
        if limit < program.force_limit:
            most[k], source[k] = limit, whose
    return ForceLimits(most, source, tasks)


def _fragile(candidate: Candidate) -> dict[str, Known]:
    """Force limits of fragile things, where an ontology states one."""
    said = {t.name: lowest([t], "cram:maximumForce", candidate) for t in candidate.world.things}
    return {name: known for name, known in said.items() if known is not None}


def touched_at(rollout: Rollout, held: list[str]) -> Iterator[set[str]]:
    """Yield the things in contact with the hand or the payload at each sample and shortly before and after it."""
    met = [_met(touches, {HAND, one} - {""}) for touches, one in zip(rollout.awake_touches, held, strict=True)]
    for k in range(len(met)):
        checkpoint()
        yield set[str]().union(*met[max(0, k - SPREAD) : k + SPREAD + 1])


def _met(touches: Iterable[Touch], hand: set[str]) -> set[str]:
    pairs = [{HAND if thing_of(one) == "effector" else thing_of(one) for one in (t.a, t.b)} for t in touches]
    return set[str]().union(*(pair - {HAND} for pair in pairs if len(pair & hand) == 1))
