"""A node of the search, and how control steps are folded: the one place where the plan language meets the agenda.

The search works off the agenda from the front and appends steps. A compound that is decided at run time lies between marks
(``cramlite.flow``): where a branch begins a frame remembers the steps and the belief, and at the end what came since
becomes one control step. What a branch needs beyond that, a way back to where it began, is a motion like any other.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field
from msgspec.structs import replace

from .designators import Designator, Location, Motion, Place, Stand
from .errors import Unresolvable
from .flow import Mark, touched
from .program import Monitor, Parallel, Repeat, SetGripper, TryInOrder, clash, walk

if TYPE_CHECKING:
    from .belief import Belief
    from .designators import Action
    from .flow import Compound
    from .program import AnyStep, Control, Section

SAME = 0.02  # joint positions that are the same for what comes after [rad]: a motion begins from either
MOVED = 0.005  # things that are at the same place [m]: the accuracy with which let go things are known


class Effect(Struct, frozen=True):
    """Stands in the agenda behind an action's steps: its effects on the belief come about here."""

    action: Action


Item = Designator | Effect | Mark


class Frame(Struct, frozen=True):
    """A compound that is open: where the steps of each branch begin, and the beliefs before and after them."""

    compound: Compound
    starts: tuple[int, ...]
    begin: Belief
    ends: tuple[Belief, ...] = ()


class State(Struct, frozen=True):
    """A node of the search: what is done, and what is still to do.

    Args:
        grip: what was held when the last action of the plan ended.
        again: names of places that were bound before the grip last changed -> the how manieth the next one will be.
        stand: the place that the robot drove to last, by name; "" where it has not driven.
        stood: ``stand`` when the last action of the plan ended.
    """

    agenda: tuple[Item, ...]
    belief: Belief
    bindings: Mapping[str, Any] = field(default_factory=dict)
    steps: tuple[AnyStep, ...] = ()
    sections: tuple[Section, ...] = ()
    actions: tuple[Action, ...] = ()
    opened: Mapping[str, int] = field(default_factory=dict)
    motions: frozenset[str] = frozenset()
    choices: tuple[tuple[str, str], ...] = ()
    frames: tuple[Frame, ...] = ()
    grip: str = ""
    again: Mapping[str, int] = field(default_factory=dict)
    stand: str = ""
    stood: str = ""

    @property
    def folding(self) -> bool:
        """Whether what is resolved now will be part of a control step."""
        return any(f.compound.decided_at_run_time for f in self.frames)


def gripped(state: State, first: int = 0) -> State:
    """The state behind an action of the plan. If it took or let go of something, or drove, the places bound so far are
    history: the same thing stands elsewhere, or is held in another way, and whoever asks for its grasp again gets a new
    answer.

    Args:
        first: where the action's steps begin: it may have taken something and let go of it again.
    """
    held = state.belief.held.thing if state.belief.held else ""
    took = any(isinstance(s, SetGripper) and s.expect == "object" for s in walk(state.steps[first:]))
    if held == state.grip and not took and state.stand == state.stood:
        return state
    bound = Counter(k.split("#")[0] for k, v in state.bindings.items() if isinstance(v, Place | Stand))
    again = {name: count + 1 for name, count in bound.items()}
    return replace(state, grip=held, stood=state.stand, again=again)


def renewed(item: Item, state: State) -> Item:
    """A place, or a motion to one, under the name that it has since the grip changed."""
    if isinstance(item, Location):
        return _renewed(item, state)
    if isinstance(item, Motion) and item.to is not None:
        return replace(item, to=_renewed(item.to, state))
    return item


def _renewed(place: Location, state: State) -> Location:
    return replace(place, name=f"{place.name}#{state.again[place.name]}") if place.name in state.again else place


def passed(state: State, mark: Mark) -> State:
    """The state behind a mark that was at the front of the agenda.

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
        back = (_back(state, frame, f"back_{mark.branch}"),) if compound.kind == "attempts" else ()
        return replace(state, agenda=(*back, *rest), frames=(*state.frames[:-1], ended))
    if compound.kind == "repeat" and _differ(frame.begin, state.belief):
        return replace(state, agenda=(_back(state, frame, "back"), *state.agenda))
    return _folded(state, replace(frame, ends=(*frame.ends, state.belief)), rest)


def _back(state: State, frame: Frame, name: str) -> Motion:
    """The motion from anywhere on the latest branch to where the compound began."""
    return _motion_back(frame, name, state.steps[frame.starts[-1] :])


def _motion_back(frame: Frame, name: str, after: tuple[AnyStep, ...]) -> Motion:
    compound = frame.compound
    return Motion(
        compound.inside(name), "back", None, {"to": frame.begin, "after": after}, touched(compound), "to where it began"
    )


def _folded(state: State, frame: Frame, rest: tuple[Item, ...]) -> State:
    """The end of a compound: its steps become one, unless it was decided while planning."""
    closed = replace(state, agenda=rest, frames=state.frames[:-1])
    if not frame.compound.decided_at_run_time:
        return closed
    for k, (one, other) in enumerate(pairwise(frame.ends), 1):
        if frame.compound.kind == "attempts" and (why := _differ(one, other)):
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


def _control(compound: Compound, parts: tuple[tuple[AnyStep, ...], ...]) -> Control:
    name, p = compound.name, compound.parameters
    comment = compound.kind.replace("_", " ")
    if compound.kind == "attempts":
        return TryInOrder(parts, origin=name, comment=comment)
    if compound.kind == "repeat":
        return Repeat(parts[0], int(p["times"]), origin=name, comment=f"{p['times']:.0f} times")
    if compound.kind == "monitor":
        watched = (p.get("force_n"), p.get("slip_m"), p.get("time_s"))
        return Monitor(parts[0], *watched, origin=name, comment=comment)
    if wrong := clash(parts):
        raise Unresolvable(f"'{name}' cannot be done at the same time: {wrong}")
    return Parallel(parts, "all" if compound.kind == "parallel" else "first", origin=name, comment=comment)


def _differ(one: Belief, other: Belief) -> str:
    """What makes two beliefs different for what comes after; empty when nothing does."""
    apart = max((abs(a - b) for a, b in zip(one.joints, other.joints, strict=True)), default=0.0)
    held = [b.held.thing if b.held else "nothing" for b in (one, other)]
    if held[0] != held[1]:
        return f"'{held[0]}' is held after one, '{held[1]}' after the other"
    if apart > SAME:
        return f"a joint is {apart:.2f} rad apart, more than {SAME:.2f} rad"
    if abs(one.opening - other.opening) > MOVED:
        return f"the fingers are {1000 * one.opening:.0f} and {1000 * other.opening:.0f} mm open"
    if one.at != other.at:
        return "the robot stands elsewhere"
    for name in one.poses.keys() & other.poses.keys():
        if (way := math.dist(one.poses[name].pose.position, other.poses[name].pose.position)) > MOVED:
            return f"'{name}' is {1000 * way:.0f} mm apart"
    return "" if one.relations == other.relations else "what holds between things differs"
