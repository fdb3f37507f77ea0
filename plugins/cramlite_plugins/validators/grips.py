"""Grips of a run: their time spans, their payloads, and the slip of payloads in the hand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cramlite.model import Floats, Rollout, Touch, seen_from, thing_of
from cramlite.plugin import checkpoint

from ..shapes.itself import Itself
from .swings import Turn, off

SHORTEST = 0.2  # both pads on a thing for less is a brush in passing [s]
SHUT = 0.001  # fingers that are closer have nothing between them: they push, or slide along a surface [m]
OPENED = 0.002  # fingers that are wider apart than they held a thing have let it go [m]


class Grip(NamedTuple):
    """Grip of a thing by the hand, from its first to its last sample."""

    thing: str
    first: int
    last: int


def grips(rollout: Rollout) -> list[Grip]:
    """Return every stretch in which both pads press one thing, at least ``SHORTEST`` long. Pads that lose a thing and press it
    again without having opened are one grip: it slipped."""
    found: list[Grip] = []
    for grip in _pressings(rollout):
        before = found[-1] if found else None
        if before and before.thing == grip.thing and not _opened(rollout, before, grip.first):
            found[-1] = Grip(grip.thing, before.first, grip.last)
        elif rollout.times[grip.last] - rollout.times[grip.first] >= SHORTEST:
            found.append(grip)
    return found


def pressed_at(rollout: Rollout) -> list[str]:
    """Return the thing that both pads press at each sample, even if they press it only briefly; "" for none, a
    fixed thing or shut fingers."""
    return list(_pressed_at(Itself(rollout)))


@lru_cache(maxsize=1)
def _pressed_at(run: Itself[Rollout]) -> tuple[str, ...]:
    """Thing that both pads press at each sample, as ``pressed_at`` returns it; computed once for each run."""
    rollout = run.it
    loose = {t.name for t in rollout.world.things if t.movable or t.joint}
    pressed = zip(map(_pressed, rollout.awake_touches), rollout.opening, strict=True)
    return tuple(thing if thing in loose and wide > SHUT else "" for thing, wide in pressed)


def held_at(rollout: Rollout) -> list[str]:
    """Return the payload at each sample; "" for none."""
    held = [""] * len(rollout.times)
    for thing, first, last in grips(rollout):
        held[first : last + 1] = [thing] * (last + 1 - first)
    return held


def _pressings(rollout: Rollout) -> Iterator[Grip]:
    """Stretches in which both pads press the same thing, however short."""
    pressed, start = pressed_at(rollout), 0
    for k in range(1, len(pressed) + 1):
        if k == len(pressed) or pressed[k] != pressed[start]:
            if pressed[start]:
                yield Grip(pressed[start], start, k - 1)
            start = k


def _opened(rollout: Rollout, grip: Grip, until: int) -> bool:
    """Whether the fingers opened between a grip and a later sample."""
    held = float(np.median(rollout.opening[grip.first : grip.last + 1]))
    return bool(rollout.opening[grip.last : until + 1].max() > held + OPENED)


def _pressed(touches: Iterable[Touch]) -> str:
    checkpoint()
    sides: dict[str, set[str]] = {"effector/left": set(), "effector/right": set()}
    for touch in touches:
        for pad, other in ((touch.a, touch.b), (touch.b, touch.a)):
            if pad in sides:
                sides[pad].add(thing_of(other))
    both = (sides["effector/left"] & sides["effector/right"]) - {"effector"}
    return min(both, default="")


def slip(rollout: Rollout, grip: Grip, turns: Sequence[Turn] = ()) -> Floats:
    """Return how far a thing has slipped in the hand since its grasp, at each sample [m].

    Turns in the hand that the program declares do not count.

    The first and last tenth of a second are left out: fingers that close or open push a thing.
    """
    step = float(np.median(np.diff(rollout.times)))
    margin = min(int(0.1 / step), (grip.last - grip.first) // 3)
    rows = slice(grip.first + margin, grip.last - margin + 1)
    hand, thing = rollout.poses["effector"][rows], rollout.poses[grip.thing][rows]
    local = seen_from(hand, thing[:, :3])
    return off(local, grip.first + margin, turns)
