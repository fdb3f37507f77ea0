"""Contacts of a run: stored in MuJoCo's form while it runs, named and summed after it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mujoco
import numpy as np

from cramlite.model import EntityName, Floats, Touch

from ..model.compile import Compiled
from ..model.index import Data, Model, Owner
from ..model.sleep import awake_copy

WEAKEST = 1e-3  # a contact below this normal force [N] is a gap within the contact margin, not a touch

Named = tuple[tuple[str, str], bool]
"""Names of two bodies in the order of a ``Touch``, and whether MuJoCo has its two geoms in the opposite order."""


class _Kept(NamedTuple):
    """Contacts to be recorded in a simulation state: indices in MuJoCo's list of contacts, names, and kinematic
    trees (n, 2), -1 for fixed geoms."""

    rows: list[int]
    named: list[Named]
    trees: Any


class _Points(NamedTuple):
    """Contact points of a state: names, axes (n, 9), and forces and torques along these (n, 6) [N, Nm]."""

    named: list[Named]
    axes: Floats
    forces: Floats


class Contacts:
    """A collector of the contacts of each sample.

    Contacts within an arm or an effector, and those of grains, are left out. Things that sleep touch what they touched when they
    fell asleep.

    Args:
        compiled: the model.
        effector: whose fingers are "effector/left" and "effector/right"; those of any other are "mount/left" and so on.
    """

    def __init__(self, compiled: Compiled, effector: str) -> None:
        self._model, self._owners, self._effector = compiled.model, compiled.owners, effector
        trees = (int(compiled.model.body_treeid[i.body]) for i in compiled.things.values())
        self._things = [tree for tree in trees if tree >= 0]
        self._known: dict[bytes, _Kept] = {}  # contacts last: most samples have those of one before
        self._awake: list[_Points] = []
        self._asleep: list[tuple[Touch, ...]] = []
        self._sleepers, self._theirs = b"", tuple[Touch, ...]()
        self._before: tuple[_Kept | None, bytes] = None, b""

    def see(self, data: Data) -> None:
        """Record the contacts of a simulation state as one sample."""
        kept, trees = self._kept(data), data.tree_asleep >= 0
        self._awake.append(_measured(self._model, data, kept.rows, kept.named))
        before, self._before = self._before, (kept, trees.tobytes())
        if self._before[0] is not before[0] or self._before[1] != before[1]:
            self._look_at_sleepers(data, kept, trees)
        self._asleep.append(self._theirs)

    def _look_at_sleepers(self, data: Data, kept: _Kept, trees: Any) -> None:
        """Update the contacts of things that sleep, if other things do than before; ``trees`` are flags of MuJoCo's trees of
        bodies."""
        asleep = np.append(trees, False)
        asleep[kept.trees] = False  # in the step in which a thing falls asleep its contacts are still listed
        sleepers = asleep[self._things].tobytes()
        if sleepers != self._sleepers:
            self._sleepers = sleepers
            self._theirs = self._between(data, asleep) if any(sleepers) else ()

    def touches(self) -> tuple[tuple[Touch, ...], ...]:
        """List the contacts of each sample, summed over the contact points of each pair.

        In each pair ``a`` is the effector or robot if one takes part, else the first by name.
        """
        return tuple(_joined(own, more) for own, more in zip(_summed(self._awake), self._asleep, strict=True))

    def asleep(self) -> tuple[tuple[Touch, ...], ...]:
        """List for each sample the contacts of things that the simulation lets sleep while they rest."""
        return tuple(self._asleep)

    def _between(self, data: Data, asleep: Any) -> tuple[Touch, ...]:
        """Contacts of things that the simulation lets sleep, with each other and with furniture."""
        copy = awake_copy(self._model, data)
        kept = self._kept(copy)
        theirs = np.flatnonzero((asleep[kept.trees] | (kept.trees < 0)).all(axis=1)).tolist()
        points = _measured(self._model, copy, [kept.rows[k] for k in theirs], [kept.named[k] for k in theirs])
        return _summed([points])[0]

    def _kept(self, data: Data) -> _Kept:
        """Look up the contacts of a state that are recorded, with their names; states with the same pairs of
        geoms share the answer."""
        geoms = data.contact.geom
        key = geoms.tobytes()
        if key not in self._known:
            rows, named = self._listed(geoms.tolist())
            self._known[key] = _Kept(rows, named, self._model.body_treeid[self._model.geom_bodyid[geoms[rows]]])
        return self._known[key]

    def _listed(self, pairs: list[list[int]]) -> tuple[list[int], list[Named]]:
        """Indices in a list of pairs of geoms, and names of the bodies, of those pairs whose contacts are recorded."""
        found = [(row, named) for row, pair in enumerate(pairs) if (named := self._name(*pair)) is not None]
        return [row for row, _ in found], [named for _, named in found]

    def _name(self, first: int, second: int) -> Named | None:
        """Names of the two bodies in contact, ordered as in ``Touch``, and whether MuJoCo has them the other
        way round.

        None for contacts that are not recorded.
        """
        one, two = self._owners[first], self._owners[second]
        if one.name == two.name or "grain" in (one.kind, two.kind):
            return None
        a, b = self._touch(one), self._touch(two)
        flip = (one.kind == "thing", a) > (two.kind == "thing", b)
        return ((b, a) if flip else (a, b)), flip

    def _touch(self, owner: Owner) -> str:
        own = owner.kind != "effector" or owner.name == self._effector
        return owner.touch if own else str(EntityName(owner.name, owner.part))


def _measured(model: Model, data: Data, rows: list[int], named: list[Named]) -> _Points:
    """Contact points in the given rows of MuJoCo's list, with names, axes and forces."""
    forces = np.empty((len(rows), 6))
    for row, force in zip(rows, forces, strict=True):
        mujoco.mj_contactForce(model, data, row, force)
    return _Points(named, data.contact.frame.take(rows, axis=0), forces)


def _summed(samples: list[_Points]) -> list[tuple[Touch, ...]]:
    """Contacts of each sample as ``Touch``, summed over the sample's contact points."""
    if not samples:
        return []
    forces = np.concatenate([s.forces for s in samples])
    # the frame's rows are the contact axes; the force is the one of the first geom on the second
    axes = np.concatenate([s.axes for s in samples])
    up = axes[:, None, 2::3] @ forces[:, :3, None]
    pushed = (axes[:, :3] * forces[:, :1]).tolist()
    points = iter(zip(forces[:, 0].tolist(), up.ravel().tolist(), pushed, strict=True))
    return [_touches([(pair, *next(points)) for pair in s.named]) for s in samples]


def _touches(points: list[tuple[Named, float, float, list[float]]]) -> tuple[Touch, ...]:
    """Contacts of a sample as ``Touch``, summed over its contact points.

    Each has names, the normal force, the upward force of the first on the second [N], and the magnitude of
    the summed normal forces [N].
    """
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


def _joined(some: tuple[Touch, ...], others: tuple[Touch, ...]) -> tuple[Touch, ...]:
    """Merge two lists of contacts, sorted by the names of the things in contact."""
    return tuple(sorted((*some, *others), key=lambda t: (t.a, t.b))) if some and others else some or others
