"""Forces with which demonstrations press a payload onto a surface, from the recorded wrench of the hand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..base.value import Value
from ..interpretation.path_predicate import related
from ..model.episode import Episode
from ..model.geometry import Floats
from .span import Span

UPRIGHT = 0.7
"""Least vertical share of a contact force whose wrench counts as recorded in world axes: contact with a friction coefficient of 1 has a
share of 0.7."""
MARGIN = 1.25
"""Factor from the highest contact force in the examples to a robot's force limit: in simulation, a robot presses as evenly as people at a
quarter of their speed."""


class Pressed(Value):
    """Contact force of one example while its payload touches the surface.

    Args:
        example: its span, for people.
        press_n: median of the vertical force on the surface [N].
        peak_n: largest magnitude of the whole force, friction included [N].
    """

    example: str
    press_n: float
    peak_n: float


class ShownForce(Value):
    """Contact forces of the examples that record one.

    Args:
        examples: at least one.
    """

    examples: tuple[Pressed, ...]

    @property
    def press_n(self) -> float:
        """Median of the examples' vertical forces [N]."""
        return round(float(np.median([e.press_n for e in self.examples])), 1)

    @property
    def spread_n(self) -> float:
        """Standard deviation of the examples' vertical forces [N]."""
        return round(float(np.std([e.press_n for e in self.examples])), 1)

    @property
    def limit_n(self) -> float:
        """Force limit for a robot: the highest peak times ``MARGIN``, in whole newtons [N]."""
        return float(math.ceil(MARGIN * max(e.peak_n for e in self.examples)))


def shown_force(spans: Sequence[Span], pairs: Sequence[tuple[str, str]]) -> ShownForce | None:
    """Return the contact forces that examples record; None if none of them records any.

    Args:
        pairs: payload and surface of each example.
    """
    each = ((span, force) for span, pair in zip(spans, pairs, strict=True) if (force := _contact_force(span, *pair)) is not None)
    found = tuple(
        Pressed(str(span), round(float(np.median(f[:, 2])), 1), round(float(np.linalg.norm(f, axis=1).max()), 1)) for span, f in each
    )
    return ShownForce(found) if found else None


def _contact_force(span: Span, payload: str, surface: str) -> Floats | None:
    """Return the force (N, 3) of the payload on a surface at each sample of their contact in a span, in world axes, down positive [N].

    It is the recorded wrench of the hand, less its median while the hand holds the payload and the payload touches nothing else. None
    without such samples, and where the force is not mainly vertical.
    """
    episode = span.timeline.episode
    times, wrench = episode.extras.get("times"), episode.extras.get("wrench")
    if times is None or wrench is None or wrench.shape != (len(times), 6) or not span.effector:
        return None
    held = related(episode, span.effector, payload, times)
    free = held & ~_touching(episode, payload, span.effector, times)
    pressed = held & related(episode, payload, surface, times) & (times >= span.start) & (times <= span.end)
    if not free.any() or not pressed.any():
        return None
    force: Floats = np.median(wrench[free, :3], axis=0) - wrench[pressed, :3]
    upright = np.median(force[:, 2]) >= UPRIGHT * np.median(np.linalg.norm(force, axis=1))
    return force if np.isfinite(force).all() and upright else None


def _touching(episode: Episode, payload: str, effector: str, times: Floats) -> np.ndarray:
    """Return a mask (N,) of the times [s] at which a recorded state relates a payload to anything but the hand."""
    found = np.zeros(len(times), dtype=bool)
    for event in episode.of("state"):
        names = {episode.whole(n) for n in event.roles.values()}
        if payload in names and effector not in names:
            found |= (times >= event.start) & (times < event.end)
    return found
