"""Contacts by the wrist's force sensor where simulated contacts chatter: a hand that presses on all the while has not let go."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from cramlite.model import Rollout

from .signals import Flags, close_gaps, runs

#: Gaps shorter than this may be chatter [s]: a slide of a program, too, counts a contact as lost after 0.5 s (``lost_s``).
CHATTER = 0.5
#: All through the gap the hand applies more than this [N], measured at the wrist. Finger tips that slide on a plate, pressed
#: on with 12 N, have single contacts of 0 and 50 N in turn, sampled at 50 Hz, and 12 to 15 N at the wrist all the time.
PRESSED = 5.0

Pairs = Mapping[tuple[str, str], Flags]


def pressed_on(contacts: Pairs, rollout: Rollout) -> dict[tuple[str, str], Flags]:
    """Close the gaps in contacts of the effector in which the wrist felt it press on, while it touched nothing else.

    Args:
        contacts: pair of entities -> whether they touch, per sample.
        rollout: its ``wrench`` is what the effector applies, without the gripper's own weight.
    """
    force = np.linalg.norm(rollout.wrench[:, :3], axis=1)
    mine = {pair: on for pair, on in contacts.items() if rollout.effector in pair}
    found = dict(contacts)
    for pair, on in mine.items():
        filled = close_gaps(on, rollout.times)
        others = [o for other, o in mine.items() if other != pair]
        for (_, end), (start, _) in pairwise(runs(on)):
            alone = not any(o[end - 1 : start + 1].any() for o in others)
            short = rollout.times[start] - rollout.times[end - 1] < CHATTER
            filled[end:start] |= bool(short and alone and (force[end:start] > PRESSED).all())
        found[pair] = filled
    return found
