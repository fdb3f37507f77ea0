"""Collisions of a search: a drawing for each of the pairs of bodies with the most refusals."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING

from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .filmstrip import as_uri
from .links import targets
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Entry, Finished
    from cramlite.model import Collision

MOST = 6
"""Largest number of drawings: each takes 0.2 s of CPU time."""
SIZE = (400, 300)
"""Width and height of a drawing [pixel]."""
QUALITY = 85
"""WebP quality of a drawing: it takes about 5 kB."""


class Pair(Value):
    """Pair of bodies whose collisions, or too small distances, made the search refuse alternatives.

    Args:
        entries: of the trace, the shallowest collision first.
    """

    entries: tuple[Entry, ...]

    @property
    def least(self) -> Entry:
        """Refusal with the smallest overlap of the two bodies; the report draws this one."""
        return self.entries[0]

    @property
    def between(self) -> tuple[str, str]:
        """Names of the two bodies, in the order of the drawing's two colours."""
        drawn = _collision(self.least)
        return drawn.one, drawn.other

    @property
    def depths(self) -> str:
        """Text on how deep two bodies overlapped in refusals, or how far apart they were: least and greatest value in mm."""
        low, high = (1e3 * _collision(self.entries[k]).depth for k in (0, -1))
        if high <= 0:
            return f"{-high:.1f} mm apart" if low == high else f"{-high:.1f} to {-low:.1f} mm apart"
        if low <= 0:
            return f"from {-low:.1f} mm apart to {high:.1f} mm inside each other"
        return f"{low:.1f} mm inside each other" if f"{low:.1f}" == f"{high:.1f}" else f"{low:.1f} to {high:.1f} mm inside each other"


class Drawing(Value):
    """Drawing of the smallest overlap of two bodies in the refusals of a search, as a data URI."""

    pair: Pair
    uri: str


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("What collides with what", 51, lambda done: "" if done.proven else render(done), refused=True)
    yield ReportSection("What collided with what", 52, render)


def render(done: Finished) -> str:
    """Render the report's drawings of refused collisions as HTML; nothing where nothing was refused for a
    collision."""
    found = pairs(done.trace.entries)
    if not found:
        return ""
    drawings = [Drawing(p, as_uri(done.collision_picture(_collision(p.least), SIZE), QUALITY)) for p in found[:MOST]]
    count = sum(len(p.entries) for p in found)
    return fill("collisions", done=done, drawings=drawings, others=found[MOST:], count=count, known=targets(done))


def pairs(entries: Iterable[Entry]) -> list[Pair]:
    """Return the pairs of bodies that collided in refusals, those of most refusals first."""
    refused = sorted((e for e in entries if e.collision is not None), key=lambda e: (_collision(e).pair, _collision(e).depth, e.number))
    groups = [Pair(tuple(group)) for _, group in groupby(refused, key=lambda e: _collision(e).pair)]
    return sorted(groups, key=lambda p: (-len(p.entries), p.least.number))


def _collision(entry: Entry) -> Collision:
    assert entry.collision is not None
    return entry.collision
