"""Plugin that reads two hands as one: a robot with two arms can block it without losing the repair of recorders' defects."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Episode
from cramlite.plugin import EpisodeRepair, hookimpl


def _one_handed(episode: Episode) -> Episode:
    from .two_hands import one_handed

    return one_handed(episode)


@hookimpl
def episode_repairs() -> Iterable[EpisodeRepair]:
    """Declare the repair of demonstrations with two hands."""
    return [EpisodeRepair("two hands", 30, _one_handed)]
