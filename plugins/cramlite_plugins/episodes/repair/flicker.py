"""Debouncing of flickering states; each change is reported and can be undone.

Recorded contacts flicker: RobCoG's logs hold hundreds of contacts of 0.02 to 0.3 s for one touch.
Two changes, in this order: a gap shorter than ``gap`` between two equal states belongs to them; a
state that is then still shorter than ``min_duration`` is dropped as noise. Things that vanish for a
moment (dropouts.py) come before. Every repair keeps what it removed and added, so that ``undo``
restores the original.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from cramlite.model import Episode, Event, Repair

from .dropouts import signature, spliced

GAP = 0.3
"""Longest interruption of a state that counts as flicker [s]: the longest flicker of contacts in RobCoG's logs."""
SHORT = 0.05
"""Shortest duration of a state that is kept [s]: two frames of a 50 Hz recorder; nobody touches a thing on purpose for less (human reaction
time is 0.2 s)."""


def debounce(episode: Episode, gap: float = GAP, min_duration: float = SHORT) -> Episode:
    """Debounce the flickering states of an episode.

    Args:
        episode: as recorded.
        gap: interruptions up to this long are closed [s]; touching and overlapping doubles are joined too.
        min_duration: states shorter than this, after closing gaps, are dropped [s]. A state that the
            recording's start or end cuts off is kept: nobody knows how long it was.

    Returns:
        A new episode; each change is in ``repairs``. Actions and situations are left alone.
    """
    if gap < 0 or min_duration < 0:
        raise ValueError(f"gap {gap} s and min_duration {min_duration} s must not be negative")
    first, last = episode.span
    repairs: list[Repair] = []
    kept: list[Event] = [e for e in episode.events if e.kind != "state"]
    for group in _groups(episode).values():
        for run in _runs(group, gap):
            joined = _joined(run)
            cut_off = joined.start <= first or joined.end >= last
            if joined.end - joined.start < min_duration and not cut_off:
                repairs.append(_dropped(joined, run, min_duration))
                continue
            kept.append(joined)
            if len(run) > 1:
                repairs.append(_closed(joined, run, gap))
    if not repairs:
        return episode
    ordered = sorted(repairs, key=lambda r: (r.when, r.what))
    return replace(episode, events=_sorted(kept), repairs=(*episode.repairs, *ordered))


def undo(episode: Episode, repair: Repair) -> Episode:
    """Undo a repair: return the episode as it was before.

    Raises:
        ValueError: it is not a repair of this episode, or a later one changed the same events.
    """
    if repair not in episode.repairs or any(e not in episode.events for e in repair.added):
        raise ValueError(f"'{repair.what}' cannot be undone: it is not in the episode, or a later repair builds on it")
    tracks = dict(episode.tracks)
    if repair.track is not None:
        rows = np.array(repair.recorded, dtype=float)
        tracks[repair.track] = spliced(tracks[repair.track], repair.when, rows)
    restored = [e for e in episode.events if e not in repair.added] + list(repair.removed)
    rest = tuple(r for r in episode.repairs if r != repair)
    return replace(episode, events=_sorted(restored), tracks=tracks, repairs=rest)


def _sorted(events: Iterable[Event]) -> tuple[Event, ...]:
    return tuple(sorted(events, key=lambda e: (e.start, e.end, e.id)))


def _groups(episode: Episode) -> dict[tuple[object, ...], list[Event]]:
    """Group the states of an episode that differ in nothing but their times."""
    groups: dict[tuple[object, ...], list[Event]] = defaultdict(list)
    for event in episode.of("state"):
        groups[signature(event)].append(event)
    return groups


def _runs(events: Iterable[Event], gap: float) -> Iterable[list[Event]]:
    """Consecutive events that no interruption longer than ``gap`` separates."""
    run: list[Event] = []
    end = float("-inf")
    for event in sorted(events, key=lambda e: (e.start, e.end, e.id)):
        if run and event.start - end > gap:
            yield run
            run = []
            end = float("-inf")
        run.append(event)
        end = max(end, event.end)
    if run:
        yield run


def _joined(run: list[Event]) -> Event:
    """Merge consecutive events into one, from the first one's start to the last one's end; the merged event is inferred if one of them
    is."""
    if len(run) == 1:
        return run[0]
    return replace(run[0], end=max(e.end for e in run), inferred=any(e.inferred for e in run))


def _closed(joined: Event, run: list[Event], gap: float) -> Repair:
    lost = joined.end - joined.start - sum(e.end - e.start for e in run)
    what = f"{len(run)} x {joined.type} of {_fillers(joined)} joined"
    why = f"interruptions of {max(lost, 0.0):.3f} s in all, none longer than {gap} s"
    return Repair(what, (joined.start, joined.end), why, tuple(run), (joined,))


def _dropped(joined: Event, run: list[Event], least: float) -> Repair:
    what = f"{joined.type} of {_fillers(joined)} dropped"
    return Repair(
        what, (joined.start, joined.end), f"the event lasted {joined.end - joined.start:.3f} s, less than {least} s", tuple(run)
    )


def _fillers(event: Event) -> str:
    return " and ".join(event.roles.values())
