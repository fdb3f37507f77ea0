"""Hints at why a recorded episode has no events."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..model.episode import Episode

NOT_INFERRED = "no events were inferred"
"""Text by which an episode's repair records that a reader looked for events in the motion and found none. The repair's ``why`` states
the reason."""
FARTHEST_WAY = 50.0
"""Largest plausible extent of a recorded thing's track [m], since people stay in one building."""


def hint_without_events(episode: Episode) -> str:
    """Return a hint at why an episode has no events: the recorded reason, or lengths that seem not to be metres.

    "" if there is none.
    """
    if said := [r.why for r in episode.repairs if r.what == NOT_INFERRED]:
        return f" No events were inferred: {said[-1]}."
    ways = ((float((t.poses[:, :3].max(axis=0) - t.poses[:, :3].min(axis=0)).max()), n) for n, t in episode.tracks.items() if len(t.times))
    way, name = max(ways, default=(0.0, ""))
    if way < FARTHEST_WAY:
        return ""
    return f" '{name}' moved by {way:.0f} m, and lengths are metres: if these are millimetres or centimetres, convert them."
