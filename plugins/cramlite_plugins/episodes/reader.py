"""The reader of NEEMs as a plugin: RobCoG event data, semantic maps and world state, KnowRob mongodumps, RDF.

What it reads is repaired for interpretation, and hands that pass something on are read as one; ``neem.read_neem`` gives an
episode as it was recorded.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cramlite.model import Episode
from cramlite.plugin import hookimpl


@hookimpl
def read_episode(path: Path) -> Episode | None:
    from .formats.neem import read_neem
    from .repair.flicker import repaired
    from .repair.two_hands import one_handed

    episode = read_neem(path)
    return None if episode is None else one_handed(repaired(episode))


@hookimpl
def episode_triples(episode: Episode) -> Iterable[str]:
    from .formats.soma import ntriples, triples_of

    return ntriples(triples_of(episode))
