"""Validator of grip strength: whether the pads could carry the weight of each thing that slipped."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from cramlite.model import GRAVITY, Held, Pose, Rollout, SetGripper, Value, walk
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from ..motions.grip_force import ACCELERATION, MARGIN, GripLoad, grip_of
from . import grips as hand
from .physics import SLIP
from .swings import Turn, declared
from .task_times import origins

SOON = 0.5  # after the pads last pressed a thing that was lost, the fingers go on to close [s]


class GripStrength(Value):
    """Check that a thing that slipped was gripped strongly enough for its weight; things that did not slip
    are not judged."""

    name: str = "grip_strength"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        came_from, turns = origins(candidate), declared(candidate)
        closings = {s.origin: s for s in walk(candidate.program.steps) if isinstance(s, SetGripper)}
        for found in hand.grips(rollout):
            step = closings.get(next((o for o in came_from[found.first :: -1] if o in closings), ""))  # the last one by then
            if step is None or not _lost(rollout, found, turns):
                continue
            grip = grip_of(Held(found.thing, Pose(), 0.0), candidate.world, candidate.robot.gripper)
            carried, weight = 2 * grip.friction * step.force, GRAVITY * grip.mass
            if carried < weight:
                said = f"'{found.thing}' slipped: {explained(grip, step.force)}"
                yield Finding(self.name, False, said, carried, weight, "N", step.origin, things=True)


def explained(grip: GripLoad, force: float) -> str:
    """Explain in words that a force of each pad [N] does not carry a weight, and which force would."""
    low, high = grip.gripper.force
    carried = f"{force:g} N on each pad carry {2 * grip.friction * force:.1f} N of {grip}"
    if not grip.friction:
        return f"{carried}; no force does"
    just = GRAVITY * grip.mass / (2 * grip.friction)
    return (
        f"{carried}; {just:.0f} N just carry it, {grip.least:.0f} N with a margin of {MARGIN:g} and {ACCELERATION:g} m/s2 of the arm"
        f" (gripper '{grip.gripper.type}': {low:g} .. {high:g} N)"
    )


def _lost(rollout: Rollout, grip: hand.Grip, turns: Sequence[Turn]) -> bool:
    """Whether a thing slid in the hand, or the fingers closed further after losing it."""
    if hand.slip(rollout, grip, turns).max() > SLIP:
        return True
    soon = int(np.searchsorted(rollout.times, rollout.times[grip.last] + SOON))
    wide = float(np.median(rollout.opening[grip.first : grip.last + 1]))
    return bool(rollout.opening[grip.last : soon + 1].min() < wide - hand.OPENED)


@hookimpl
def validators() -> Iterable[Validator]:
    return [GripStrength()]
