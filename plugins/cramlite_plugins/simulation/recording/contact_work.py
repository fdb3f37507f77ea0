"""Number of contacts that a simulation computes for each thing; the simulation's work grows faster than that
number."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ..model.compile import Compiled
from ..model.index import Data


class ContactWork:
    """Counter of the contact points of each sample, by the thing or robot that has them.

    Args:
        compiled: the model.
    """

    def __init__(self, compiled: Compiled) -> None:
        self._compiled = compiled
        self._moves = (compiled.model.body_treeid >= 0)[compiled.model.geom_bodyid]
        self._seen: Counter[bytes] = Counter()  # samples by the pairs of geoms that are listed

    def see(self, data: Data) -> None:
        """Record the contacts between geoms in a state of the simulation as one sample."""
        self._seen[np.asarray(data.contact.geom, dtype=np.int32).tobytes()] += 1

    def points(self) -> dict[str, float]:
        """Return the mean number of contact points of each moving thing and robot per sample.

        Of points between two moving ones each gets half; points of grains go to their vessel.
        """
        owners, moves = self._compiled.owners, self._moves
        found = {o.name: 0.0 for o, one in zip(owners, moves, strict=True) if one}
        samples = max(1, self._seen.total())
        for key, count in self._seen.items():
            for pair in np.frombuffer(key, dtype=np.int32).reshape(-1, 2).tolist():
                loose = [owners[g].name for g in pair if moves[g]]
                for name in loose:
                    found[name] += count / len(loose) / samples
        return found
