"""Friction of contact pairs from the coefficients of both geoms; MuJoCo itself takes only one geom's.

MuJoCo takes the larger coefficient of two geoms, or that of the one with the higher priority, which a finger pad has: a thing
without friction would be held like any other. So every pair of geoms that can meet, and whose own coefficients differ, becomes
an explicit contact pair, with condim and solref as MuJoCo would have taken them from the two geoms. Explicit pairs pass by
contact bits and exclusions, so these are checked here. Grains are left to MuJoCo's larger coefficient: 162 of them in a jug would
be 6,000 pairs, and a step a third slower. So are things that nothing brings together: where sixteen vessels stand about, each with a
friction of its own, these are 17,500 of 17,600 pairs, and three quarters of a step.
"""

from __future__ import annotations

import itertools
from collections.abc import Container
from typing import Any

from cramlite.model import Value, pair_friction

from .build import ROBOT, is_pad
from .far_apart import Apart
from .grains import is_grain

LINK = 0.0
"""Friction coefficient of links and finger backs, whose surface nobody states: of two coefficients MuJoCo takes the larger one, which is
then the other geom's."""


NOTHING = Apart()
FIRM = (0.99, 0.995, 0.001, 0.5, 2.0)
"""Impedance of pads on a thing with loose contents, which is carried without no-slip iterations. With MuJoCo's 0.9 a full jug slips
through the fingers by 0.3 mm/s; with this by 0.05 mm/s at most, as with the iterations. With 0.999 the arm stops (measured)."""


class Surface(Value):
    """Geom that can be in an explicit contact pair, with its contact parameters.

    Args:
        geom, body: their names.
        moves: whether the body can move.
        pad: whether it is a finger pad.
        friction: sliding, torsional and rolling.
        priority: of its contact parameters.
        condim, solref, solimp, margin, gap: of its contacts.
        bits: contype and conaffinity.
        stated: whether a file states them.
    """

    geom: str
    body: str
    moves: bool
    pad: bool
    friction: tuple[float, float, float]
    priority: int
    condim: int
    solref: tuple[float, float]
    solimp: tuple[float, ...]
    margin: float
    gap: float
    bits: tuple[int, int]
    stated: bool

    def meets(self, other: Surface) -> bool:
        """Check whether MuJoCo would look for contacts between two geoms by their bodies and contact bits;
        exclusions are not considered."""
        (a, b), (c, d) = self.bits, other.bits
        return self.body != other.body and (self.moves or other.moves) and bool(a & d or c & b)

    def friction_with(self, other: Surface) -> tuple[float, float, float, float, float]:
        """Return the friction coefficients of two geoms: sliding along both tangents, torsional, and rolling
        about both."""
        (mine, *further), (its, *others) = self.friction, other.friction
        sliding, (torsional, rolling) = pair_friction(mine, its), map(max, further, others)
        return (sliding, sliding, torsional, rolling, rolling)

    def agrees(self, other: Surface) -> bool:
        """Check whether MuJoCo's own combination of two geoms' friction can stay: it gives the same value, or
        a file states the friction of both."""
        alike = self.priority == other.priority and self.friction[0] == other.friction[0]
        return alike or (self.stated and other.stated)


def add_pairs(spec: Any, stated: Container[str] = (), apart: Apart = NOTHING, firm: Container[str] = ()) -> None:
    """Add to the model the friction of each pad with each thing, and of things with one another; call this when all geoms are added.

    Args:
        stated: names of geoms whose contacts a file states; two of them are left to MuJoCo's rule.
        apart: what nothing brings together; it is left to that rule, too.
        firm: names of bodies on which pads have the impedance ``FIRM``.
    """
    excluded = {frozenset((e.bodyname1, e.bodyname2)) for e in spec.excludes}
    surfaces = [s for s in (_surface(g, stated) for g in spec.geoms) if s is not None]
    for a, b in itertools.combinations(surfaces, 2):
        if apart.never_meet(a.body, b.body, a.pad or b.pad):
            continue
        if a.meets(b) and not (a.pad and b.pad) and not a.agrees(b) and frozenset((a.body, b.body)) not in excluded:
            _add_pair(spec, a, b, (a.pad and b.body in firm) or (b.pad and a.body in firm))


def _surface(geom: Any, stated: Container[str]) -> Surface | None:
    """Contact parameters of a geom of a finger pad or a thing; None for grains and links of robots.

    The friction of a link is set to ``LINK``.
    """
    if is_grain(geom.name):
        return None
    pad, (sliding, torsional, rolling) = is_pad(geom.name), map(float, geom.friction)
    if not pad and geom.contype == ROBOT[0]:
        geom.friction = [LINK, torsional, rolling]
        return None
    body, (time, damping) = geom.parent, map(float, geom.solref)
    return Surface(
        geom.name, body.name, pad or bool(body.joints), pad, (sliding, torsional, rolling), int(geom.priority),
        int(geom.condim), (time, damping), tuple(map(float, geom.solimp)), float(geom.margin), float(geom.gap),
        (int(geom.contype), int(geom.conaffinity)), geom.name in stated,
    )  # fmt: skip


def _add_pair(spec: Any, a: Surface, b: Surface, firm: bool) -> None:
    """Add a contact pair with the friction of both its geoms; the other parameters are as MuJoCo would combine
    them, except for ``solimp`` of a firm contact."""
    if a.priority != b.priority:
        first = max(a, b, key=lambda s: s.priority)
        condim, solref, solimp = first.condim, first.solref, first.solimp
    else:
        (time_a, damping_a), (time_b, damping_b) = a.solref, b.solref
        condim, solref = max(a.condim, b.condim), ((time_a + time_b) / 2, (damping_a + damping_b) / 2)
        solimp = tuple((x + y) / 2 for x, y in zip(a.solimp, b.solimp, strict=True))
    spec.add_pair(
        name=f"{a.geom} on {b.geom}", geomname1=a.geom, geomname2=b.geom, condim=condim, solref=solref,
        friction=a.friction_with(b), solimp=FIRM if firm else solimp, margin=max(a.margin, b.margin), gap=max(a.gap, b.gap),
    )  # fmt: skip
