"""Contacts of a run: kept as MuJoCo has them while it runs, named and summed when it is over."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from cramlite.model import EntityName, Floats, Touch

from ..model.compile import Compiled
from ..model.index import Data, Owner

WEAKEST = 1e-3  # a contact below this normal force [N] is a gap within the contact margin, not a touch

Named = tuple[tuple[str, str], bool]
"""Names as a ``Touch`` has them, and whether they are the other way round than MuJoCo's geoms."""


class Contacts:
    """A collector of the contacts of each sample.

    Contacts within an arm or an effector, and those of grains, are left out.

    Args:
        compiled: the model.
        effector: whose fingers are "effector/left" and "effector/right"; those of any other are "mount/left" and so on.
    """

    def __init__(self, compiled: Compiled, effector: str) -> None:
        self._model, self._owners, self._effector = compiled.model, compiled.owners, effector
        self._known: dict[bytes, tuple[list[int], list[Named]]] = {}  # contacts last: most samples have those of one before
        self._named: list[list[Named]] = []
        self._axes: list[Floats] = []
        self._forces: list[Floats] = []

    def see(self, data: Data) -> None:
        """Record the contacts of a state as one sample."""
        contact = data.contact
        geoms = contact.geom
        key = geoms.tobytes()
        if key not in self._known:
            self._known[key] = self._listed(geoms.tolist())
        rows, named = self._known[key]
        forces = np.empty((len(rows), 6))
        for row, force in zip(rows, forces, strict=True):
            mujoco.mj_contactForce(self._model, data, row, force)
        self._named.append(named)
        self._axes.append(contact.frame.take(rows, axis=0))
        self._forces.append(forces)

    def touches(self) -> tuple[tuple[Touch, ...], ...]:
        """List the touches of each sample, summed over the points of each pair.

        In each pair ``a`` is the effector or robot if one takes part, else the first by name.
        """
        if not self._named:
            return ()
        forces = np.concatenate(self._forces)
        # the frame's rows are the contact axes; the force is the one of the first geom on the second
        axes = np.concatenate(self._axes)
        up = axes[:, None, 2::3] @ forces[:, :3, None]
        pushed = (axes[:, :3] * forces[:, :1]).tolist()
        points = iter(zip(forces[:, 0].tolist(), up.ravel().tolist(), pushed, strict=True))
        return tuple(_summed([(pair, *next(points)) for pair in named]) for named in self._named)

    def _listed(self, pairs: list[list[int]]) -> tuple[list[int], list[Named]]:
        """Which of the contacts of these pairs of geoms are kept, and the names of each."""
        found = [(row, named) for row, pair in enumerate(pairs) if (named := self._name(*pair)) is not None]
        return [row for row, _ in found], [named for _, named in found]

    def _name(self, first: int, second: int) -> Named | None:
        """The names of two geoms; None for contacts that are left out."""
        one, two = self._owners[first], self._owners[second]
        if one.name == two.name or "grain" in (one.kind, two.kind):
            return None
        a, b = self._touch(one), self._touch(two)
        flip = (one.kind == "thing", a) > (two.kind == "thing", b)
        return ((b, a) if flip else (a, b)), flip

    def _touch(self, owner: Owner) -> str:
        own = owner.kind != "effector" or owner.name == self._effector
        return owner.touch if own else str(EntityName(owner.name, owner.part))


def _summed(points: list[tuple[Named, float, float, list[float]]]) -> tuple[Touch, ...]:
    """The touches of a sample from its contact points: names, normal force, what the first lifts the second by [N], and the
    vector of the normal force (3,) [N]."""
    sums: dict[tuple[str, str], list[float]] = {}
    for (pair, flip), pushed, lift, (x, y, z) in points:
        if pushed >= WEAKEST:
            total = sums.setdefault(pair, [0.0] * 5)
            sign = -1.0 if flip else 1.0
            total[0] += pushed
            total[1] += sign * lift
            total[2] += sign * x
            total[3] += sign * y
            total[4] += sign * z
    return tuple(Touch(a, b, f, u, math.hypot(x, y, z)) for (a, b), (f, u, x, y, z) in sorted(sums.items()))
