"""Motions about a thing's own place that demonstrations share: the held thing goes to and fro, wherever it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from ..base.value import Value
from ..interpretation.in_place import direction, strokes_along, tracked
from ..interpretation.path_predicate import related
from ..model.geometry import Floats
from ..model.shown_path import Anchor, ShownPath, length, resampled
from .repeated import ROUND
from .shown_motion import AGREED, ENOUGH, EXACT, HELD, SIGMAS, WIDEST, ShownMotion, cornered
from .span import Span

ROUNDS = 2.0
"""Least number of round trips of a motion to and fro: a single round trip may just bring a thing and take it away."""
LEANS = 0.35
"""Largest difference between the examples' swing directions in their angle to the vertical [rad]: each person's swings vary by 10 deg each
way."""


class _Swing(Value, eq=False):
    """To-and-fro motion of a thing in one example: its mean round trip, deviation from it, number of round trips,
    speed, and angle between its direction and the vertical."""

    places: Floats
    spread: float
    count: float
    speed: float
    lean: float


def shown_swing(spans: Sequence[Span]) -> ShownMotion | None:
    """Return the motion to and fro about its own place of a thing that is held in all examples; None if there is none."""
    found = [m for movers in _movers(spans) if (m := _of_movers(spans, movers)) is not None]
    return min(found, key=lambda m: m.spread, default=None)


def _movers(spans: Sequence[Span]) -> Iterator[tuple[str, ...]]:
    """Yield for each example a thing that is held throughout it."""
    each = []
    for span in spans:
        times = np.linspace(span.start, span.end, 50)[:-1]
        each.append([n for n in span.things if span.effector and related(span.timeline.episode, span.effector, n, times).mean() >= HELD])
    yield from product(*each)


def _of_movers(spans: Sequence[Span], movers: tuple[str, ...]) -> ShownMotion | None:
    known = [s for span, mover in zip(spans, movers, strict=True) if (s := _swing(span, mover)) is not None]
    if len(known) < len(spans) or np.ptp([s.lean for s in known]) > LEANS:
        return None
    each = np.array([s.places - s.places.mean(axis=0) for s in known])
    mean = each.mean(axis=0)
    size = float(np.ptp(mean, axis=0).max())
    spread = float(np.sqrt(((each - mean) ** 2).sum(axis=2).mean() + np.mean([s.spread**2 for s in known])))
    if spread > WIDEST * size:
        return None
    counts = tuple(round(s.count, 2) for s in known)
    ring = np.vstack([mean, mean[:1]]) - mean[0]
    points = (np.round(ring[cornered(ring, max(spread, EXACT))[:-1]], 4) + 0.0).tolist()
    path = ShownPath(
        tuple((x, y, z) for x, y, z in points), Anchor(own=True), times=max(round(float(np.median(counts))), 1),
        least=max(round(ENOUGH * min(counts), 1), ROUNDS), tolerance=round(min(SIGMAS * spread, AGREED * size), 4), closed=True,
        stand_off=0.0, speed=round(float(np.median([s.speed for s in known])), 3),
    )  # fmt: skip
    return ShownMotion(path, tuple((m, m) for m in movers), spread, counts, True)


def _swing(span: Span, mover: str) -> _Swing | None:
    """Return the mean round trip of a thing that moves to and fro in an example, rotated about the vertical to lie
    along the x axis; None if the thing does not move so."""
    found = tracked(span.timeline.episode, mover, (span.start, span.end))
    if found is None:
        return None
    times, points = found
    axis = direction(points)
    strokes = strokes_along(times, points @ axis)
    if strokes is None or strokes.rounds < ROUNDS:
        return None
    low = 0 if points[strokes.turns[0]] @ axis < points[strokes.turns[1]] @ axis else 1
    each = [_closed(points[a : b + 1]) for a, b in zip(strokes.turns[low::2], strokes.turns[low + 2 :: 2], strict=False)]
    turned = np.array(each) @ _heading(axis)
    mean = turned.mean(axis=0)
    centred = turned - turned.mean(axis=1, keepdims=True)
    spread = float(np.sqrt(((centred - centred.mean(axis=0)) ** 2).sum(axis=2).mean()))
    speed = length(np.vstack([mean, mean[:1]])) / (2 * strokes.seconds)
    return _Swing(mean, spread, strokes.rounds, speed, float(np.arccos(np.clip(axis[2], -1.0, 1.0))))


def _closed(places: Floats) -> Floats:
    """Return ROUND positions (ROUND, 3) along one cycle of a swinging motion, corrected for drift so that it
    ends where it begins [m]."""
    even = resampled(places, ROUND + 1)
    return np.asarray(even - np.linspace(0.0, 1.0, ROUND + 1)[:, None] * (even[-1] - even[0]))[:-1]


def _heading(axis: Floats) -> Floats:
    """Return the matrix that turns row vectors about the vertical so that a direction's horizontal part is along x."""
    angle = float(np.arctan2(axis[1], axis[0]))
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
