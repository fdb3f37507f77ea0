"""Plugin that repairs defects of recorders: objects that vanish for a moment, then states that flicker."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Episode
from cramlite.plugin import EpisodeRepair, hookimpl


def _bridge_dropouts(episode: Episode) -> Episode:
    from .dropouts import bridge_dropouts

    return bridge_dropouts(episode)


def _smooth_flicker(episode: Episode) -> Episode:
    from .flicker import debounce

    return debounce(episode)


@hookimpl
def episode_repairs() -> Iterable[EpisodeRepair]:
    """Declare the repairs of tracking dropouts and of flickering states."""
    return [EpisodeRepair("dropouts", 10, _bridge_dropouts), EpisodeRepair("flicker", 20, _smooth_flicker)]
