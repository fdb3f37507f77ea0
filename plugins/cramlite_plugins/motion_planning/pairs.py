"""Collision pairs: the joints that move each geom, and the distance that each pair must keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import mujoco
import numpy as np

from cramlite.model import Floats, Value

from ..simulation.model.compile import Compiled
from ..simulation.model.index import Owner, RobotIndex

Pairs = frozenset[frozenset[str]]


ROUND = (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_CYLINDER)
COAXIAL = 1e-6  # distance and turn [m, rad] within which a round geom's axis is that of a joint


class Movers(Value):
    """Tables (geoms, joints) that tell which joints of an arm move which geoms: 1 where one does, else 0.

    A round geom about a joint's own axis stays as it is when that joint turns: its own link's last joint then
    does not move it, and the first joint beyond it brings nothing nearer to it.

    Args:
        moved: 1 where the joint is above the geom in the kinematic tree.
        turned: the same, but for joints that a round geom only spins about.
        still: 1 where the geom stays while the joint turns, but for the next joint that it is round about.
        carried: of each geom, whether a joint moves it.
    """

    moved: Floats
    turned: Floats
    still: Floats
    carried: tuple[bool, ...]

    def apart(self) -> Floats:
        """Return a table (geoms, geoms): for each pair of geoms, the number of joints that move one geom
        against the other."""
        one = self.turned @ self.still.T
        both: Floats = one + one.T
        return both


def movers(compiled: Compiled, index: RobotIndex) -> Movers:
    """Return the tables (geoms, joints) that tell which joints of a serial arm move which geoms."""
    model = compiled.model
    joints = [int(np.flatnonzero(model.jnt_qposadr == a)[0]) for a in index.joints]
    bodies = [int(model.jnt_bodyid[j]) for j in joints]
    moved = np.zeros((model.ngeom, len(bodies)))
    for g in range(model.ngeom):
        body = int(model.geom_bodyid[g])
        while body > 0:
            if body in bodies:
                moved[g, bodies.index(body)] = 1.0
            body = int(model.body_parentid[body])
    about, above = _round_about(compiled, joints), moved.sum(axis=1).astype(int)[:, None]
    column = np.arange(len(bodies))[None, :]
    return Movers(
        moved,
        moved * (1.0 - about * (column == above - 1)),
        (1.0 - moved) * (1.0 - about * (column == above)),
        tuple(map(bool, moved.sum(axis=1))),
    )


def _round_about(compiled: Compiled, joints: Sequence[int]) -> Floats:
    """Return a table (geoms, joints): 1 where a geom is round about the axis of a revolute joint, so that
    this joint does not change the space it takes, else 0."""
    model, data = compiled.model, compiled.data()
    mujoco.mj_kinematics(model, data)
    u, a = data.xaxis[joints], data.xanchor[joints]
    off = np.linalg.norm(np.cross(data.geom_xpos[:, None] - a[None], u[None]), axis=-1)
    leans = np.linalg.norm(np.cross(data.geom_xmat.reshape(-1, 3, 3)[:, None, :, 2], u[None]), axis=-1)
    leans[model.geom_type == mujoco.mjtGeom.mjGEOM_SPHERE] = 0.0
    hinges = model.jnt_type[joints] == mujoco.mjtJoint.mjJNT_HINGE
    found: Floats = (off < COAXIAL) & (leans < COAXIAL) & hinges & np.isin(model.geom_type, ROUND)[:, None]
    return found.astype(float)


def required_distances(
    compiled: Compiled,
    movers: Movers,
    allowed: Pairs,
    clearance: float,
    wider: Mapping[str, float] = MappingProxyType({}),
) -> Floats:
    """Return the distance (geoms, geoms) [m] that each pair of geoms must keep.

    Two that no joint moves apart, or that are allowed to touch, need none (-inf).

    Args:
        wider: thing -> what its pairs must keep beyond the clearance [m]; of two the larger counts.
    """
    more = np.array([wider.get(o.name, 0.0) if o.kind == "thing" else 0.0 for o in compiled.owners])
    need = np.where(movers.apart() > 0, clearance + np.maximum(more[:, None], more[None, :]), -np.inf)
    named = _named(compiled.owners)
    for pair in allowed:
        one, other = (tuple(pair) * 2)[:2]
        first, second = named.get(one, []), named.get(other, [])
        need[np.ix_(first, second)] = need[np.ix_(second, first)] = -np.inf
    return need


def _named(owners: Sequence[Owner]) -> Mapping[str, list[int]]:
    """Geoms by the name under which contacts with them may be allowed: name -> the indices of its geoms."""
    found: dict[str, list[int]] = {}
    for g, owner in enumerate(owners):
        for name in {owner.name, owner.touch, owner.kind} - {"thing"}:
            found.setdefault(name, []).append(g)
    return found
