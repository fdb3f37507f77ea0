"""The reader of NEEMs as a plugin: RobCoG event data, semantic maps and world state, KnowRob mongodumps, RDF.

What it reads is repaired for interpretation, and hands that pass something on are read as one; ``neem.read_neem`` gives an
episode as it was recorded.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cramlite import Episode, hookimpl


@hookimpl
def read_episode(path: Path) -> Episode | None:
    from .neem import read_neem
    from .one_handed import one_handed
    from .repair import repaired

    episode = read_neem(path)
    return None if episode is None else one_handed(repaired(episode))


@hookimpl
def episode_triples(episode: Episode) -> Iterable[str]:
    from .soma import ntriples, triples_of

    return ntriples(triples_of(episode))
