"""Hand motions that demonstrations share: paths of the held thing relative to the thing about which these paths differ least.

The path is gone round without a stop, or gone along on a surface: once, or in strokes, between which the thing is lifted back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np

from ..base.value import Value, replace
from ..interpretation.path_predicate import followed, gone_through, headed, parts_of, related
from ..model.geometry import Floats, Pose
from ..model.shown_path import Anchor, ShownPath, length, resampled
from .repeated import ROUND, evenly, rounds, strokes
from .shown_force import ShownForce, shown_force
from .span import Span

HELD = 0.9
"""Least share of a span's time for which the hand must hold a thing that counts as held throughout."""
LONG = 0.06
"""Least length of a learned path on a surface [m]: that of one round of a repeated motion."""
BENT = 1.5
"""Least ratio of a path's length to the distance between its ends at which the path counts as bent: no straight stroke reaches it."""
THIN = 0.5
"""Ratio of width to length of a periodic path, below which the motion counts as going to and fro."""
AGREED, WIDEST = 0.15, 0.25
"""Largest spread of the examples' paths (AGREED), and largest tolerance about a learned path (WIDEST), as shares of the path's extent."""
FINE = 0.002
"""Least difference that counts between the spreads of two candidate frames of a path [m]: twice a person's drift."""
NEAR, SIGMAS = 0.01, 3.0
"""Least tolerance about a learned path [m], and the tolerance as a multiple of the examples' spread: 3 covers 99.7 % of normal errors."""
ENOUGH, WHOLE = 0.75, 0.85
"""Shares of a learned path at which a motion counts as the learned one: of the fewest rounds in the examples (ENOUGH), or of the length of
an open path (WHOLE)."""
LEAST_UP = 0.03
"""Least height above a path's start from which the hand comes down to it [m]."""
EXACT = 0.002
"""Largest distance between a demonstrated path and the corners that approximate it [m]."""
AIMED, LOOKS = 0.2, 9
"""Largest deviation of a moved thing's heading from the mean of all examples [rad], as people keep a heading within some 10 deg; and number
of samples of the heading in each example."""


class ShownMotion(Value, eq=False):
    """Motion that all examples show.

    Args:
        path: mean of the examples.
        fillers: of each example, what moved and about what.
        spread: root mean square distance of the examples from the mean [m].
        counts: how often each example went through the path.
        bent: whether no single straight stroke does it.
        force: with which the examples press on a surface; None where none says it, and in the air.
    """

    path: ShownPath
    fillers: tuple[tuple[str, str], ...]
    spread: float
    counts: tuple[float, ...]
    bent: bool
    force: ShownForce | None = None

    def apart_from(self, refused: Sequence[Span]) -> ShownMotion:
        """Return the motion with its required number of repetitions raised above the number in time spans without
        the task.

        The required number is half way between that of these spans and that of the examples. The motion is
        unchanged if the examples do not repeat it more often.
        """
        found = (
            gone_through(self.path, span.timeline.episode, one, other, (span.start, span.end))
            for span in refused for one, other in self._asked(span)
        )  # fmt: skip
        most, fewest = max(found, default=0.0), min(self.counts) if self.path.closed else 1.0
        least = max(self.path.least, round((most + fewest) / 2, 2)) if most < fewest else self.path.least
        return replace(self, path=replace(self.path, least=least))

    def _asked(self, span: Span) -> Iterator[tuple[str, str]]:
        """Return the pairs of things to check for the motion: the thing that may have moved, and the thing relative to which it moved."""
        return ((n, n) for n in span.things) if self.path.anchor.own else permutations(span.things, 2)


class _Core(Value, eq=False):
    """Part of one example's path that lies within the motion shared by all examples, in the frame of the
    reference thing."""

    places: Floats
    closed: bool
    touching: bool
    count: float
    speed: float
    up: float
    headings: Floats


def shown_motion(spans: Sequence[Span]) -> ShownMotion | None:
    """Return the motion that all examples share; None where they share none."""
    found = [m for pairs in _casts(spans) if (m := _of_pairs(spans, pairs)) is not None]
    motion = min(found, key=lambda f: f[0], default=(None, None))[1]
    return replace(motion, force=shown_force(spans, motion.fillers)) if motion is not None and motion.path.touching else motion


def _casts(spans: Sequence[Span]) -> Iterator[tuple[tuple[str, str], ...]]:
    """Yield for each example a pair of mover and reference thing: equal names in all examples, else things of
    equal classes."""
    each = [_pairs(span) for span in spans]
    for pair in each[0]:
        types = [spans[0].timeline.types(n)[:1] for n in pair]
        options = [
            [p for p in pairs if p == pair] or [p for p in pairs if [span.timeline.types(n)[:1] for n in p] == types]
            for span, pairs in zip(spans[1:], each[1:], strict=True)
        ]
        yield from ((pair, *others) for others in product(*options))


def _pairs(span: Span) -> list[tuple[str, str]]:
    """Return each thing that the hand holds throughout a span, paired with each other thing."""
    episode, times = span.timeline.episode, np.linspace(span.start, span.end, 50)[:-1]
    held = [n for n in span.things if span.effector and related(episode, span.effector, n, times).mean() >= HELD]
    return [(one, other) for one in held for other in span.things if other != one]


def _of_pairs(spans: Sequence[Span], pairs: tuple[tuple[str, str], ...]) -> tuple[tuple[float, ...], ShownMotion] | None:
    cores = [_core(span, *pair) for span, pair in zip(spans, pairs, strict=True)]
    known = [c for c in cores if c is not None]
    if len(known) < len(cores) or len({(c.closed, c.touching) for c in known}) > 1:
        return None
    parts = [parts_of(span.timeline.episode, about) for span, (_, about) in zip(spans, pairs, strict=True)]
    classes = [p[0] for p in parts[0]]
    best: tuple[tuple[float, ...], ShownMotion] | None = None
    for rank, anchor in enumerate(_anchors(dict.fromkeys(classes))):
        frames = [anchor.frame(its) for its in parts]
        if any(f is None for f in frames):
            continue
        metres = float(np.mean([f[1] for f in frames if f is not None]))
        places = [_within(c.places, f) for c, f in zip(known, frames, strict=True) if f is not None]
        mean, spread, either = _mean(places, known[0].closed, metres)
        size = float(np.ptp(mean * np.array([metres, metres, 1.0]), axis=0).max())
        if spread > AGREED * size:
            continue
        far = float(np.linalg.norm(np.mean([c.places.mean(axis=0) for c in known], axis=0)))
        key = (round(spread / FINE), round(far, 3), float(rank))
        if best is None or key < best[0]:
            aimed = _heading([c.headings - _yaw(f[0]) for c, f in zip(known, frames, strict=True) if f is not None])
            motion = _motion(anchor, mean, spread, either, known, pairs, metres)
            best = key, replace(motion, path=replace(motion.path, heading=aimed))
    return best


def _anchors(classes: Sequence[str] | dict[str, None]) -> Iterator[Anchor]:
    """Yield the frames in which a path may be given: at bottom and origin of each part of a thing, last the
    thing's own."""
    for scaled in (False, True):
        yield from (Anchor(class_, deep, scaled) for class_ in classes for deep in (True, False))
    yield Anchor()


def _core(span: Span, mover: str, about: str) -> _Core | None:
    """Return the part of a moving thing's path that characterises its motion about a reference thing; None if there is none.

    It is the mean of equal strokes on the thing, else the periodic part, else the part in which both touch.
    """
    episode = span.timeline.episode
    found = followed(episode, mover, about, (span.start, span.end))
    if found is None:
        return None
    times, places = evenly(*found)
    touched = related(episode, mover, about, times) if len(times) > 2 else np.zeros(len(times), dtype=bool)
    rows = np.flatnonzero(touched)
    touching = len(rows) > 1 and length(places[rows[0] : rows[-1] + 1]) >= LONG
    first, last = (int(rows[0]), int(rows[-1])) if touching else (0, len(places) - 1)
    again = _strokes(places, touched)
    periodic = None if again else rounds(places[first : last + 1])
    if not touching and (periodic is None or _thin(periodic.mean)):
        return None
    begin, end = (first + r for r in periodic.rows) if periodic else again[0] if again else (first, last)
    out = again[-1][1] if again else end
    up = min(float(places[: begin + 1, 2].max() - places[begin, 2]), float(places[out:, 2].max() - places[out, 2]))
    speed = length(places[begin : end + 1]) / max(times[end] - times[begin], 1e-6)
    headings = headed(episode, mover, about, np.linspace(times[begin], times[end], LOOKS))
    if periodic is not None:
        return _Core(periodic.mean, True, bool(touching), periodic.count, speed, up, headings)
    runs = again or [(first, last)]
    mean = np.mean([resampled(places[a : b + 1], ROUND) for a, b in runs], axis=0)
    return _Core(mean, False, True, float(len(runs)), speed, up, headings)


def _thin(places: Floats) -> bool:
    """Check whether a periodic path is nearly a straight line to and fro rather than a loop.

    In the air, a motion to and fro is not taken as one about another thing.
    """
    wide = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(wide[1] < THIN * wide[0])


def _strokes(places: Floats, touched: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each of several similar strokes on a surface; none if the strokes differ.

    There are none for a single stroke, either.
    """
    runs = strokes(places, touched, LONG)
    if len(runs) < 2:
        return []
    each = np.array([resampled(places[a : b + 1], ROUND) for a, b in runs])
    off = np.sqrt(((each - each.mean(axis=0)) ** 2).sum(axis=2).mean(axis=1))
    return runs if off.max() <= AGREED * np.ptp(each.mean(axis=0), axis=0).max() else []


def _within(places: Floats, frame: tuple) -> Floats:  # type: ignore[type-arg]
    """Transform positions [m] to the frame of a path, and divide x and y by the path's unit of length."""
    pose, metres = frame
    inside = (places - np.array(pose.position)) @ pose.rotation
    return np.asarray(inside / (metres, metres, 1.0))


def _mean(places: Sequence[Floats], closed: bool, metres: float) -> tuple[Floats, float, bool]:
    """Return the mean of the examples' paths, their spread about it [m], and whether some ran in the opposite
    direction."""
    unit = np.array([metres, metres, 1.0])
    aligned, reversed_ = [places[0]], [False]
    for one in places[1:] if closed else ():
        ways = [(np.roll(one[::way], k, axis=0), way < 0) for way in (1, -1) for k in range(len(one))]
        near, turned = min(ways, key=lambda w: float((((w[0] - places[0]) * unit) ** 2).sum()))
        aligned.append(near)
        reversed_.append(turned)
    aligned = aligned if closed else list(places)
    mean = np.mean(aligned, axis=0)
    spread = float(np.sqrt(np.mean([(((a - mean) * unit) ** 2).sum(axis=1) for a in aligned])))
    return np.asarray(mean), spread, any(reversed_)


def _motion(
    anchor: Anchor, mean: Floats, spread: float, either: bool, cores: Sequence[_Core], pairs: tuple[tuple[str, str], ...], metres: float
) -> ShownMotion:
    unit = np.array([metres, metres, 1.0])
    size = float(np.ptp(mean * unit, axis=0).max())
    closed = cores[0].closed
    corners = mean[::2] if closed else mean[cornered(mean * unit)]
    counts = tuple(round(c.count, 2) for c in cores)
    times = max(round(float(np.median(counts))), 1) if closed else round(max(counts))
    way = float(np.linalg.norm((mean[-1] - mean[0]) * unit))
    points, least = (np.round(corners, 4) + 0.0).tolist(), round(ENOUGH * min(counts), 1) if closed else WHOLE
    near, up = min(max(NEAR, SIGMAS * spread), WIDEST * size), max(min(c.up for c in cores), LEAST_UP)
    path = ShownPath(
        tuple((x, y, z) for x, y, z in points), anchor, times, least, round(near, 4), closed, either, cores[0].touching,
        round(up, 3), round(float(np.median([c.speed for c in cores])), 3),
    )  # fmt: skip
    return ShownMotion(path, pairs, spread, counts, closed or min(counts) > 1 or length(mean * unit) >= BENT * way)


def _yaw(frame: Pose) -> float:
    """Direction of a frame's x axis, seen from above [rad]."""
    return float(np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0]))


def _heading(shown: Sequence[Floats]) -> float | None:
    """Mean heading of the moved thing over all examples [rad]; None if a heading is farther than ``AIMED``
    from the mean."""
    angles = np.concatenate(shown)
    mean = np.arctan2(np.sin(angles).mean(), np.cos(angles).mean())
    off = np.abs((angles - mean + np.pi) % (2 * np.pi) - np.pi)
    return round(float(mean), 2) + 0.0 if len(angles) and off.max() <= AIMED else None


def cornered(line: Floats, exact: float = EXACT) -> list[int]:
    """Return the indices of the points that approximate a line within a distance [m] (Douglas and Peucker
    1973)."""
    kept, open_ = {0, len(line) - 1}, [(0, len(line) - 1)]
    while open_:
        a, b = open_.pop()
        if b - a < 2:
            continue
        way = line[b] - line[a]
        share = np.clip((line[a + 1 : b] - line[a]) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        off = np.linalg.norm(line[a + 1 : b] - line[a] - share[:, None] * way, axis=1)
        far = int(np.argmax(off))
        if off[far] > exact:
            middle = a + 1 + far
            kept.add(middle)
            open_ += [(a, middle), (middle, b)]
    return sorted(kept)
