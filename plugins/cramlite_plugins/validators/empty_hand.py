"""Explanation for hands from robot files that closed without a thing: the finding, and the keys of a
scenario that may be wrong."""

from __future__ import annotations

from cramlite.model import SetGripper, enclosing_names, walk
from cramlite.plugin import Candidate

from .grips import OPENED
from .task_times import origins

KEYS = "this hand is from a file: 'pads' and 'tcp' of 'gripper' say where it grips, 'pad_friction' of 'physics' how well it holds"


def closed_on_nothing(candidate: Candidate, sample: int) -> str:
    """Describe a hand from a robot file that was to grasp a thing and closed on nothing; "" otherwise.

    Args:
        sample: at which the run ended.
    """
    rollout = candidate.ran
    if candidate.robot.gripper.linkage is None:
        return ""
    by = origins(candidate)[sample]
    orders = [s for s in walk(candidate.program.steps) if isinstance(s, SetGripper) and s.origin == by and s.expect == "object"]
    wide = float(rollout.opening[sample])
    if not orders or wide > orders[-1].opening + OPENED:
        return ""
    thing = next((h.thing for h in candidate.handovers or () if h.taken and h.by in enclosing_names(by)), "")
    return f"the hand closed to {1000 * wide:.0f} mm{f' without {thing!r}' if thing else ' on nothing'}; {KEYS}"
