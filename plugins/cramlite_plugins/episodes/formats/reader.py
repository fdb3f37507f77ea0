"""NEEMs as a plugin: read (RobCoG event data, semantic maps and world state, KnowRob mongodumps, RDF), written, and as triples."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cramlite.model import Episode
from cramlite.plugin import hookimpl


@hookimpl
def read_episode(path: Path) -> Episode | None:
    from .neem import read_neem

    return read_neem(path)


@hookimpl
def write_episode(episode: Episode, path: Path) -> Path:
    from .neem import write_neem

    return write_neem(episode, path)


@hookimpl
def episode_triples(episode: Episode) -> Iterable[str]:
    from .soma import ntriples, triples_of

    return ntriples(triples_of(episode))
