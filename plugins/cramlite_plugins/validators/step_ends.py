"""End positions of steps that feel contact: guarded motions, searches, insertions and extractions,
compared with the ranges that they were planned with."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cramlite.model import (
    AnyStep,
    Floats,
    ForceExtract,
    ForceInsert,
    MoveLinear,
    MoveUntilContact,
    Pose,
    Rollout,
    SpiralSearch,
)
from cramlite.plugin import Candidate

from .contact_force import SPREAD, touched_at
from .grips import held_at

SHARE = 0.4
"""Least share of its way that an insertion or extraction covers: a thing may hang on the outer half of its peg."""
OFF = 0.01
"""Largest deviation of a hand from its commanded position [m]: a moving hand lags by up to 5 mm, and an arm's own errors are below 1 mm."""
GAVE_WAY = 0.5
"""Least advance of a search that has found a hole, as a share of the planned advance: a sample may miss the last millimetre."""
RIM = 1.8
"""Force at which a rim holds the tool, as a multiple of a search's pressing force: the search ends at twice that,
and a sample may miss the peak."""


def wrong_end(candidate: Candidate, steps: Sequence[AnyStep], samples: Sequence[int]) -> str:
    """Describe the fault in the end of a step that feels contact; "" for a step without a fault, and for all other steps.

    Args:
        steps: the step as the last one, after those of the same designator.
        samples: the first at which their code ran, and the one after the last.
    """
    ends: Mapping[type[Any], Callable[[_Run, Any], str]] = {
        MoveUntilContact: _guarded, SpiralSearch: _searched, ForceInsert: _inserted, ForceExtract: _extracted,
    }  # fmt: skip
    end = ends.get(type(steps[-1]))
    if end is None:
        return ""
    first, last = samples
    if first == last:
        return "none of its code ran"
    tools = np.array([_position(candidate, row) for row in candidate.ran.joints[first : last + 1]])
    return end(_Run(candidate.ran, steps[:-1], tools, first, last), steps[-1])


class _Run(NamedTuple):
    """Execution of one step in a rollout: its samples, and the positions of the tool.

    Args:
        before: steps of the same designator.
        tools: where the tool was (N, 3) [m].
        first, last: samples of the run.
    """

    rollout: Rollout
    before: Sequence[AnyStep]
    tools: Floats
    first: int
    last: int


def _position(candidate: Candidate, joints: Sequence[float]) -> Floats:
    from ..kinematics.forward import forward

    return np.asarray(forward(candidate.robot, tuple(joints)).position)


def _guarded(run: _Run, step: MoveUntilContact) -> str:
    """Describe a guarded motion that ended without a contact, or beyond its range; "" if it ended at a
    contact, or at the range's end where none is expected."""
    touched, way = list(touched_at(run.rollout, held_at(run.rollout))), np.array(step.direction)
    gone = float((run.tools[-1] - run.tools[0]) @ way)
    known = [np.array(s.target.position) for s in run.before[-1:] if isinstance(s, MoveLinear) and not s.relative]
    start = known[0] if known else run.tools[0]
    beyond = float((run.tools[-1] - start) @ way) - step.distance
    if beyond > OFF and (known or not run.before):
        return f"it went on {1000 * beyond:.0f} mm beyond the end of its range of {1000 * step.distance:.0f} mm"
    if any(touched[run.last - SPREAD : run.last + SPREAD + 1]) or (step.expect == "any" and gone > step.distance - OFF):
        return ""
    return f"it ended after {1000 * gone:.0f} of at most {1000 * step.distance:.0f} mm without a contact"


def _searched(run: _Run, step: SpiralSearch) -> str:
    """Describe why a spiral search by touch failed: it left its radius, or the tool met neither a hole nor a rim; "" if it succeeded."""
    axis, ways = _axis(step.frame), run.tools - run.tools[0]
    aside = float(np.linalg.norm(ways[-1] - (ways[-1] @ axis) * axis))
    if aside > step.radius + OFF:
        return f"it ended {1000 * aside:.0f} mm from where it began; its search radius is {1000 * step.radius:.0f} mm"
    force = float(run.rollout.contact_force()[run.first : run.last + 1].max())
    advance = float((ways @ axis).max())
    if advance > GAVE_WAY * step.advance or force > RIM * step.force:
        return ""
    return f"the tool gave way by {1000 * advance:.1f} of {1000 * step.advance:.1f} mm, and no rim held it"


def _inserted(run: _Run, step: ForceInsert) -> str:
    gone = float((run.tools[-1] - run.tools[0]) @ _axis(step.frame))
    if gone > step.depth + OFF:
        return f"it was pushed in by {1000 * gone:.0f} mm, more than its depth of {1000 * step.depth:.0f} mm"
    return _covered(gone, step.depth)


def _extracted(run: _Run, step: ForceExtract) -> str:
    return _covered(float((run.tools[-1] - run.tools[0]) @ _axis(step.frame)), step.way)


def _covered(gone: float, way: float) -> str:
    if gone >= SHARE * way:
        return ""
    return f"it covered {1000 * max(gone, 0.0):.0f} of {1000 * way:.0f} mm, and at least {SHARE:.0%} of this way are needed"


def _axis(frame: Pose) -> Floats:
    return np.asarray(frame.rotate((0.0, 0.0, 1.0)))
