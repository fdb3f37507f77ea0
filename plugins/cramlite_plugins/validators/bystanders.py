"""Bystanders: things that no task moves keep their place, upright and still, whatever is moved around them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Remedy, Rollout, Thing, Value, rotations, seen_from
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from ..shapes.bounds import box_around
from .grips import held_at
from .movers import Moved, moved_by
from .rest import borne_by, hangs, restless
from .task_times import inner_tasks

_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


class Stay(NamedTuple):
    """Displacement of a thing while no task moves it.

    Args:
        way: of the point of it that got furthest [m], at ``sample``.
        tilt: how far it leant over [rad], at ``leant``.
        beside: what carried it along, so that both are measured in its frame; "" for the world.
    """

    way: float
    sample: int
    tilt: float
    leant: int
    beside: str


class Bystanders(Value):
    """Check that movable things keep within the limits of motion and tilt while no task moves them
    (``moved_by``), or, if they must keep their place, always; and are at rest at the end."""

    name: str = "bystanders"
    cost: Cost = "rollout"
    may_advise: bool = True  # whoever judges a goal elsewhere may not mind what became of other things

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        moved, tasks, kept = moved_by(candidate), inner_tasks(candidate), dict(candidate.limits.keep)
        moved = moved | {n: ["" if task == "" else None for task in moved[n]] for n in kept if n in moved}
        worst: tuple[float, str] = (0.0, "")
        for thing in rollout.world.things:
            if not (thing.movable or thing.joint):
                continue
            for stay in stays(rollout, thing, moved):
                wrong = list(_objections(candidate, thing.name, stay, tasks, self.name))
                yield from wrong
                worst = worst if thing.name in kept else max(worst, (stay.way, thing.name))
                if wrong:
                    break
        yield from self._at_rest(candidate, rollout)
        limit, whose = candidate.limits.bystander_motion, candidate.limits.source("bystander_motion")
        if worst[0] <= limit:
            what = f"'{worst[1]}' moved furthest of all things that no task moves, {1000 * worst[0]:.1f} mm"
            what = what if worst[1] else "nothing to move"
            yield Finding(self.name, True, f"{what}, limit {1000 * limit:g} mm {whose}", worst[0], limit, "m")

    def _at_rest(self, candidate: Candidate, rollout: Rollout) -> Iterator[Finding]:
        held, last = held_at(rollout)[-1], len(rollout.times) - 1
        loose = (t.name for t in rollout.world.things if (t.movable or t.joint) and t.name != held)
        for name in loose:
            if wrong := restless(rollout, name, hanging=hangs(rollout, name, last)):
                yield Finding(self.name, False, wrong)


def _objections(candidate: Candidate, name: str, stay: Stay, tasks: list[str], validator: str) -> Iterator[Finding]:
    limits, times = candidate.limits, candidate.ran.times
    most, key = limits.motion_of(name)
    who = f"'{name}', which {'must keep its place' if key == 'keep' else 'no task moved then'},"
    than = f" on '{stay.beside}', which carries it," if stay.beside else ""
    if stay.way > most:
        whose = f"limit {1000 * most:g} mm {limits.source(key)}"
        said = f"{who} was {1000 * stay.way:.0f} mm from its place{than} at {times[stay.sample]:.1f} s; {whose}"
        let = _let(candidate, name, key, 1000 * stay.way, "mm")
        yield Finding(validator, False, said, stay.way, most, "m", tasks[stay.sample], remedy=let)
    if stay.tilt > limits.bystander_tilt:
        whose = f"limit {np.degrees(limits.bystander_tilt):g} deg {limits.source('bystander_tilt')}"
        said = f"{who} leant over by {np.degrees(stay.tilt):.0f} deg{than} at {times[stay.leant]:.1f} s; {whose}"
        let = _let(candidate, name, "bystander_tilt", float(np.degrees(stay.tilt)), "deg")
        yield Finding(validator, False, said, stay.tilt, limits.bystander_tilt, "rad", tasks[stay.leant], remedy=let)


def _let(candidate: Candidate, name: str, key: str, value: float, unit: str) -> Remedy | None:
    """Return the advice for a thing that moved though no task moves it: put it farther from the others, or
    permit it to move that far; None for a payload of the plan, whose grasp failed, unless it must keep its place.

    Args:
        key, unit: of the limit in a scenario.
        value: that the limit must be to let it [unit].
    """
    if key != "keep" and any(h.thing == name for h in candidate.handovers or ()):
        return None
    amount = f"{math.ceil(value)} {unit}"
    let = f"'limits: {{{key}: {f'{{{name}: {amount}}}' if key == 'keep' else amount}}}' in the scenario"
    says = f"'{name}' moves though no task moves it: put it farther from other things, or, if its motion does no harm, permit it by {let}"
    return Remedy(f"{key} {name}", says, value)


def stays(rollout: Rollout, thing: Thing, moved: Moved) -> Iterator[Stay]:
    """Yield the displacement of a thing in each stretch of the run in which no task moves it.

    It is measured from the thing's pose at the beginning of the stretch. Of a hanging thing only the hole
    must keep its place; the rest may swing up to the limit of tilt.
    """
    for nobody, stretch in groupby(range(len(rollout.times)), key=lambda k: moved[thing.name][k] is None):
        rows = list(stretch)
        if nobody:
            points = _watched(thing, hanging=hangs(rollout, thing.name, rows[0]))
            frames = ("", *_carriers(rollout, thing, rows[0], moved))
            found = (_measured(rollout, thing.name, points, rows[0], rows[-1] + 1, frame) for frame in frames)
            yield min(found, key=lambda s: (s.way, s.tilt))


def _watched(thing: Thing, *, hanging: bool) -> Floats:
    """Points (P, 3) of a thing whose displacement is measured, in its frame [m]: the corners of the box
    around it, or its hole."""
    hole = thing.feature("vrps:Hole") if hanging else None
    low, high = box_around(thing.geoms)
    return np.array([hole.pose.position]) if hole else low + _CORNERS * (high - low)


def _carriers(rollout: Rollout, thing: Thing, sample: int, moved: Moved) -> list[str]:
    """Things that carry a thing at a sample, directly or through others, and that some task moves.

    For a spoon in a bowl in a drawer that is opened, that is the drawer.
    """
    found, new, names = list[str](), [thing.name], {t.name for t in rollout.world.things}  # a hand bears things, too
    while new:
        borne = [o for n in new if rollout.world.thing(n).movable for o in borne_by(rollout, n, sample)]
        new = [o for o in borne if o in names and o not in found]
        found += dict.fromkeys(new)
    return [other for other in found if any(moved.get(other, ()))]


def _measured(rollout: Rollout, thing: str, points: Floats, first: int, last: int, frame: str) -> Stay:
    track = rollout.poses[thing][first:last]
    turns, places, vertical = rotations(track[:, 3:]), track[:, :3], np.array([0.0, 0.0, 1.0])
    if frame:
        about = rollout.poses[frame][first:last]
        back = rotations(about[:, 3:]).transpose(0, 2, 1)
        turns, places, vertical = back @ turns, seen_from(about, places), back[0] @ vertical
    ways = np.max([np.linalg.norm((p := turns @ c + places) - p[0], axis=1) for c in points], axis=0)
    up = vertical @ turns
    tilts = np.arccos(np.clip(up @ up[0], -1.0, 1.0))
    k, j = int(np.argmax(ways)), int(np.argmax(tilts))
    return Stay(float(ways[k]), first + k, float(tilts[j]), first + j, frame)


@hookimpl
def validators() -> Iterable[Validator]:
    return [Bystanders()]
