"""The reader of NEEMs as a plugin: RobCoG event data, semantic maps and world state, KnowRob mongodumps, RDF."""

from __future__ import annotations

from pathlib import Path

from cramlite import Episode, hookimpl


@hookimpl
def read_episode(path: Path) -> Episode | None:
    from .neem import read_neem

    return read_neem(path)
