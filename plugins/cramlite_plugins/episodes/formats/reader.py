"""Plugin that reads NEEMs (RobCoG event data, semantic maps and world state, KnowRob mongodumps, RDF), writes them, and exports triples."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cramlite.model import Episode
from cramlite.plugin import hookimpl


@hookimpl
def read_episode(path: Path) -> Episode | None:
    """Read a NEEM; None if there is none."""
    from .neem import read_neem

    return read_neem(path)


@hookimpl
def write_episode(episode: Episode, path: Path) -> Path:
    """Write a NEEM."""
    from .neem import write_neem

    return write_neem(episode, path)


@hookimpl
def episode_triples(episode: Episode) -> Iterable[str]:
    """Export an episode as SOMA triples in N-Triples."""
    from .soma import ntriples, triples_of

    return ntriples(triples_of(episode))
