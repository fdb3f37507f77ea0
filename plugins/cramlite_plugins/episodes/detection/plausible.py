"""Checks of recorded poses for implausible data: pauses of minutes without poses, and hands that move faster
than people can."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from cramlite.model import Episode, Repair, Track

from .co_motion import STEP, Grid

#: A pause longer than the first is cut to the second [s].
PAUSE = (60.0, 10.0)
#: No hand moves faster than this [m/s] for a twentieth of the time in which it moves. Measured in two recordings of people in virtual
#: reality: 0.5 and 0.3 m/s; in centimetres 52 and 28 m/s. Arms' tools are limited to a few m/s.
FASTEST, SHARE_FAST = 20.0, 0.95


def too_fast(hands: Iterable[str], grid: Grid) -> str:
    """Explain why hands cannot have moved as the poses say; "" if they can."""
    for hand in (h for h in hands if h in grid.poses and len(grid.times) > 2):
        speeds = np.linalg.norm(np.diff(grid.poses[hand][:, :3], axis=0), axis=1) / STEP
        moving = speeds[speeds > 1e-6]
        if len(moving) and (speed := float(np.quantile(moving, SHARE_FAST))) > FASTEST:
            return f"'{hand}' moves at {speed:.0f} m/s; lengths are metres: if these are millimetres or centimetres, convert them"
    return ""


def without_pauses(episode: Episode) -> Episode:
    """Shorten the long pauses of an episode, in which no pose was recorded; each one is noted among the
    episode's repairs."""
    times = np.unique(np.concatenate([t.times for t in episode.tracks.values()]))
    gaps = np.diff(times)
    long = np.flatnonzero(gaps > PAUSE[0])
    if not len(long) or episode.events:
        return episode
    cut = np.concatenate([[0.0], np.cumsum(gaps[long] - PAUSE[1])])
    tracks = {n: Track(t.times - cut[np.searchsorted(times[long], t.times, side="left")], t.poses) for n, t in episode.tracks.items()}
    repairs = [
        Repair(f"cut a pause of {gaps[k]:.0f} s to {PAUSE[1]:.0f} s", (float(times[k]), float(times[k + 1])), "nothing was recorded in it")
        for k in long
    ]
    return replace(episode, tracks=tracks, repairs=(*episode.repairs, *repairs))
