"""Support detection in a rollout, from the force with which one thing pushes the other up."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from cramlite.model import GRAVITY, Event, Floats, Rollout, thing_of

from .entities import effectors
from .signals import GAP, Flags, close_gaps, hysteresis, moving_average, runs, spans
from .touches import CONTACT, Pair, state

#: Share of the supportee's weight that the supporter must carry to start and to keep a support.
SUPPORT = (0.3, 0.1)
#: What has moved by less than this stands where it stood [m]: pads that close lift by 0.1 mm (measured on blocks of 0.2 kg), and a
#: person's hand that holds still drifts by up to 1.4 mm (``DRIFT`` of the simulated person, on each of three axes).
STILL = 0.002
#: What was carried for this long stood there [s]; a held product that bumps on a peg leans on it for 0.1 s.
STOOD = 0.5


def carried(rollout: Rollout, pairs: dict[tuple[str, str], Pair]) -> dict[tuple[str, str], Flags]:
    """Return, for each pair of a body and a thing, whether the body carries the thing at each sample.

    The body may be a part of a thing; the thing that is carried is a whole one.

    A support begins and ends with a share of the weight, while they touch; and it goes on for as long as the thing stays
    where it stood, within ``STILL``: closing fingers that take the weight off a table have not lifted anything.
    """
    wholes: dict[tuple[str, str], list[Pair]] = defaultdict(list)
    for (a, b), pair in pairs.items():
        if not {thing_of(a), thing_of(b)} & {*effectors(rollout)}:
            wholes[a, thing_of(b)].append(pair)
    found = {}
    for (a, b), parts in wholes.items():
        weight = GRAVITY * (rollout.world.thing(b).mass or 0.0)
        if weight > 0:
            lift = moving_average(np.sum([p.lift for p in parts], axis=0), rollout.times, GAP / 3)
            least = min(CONTACT[0], SUPPORT[0] * weight)  # a bowl of 2 g rests with less than counts as a touch of heavier things
            touching = close_gaps(hysteresis(np.sum([p.force for p in parts], axis=0), least, CONTACT[1]), rollout.times)
            on = touching & hysteresis(lift, SUPPORT[0] * weight, SUPPORT[1] * weight)
            found[a, b] = _until_moved(on, rollout.poses[b][:, :3] - rollout.poses[thing_of(a)][:, :3], rollout.times)
    return found


def _until_moved(on: Flags, offset: Floats, times: Floats) -> Flags:
    """Support flags that, once true for at least STOOD, stay true until the relative position (N, 3) has
    changed by more than STILL."""
    kept = on.copy()
    for start, end in runs(on):
        if times[end - 1] - times[start] < STOOD:
            continue
        away = np.linalg.norm(offset[end:] - offset[end - 1], axis=1) > STILL
        kept[end : end + (int(np.argmax(away)) if away.any() else len(away))] = True
    return kept


def supports(rollout: Rollout, carries: dict[tuple[str, str], Flags]) -> list[Event]:
    """Return the support states of a rollout."""
    return [
        state("soma:SupportState", span, {"supporter": a, "supportee": b})
        for (a, b), flags in carries.items()
        for span in spans(flags, rollout.times)
    ]
