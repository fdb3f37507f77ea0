"""Grasps inferred from poses alone: a thing that moves, and keeps its place in a moving hand, is held by it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from cramlite.model import Episode, Value

from .co_motion import STEADY, STEP, Grid, Span, at_its_place, carried_spans
from .signals import close_gaps, runs

#: Lifted: this much higher than where it stood [m].
LIFTED = 0.02
#: A hand this near to where it holds a thing [m] is at the thing.
AT_HAND = 0.05
#: Of a hand that nobody saw: pauses up to the first belong to one motion; it is at the thing for the second before and
#: after it moves. A thing that pauses in the air up to the third is still in the hand, seen or not [s].
UNSEEN = (0.5, 0.3, 5.0)


class InferredGrasp(Value):
    """Grasp that was inferred because hand and thing moved together.

    Args:
        hand, thing: who holds what.
        span: from when the thing begins to move until it rests.
        near: from when the hand is at the thing until it leaves it.
        lift, down: when it leaves what it stands on, and when it stands again; None if never.
    """

    hand: str
    thing: str
    span: Span
    near: Span
    lift: int | None
    down: int | None


def grasps_of_hand(episode: Episode, grid: Grid, hand: str, things: Sequence[str]) -> tuple[list[InferredGrasp], dict[str, set[str]]]:
    """Grasps of one hand; and the things that ride on each payload (payload -> names).

    Of several things that move with the hand at the same time, only one is held; the others ride on it.
    """
    spans = [(s, _held_on(grid, n, hand, s, e), n) for n in things for s, e in _in_the_air(grid, n, hand)]
    held: list[InferredGrasp] = []
    riding: dict[str, set[str]] = defaultdict(set)
    for s, e, name in sorted(spans, key=lambda span: _carries(episode, grid, hand, span)):
        over = next((g for g in held if overlap((s, e), g.span) > 0.5 * min(e - s, g.span[1] - g.span[0])), None)
        if over is None:
            held.append(_grip(grid, hand, name, (s, e)))
        elif over.thing != name:
            riding[over.thing].add(name)
    return held, riding


def _in_the_air(grid: Grid, thing: str, hand: str) -> list[Span]:
    """Spans in which a hand carries a thing; two spans are joined if the thing stays lifted between them and
    has the same position relative to the hand."""
    found: list[Span] = []
    place, height = grid.place(thing, hand), grid.poses[thing][:, 2]
    for start, end in carried_spans(grid, thing, hand):
        if found and (start - found[-1][1]) * STEP < UNSEEN[2]:
            first, before = found[-1]
            off = np.median(place[first:before], axis=0) - np.median(place[start:end], axis=0)
            if np.linalg.norm(off) < STEADY and height[before:start].min(initial=np.inf) > height[first] + LIFTED:
                found[-1] = (first, end)
                continue
        found.append((start, end))
    return found


def _held_on(grid: Grid, thing: str, hand: str, start: int, end: int) -> int:
    """End index of a hold: the end of the recording if the thing is lifted and keeps its position in the hand
    until then, else ``end``."""
    until = at_its_place(grid, thing, hand, (start, end), AT_HAND)[1]
    up = grid.poses[thing][end - 1 :, 2] > grid.poses[thing][start, 2] + LIFTED
    return until if until == len(grid.times) and bool(up.all()) else end


def overlap(one: Span, other: Span) -> int:
    return min(one[1], other[1]) - max(one[0], other[0])


def _carries(episode: Episode, grid: Grid, hand: str, span: tuple[int, int, str]) -> tuple[float, float, float]:
    """Sort key that puts the most likely payload first: the larger thing, then the one that moves less in the
    hand (in steps of 5 mm), then the one nearer to the hand."""
    start, end, name = span
    place = grid.place(name, hand)[start:end]
    spread = float(np.linalg.norm(place.std(axis=0)))
    return _size(episode, name), round(spread / 0.005), float(np.linalg.norm(np.median(place, axis=0)))


def _grip(grid: Grid, hand: str, thing: str, span: Span, near: Span | None = None) -> InferredGrasp:
    """Grasp of a thing by a hand during a span; ``near``, needed for a hand without poses, is the span in which the
    hand is near the thing."""
    start, end = span
    near = near or at_its_place(grid, thing, hand, span, AT_HAND)
    height = grid.poses[thing][start:end, 2]
    up, above = np.flatnonzero(height > height[0] + LIFTED), np.flatnonzero(height > height[-1] + LIFTED)
    lift = start + int(up[0]) if len(up) else start if start == 0 and len(above) else None
    down = start + int(above[-1]) + 1 if len(above) and end < len(grid.times) else None
    return InferredGrasp(hand, thing, span, near, lift, down if lift is not None else None)


def grasps_of_unseen_hand(
    episode: Episode, grid: Grid, hand: str | None, things: Sequence[str]
) -> tuple[list[InferredGrasp], dict[str, set[str]]]:
    """Infer the grasps of a hand without poses: a thing that rises and stays up was held.

    Of things that rise together the largest is held, or of equal ones the lowest.
    """
    spans = [(s, e, n) for n in things for s, e in _flights(grid, n)] if hand is not None else []
    held: list[InferredGrasp] = []
    riding: dict[str, set[str]] = defaultdict(set)
    margin = round(UNSEEN[1] / STEP)
    for s, e, name in sorted(spans, key=lambda span: (_size(episode, span[2]), float(grid.poses[span[2]][span[0], 2]))):
        over = next((g for g in held if overlap((s, e), g.span) > 0.5 * min(e - s, g.span[1] - g.span[0])), None)
        if over is None:
            held.append(_grip(grid, str(hand), name, (s, e), (max(s - margin, 0), e + margin)))
        elif over.thing != name:
            riding[over.thing].add(name)
    return held, riding


def _flights(grid: Grid, thing: str) -> list[Span]:
    """Spans of a thing's motion in which it is lifted, including its pauses in the air."""
    found: list[Span] = []
    height = grid.poses[thing][:, 2]
    for start, end in runs(close_gaps(grid.moving(thing), grid.times, UNSEEN[0])):
        pause = (start - found[-1][1]) * STEP if found else np.inf
        if pause < UNSEEN[2] and height[found[-1][1] : start].min(initial=np.inf) > height[found[-1][0]] + LIFTED:
            found[-1] = (found[-1][0], end)
        else:
            found.append((start, end))
    return [(s, e) for s, e in found if s > 0 and np.sum(height[s:e] > height[s] + LIFTED) * STEP > UNSEEN[0]]


def _size(episode: Episode, name: str) -> float:
    """Sort key by size: minus the diagonal of a thing [m]; 0 if unknown."""
    entity = episode.known(name)
    return -float(np.linalg.norm(entity.size)) if entity is not None and entity.size is not None else 0.0
