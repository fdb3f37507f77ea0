"""Picture of a failure: the refused run of a program, a refused collision, or the scene at the start."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite import nearest_miss
from cramlite.model import Value

from .filmstrip import QUALITY, as_animation, as_uri

if TYPE_CHECKING:
    from cramlite import Entry, Finished
    from cramlite.model import Collision

SIZE = (480, 360)
"""Width and height of the picture [pixel]."""


class Moment(Value):
    """Picture as a data URI, with its caption; ``still`` is the first picture of an animation."""

    uri: str
    says: str
    still: str = ""


def moment(done: Finished) -> Moment:
    """Return the picture that explains a failure best: a refused run, else a refused collision, else the start."""
    if done.shown is not None and done.shown.candidate.rollout is not None:
        return run_in_short(done, f"The run of candidate {done.shown.number} that was refused")
    if (worst := _worst(done.trace.entries)) is not None and worst.collision is not None:
        pixels = done.collision_picture(worst.collision, SIZE)
        return Moment(as_uri(pixels, QUALITY), f"Refused for {worst.designator}: {worst.collision}")
    things = _things(done)
    said = f" with {', '.join(things)}" if things else ""
    return Moment(as_uri(done.start_picture(SIZE, things), QUALITY), f"The scene at the start{said}")


def run_in_short(done: Finished, says: str, about: Iterable[str] = ()) -> Moment:
    """Return a moving picture of the shown run, its view fitted to the things of given names."""
    moving, still, faster = as_animation(done, SIZE, tuple(about))
    return Moment(moving, f"{says}, {faster:.0f} times as fast" if faster >= 1.5 else says, still)


def _worst(entries: Iterable[Entry]) -> Entry | None:
    """Return the refusal whose collision is drawn: the nearest miss or, if that is no collision, a collision of the same designator.

    In the second case it is a collision of the pair of bodies for which that designator was refused most
    often.

    Of such a pair the smallest overlap is drawn.
    """
    known = list(entries)
    nearest = nearest_miss(known)
    if nearest is None or nearest.collision is not None:
        return nearest
    of = [e for e in known if e.candidate == nearest.candidate and e.designator == nearest.designator and e.collision is not None]
    most = [pair for pair, _ in Counter(_seen(e.collision).pair for e in of).most_common(1)]
    return min((e for e in of if _seen(e.collision).pair in most), key=lambda e: _seen(e.collision).depth, default=None)


def _seen(collision: Collision | None) -> Collision:
    assert collision is not None
    return collision


def _things(done: Finished) -> tuple[str, ...]:
    """Things that the goals or the refusal nearest to success name, in the order of the world; empty to show
    all things."""
    nearest = nearest_miss(done.trace.entries)
    texts = [e.text for e in done.trace.entries if e.kind == "goal"] + ([nearest.designator, nearest.reason] if nearest else [])
    named = set(re.findall(r"\w+", " ".join(texts)))
    return tuple(t.name for t in done.setting.world.things if t.name in named)
