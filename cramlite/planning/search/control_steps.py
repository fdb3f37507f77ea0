"""Conversion of control structures that are decided at run time (compounds) into control steps of the program.

A compound that is decided at run time lies between marks (``cramlite.model.control_flow``): where a branch begins a frame remembers the
steps and the belief, and at the end what came since becomes one control step. What a branch needs beyond that, a way back
to where it began, is a motion like any other.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.errors import Unresolvable
from ...model.control_flow import Mark, touched
from ...model.designators import Motion
from ...model.program.steps import Fallback, Monitor, Parallel, Repeat, branch_conflict
from .state import Frame, Item, State

if TYPE_CHECKING:
    from ...model.belief import Belief
    from ...model.control_flow import Compound
    from ...model.program.steps import AnyStep, Control

SAME = 0.02  # joint positions that are the same for what comes after [rad]: a motion begins from either
MOVED = 0.005  # things that are at the same place [m]: the accuracy with which let go things are known


def state_after_mark(state: State, mark: Mark) -> State:
    """Return the search state after a mark in its agenda: a mark is where a branch of a control structure begins, or where the structure
    ends.

    Raises:
        Unresolvable: branches do not end at the same place, or need the same device at the same time.
    """
    rest, compound = state.agenda[1:], mark.compound
    if mark.branch == 0:
        frame = Frame(compound, (len(state.steps),), state.belief)
        return replace(state, agenda=rest, frames=(*state.frames, frame))
    frame = state.frames[-1]
    if mark.branch < len(compound.branches):
        ended = replace(frame, starts=(*frame.starts, len(state.steps)), ends=(*frame.ends, state.belief))
        back = (_back(state, frame, f"back_{mark.branch}"),) if compound.kind == "fallback" else ()
        return replace(state, agenda=(*back, *rest), frames=(*state.frames[:-1], ended))
    if compound.kind == "repeat" and _differ(frame.begin, state.belief):
        return replace(state, agenda=(_back(state, frame, "back"), *state.agenda))
    return _folded(state, replace(frame, ends=(*frame.ends, state.belief)), rest)


def _back(state: State, frame: Frame, name: str) -> Motion:
    """Return the motion that leads the arm back to where a control structure began, from any pose on its last
    planned branch."""
    return _motion_back(frame, name, state.steps[frame.starts[-1] :])


def _motion_back(frame: Frame, name: str, after: tuple[AnyStep, ...]) -> Motion:
    compound = frame.compound
    return Motion(
        compound.inside(name), "back", None, {"to": frame.begin, "after": after}, touched(compound), "to where it began"
    )


def _folded(state: State, frame: Frame, rest: tuple[Item, ...]) -> State:
    """Return the search state after a control structure: its steps are put into one program step if it is
    decided at run time."""
    closed = replace(state, agenda=rest, frames=state.frames[:-1])
    if not frame.compound.decided_at_run_time:
        return closed
    for k, (one, other) in enumerate(pairwise(frame.ends), 1):
        if frame.compound.kind == "fallback" and (why := _differ(one, other)):
            raise Unresolvable(f"attempts {k} and {k + 1} of '{frame.compound.name}' end in different ways: {why}")
    cuts = (*frame.starts, len(state.steps))
    parts = tuple(state.steps[a:b] for a, b in pairwise(cuts))
    steps = state.steps[: frame.starts[0]]
    if any(parts):
        steps = (*steps, _control(frame.compound, parts))
    if frame.compound.kind == "try_all":
        back = _motion_back(frame, "back", tuple(s for part in parts for s in part))
        return replace(closed, agenda=(back, *rest), steps=steps)
    return replace(closed, steps=steps)


SAID = {
    "fallback": "one after the other, until one succeeds", "parallel": "at the same time, until all are done",
    "try_all": "at the same time, until one succeeds", "monitor": "watched all the while",
}  # fmt: skip
"""Comments in a program that explain its control steps to people."""


def _control(compound: Compound, parts: tuple[tuple[AnyStep, ...], ...]) -> Control:
    name, p = compound.name, compound.parameters
    comment = SAID.get(compound.kind, "")
    if compound.kind == "fallback":
        return Fallback(parts, origin=name, comment=comment)
    if compound.kind == "repeat":
        return Repeat(parts[0], int(p["times"]), origin=name, comment=f"{p['times']:.0f} times")
    if compound.kind == "monitor":
        watched = (p.get("force_n"), p.get("slip_m"), p.get("time_s"))
        return Monitor(parts[0], *watched, origin=name, comment=comment)
    if wrong := branch_conflict(parts):
        raise Unresolvable(f"the branches of '{name}' cannot run at the same time: {wrong}")
    return Parallel(parts, "all" if compound.kind == "parallel" else "first", origin=name, comment=comment)


def _differ(one: Belief, other: Belief) -> str:
    """Return the first difference of two beliefs that later tasks would notice, in words; "" if there is none."""
    apart = max((abs(a - b) for a, b in zip(one.joints, other.joints, strict=True)), default=0.0)
    held = [b.held.thing if b.held else "nothing" for b in (one, other)]
    if held[0] != held[1]:
        return f"'{held[0]}' is held after one attempt, '{held[1]}' after the other"
    if apart > SAME:
        return f"a joint differs by {apart:.2f} rad, more than {SAME:.2f} rad"
    if abs(one.opening - other.opening) > MOVED:
        return f"the fingers are {1000 * one.opening:.0f} mm open after one attempt, {1000 * other.opening:.0f} mm after the other"
    if one.at != other.at:
        return "the robot stands elsewhere"
    for name in one.poses.keys() & other.poses.keys():
        if (way := math.dist(one.poses[name].pose.position, other.poses[name].pose.position)) > MOVED:
            return f"the attempts leave '{name}' at places that are {1000 * way:.0f} mm apart"
    return "" if one.relations == other.relations else "what holds between things differs"
