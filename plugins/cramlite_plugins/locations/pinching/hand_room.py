"""Check whether a hand has room at a grasp: boxes around the parts of the hand's model against the obstacles
around a thing.

Exact for hands and surroundings of boxes, on the safe side for others: a mesh is in two boxes, as it lies and
along the tool, and where one of them is free, the mesh is. Fingers have a flat side to the gap, and meshes
lie askew in their own frames. Hundreds of grasps are looked at in the time of one or two inverse kinematics,
and those with room are tried first.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import mujoco
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import Belief, Feature, Floats, Geom, Pose, Thing, Value

from ...motion_planning.planning_scene import PlanningScene
from ...shapes import ray_casting as rays
from ...shapes.bounds import box_around
from ...shapes.box_overlaps import overlaps
from .antipodal import Hands

HOLE = "vrps:Hole"
AROUND = 0.30  # of a thing that hands about it reach [m]


class _Box(NamedTuple):
    """Box in the TCP frame: centre (3,) [m], axes as columns (3, 3), half side lengths (3,) [m]."""

    centre: Floats
    turn: Floats
    half: Floats


Part = list[_Box]
"""Part of a hand as a list of boxes, each of which contains the whole part."""


class Taken(Value):
    """Grasps of a thing, n of them.

    Args:
        hands: the TCP poses.
        openings: of the fingers (n,) [m].
        free: whether the hand has room there (n,).
        leaning: whether the hand leans (n,).
    """

    hands: Hands
    openings: Floats
    free: NDArray[np.bool_]
    leaning: NDArray[np.bool_]


class HandRoom(Value, dict=True):
    """Shapes that a hand must keep away from when it grasps or places a thing, and the checks of TCP poses
    against them.

    Args:
        scene: with the arm in it.
        own: the thing, in the base frame.
        others: what stands around it.
        holes: what may come through its holes, when it is threaded onto a peg.
    """

    scene: PlanningScene
    own: rays.Body
    others: rays.Body
    holes: rays.Body

    @classmethod
    def about(cls, thing: Thing, belief: Belief, scene: PlanningScene) -> HandRoom:
        """Return the shapes around a thing, where it is believed to be, for hands that grasp it."""
        pose, near = belief.pose(thing.name), _around(thing, 0.5, thing.name, belief)
        own = [replace(g, pose=pose * g.pose) for g in thing.geoms]
        columns = [replace(g, pose=pose * g.pose) for g in map(_column, thing.features) if g is not None]
        return cls(scene, rays.body(own), rays.body(near), rays.body(columns))

    @classmethod
    def amid(cls, whole: str, payload: str, belief: Belief, scene: PlanningScene) -> HandRoom:
        """Return the shapes that a hand must not hit when it puts a payload on or in a thing: the thing's and
        those around it."""
        near = _around(belief.world.thing(whole), 1.0, payload, belief)
        return cls(scene, rays.body([]), rays.body(near), rays.body([]))

    def in_a_hole(self, hands: Hands, opening: float) -> NDArray[np.bool_]:
        """Check at which TCP poses (n,) the hand, opened by ``opening`` [m], reaches into a hole of the
        thing, where a peg may be."""
        found = np.zeros(len(hands.positions), bool)
        for part in self._parts(opening) if self.holes.geoms else ():
            found |= _reaches_into(self.holes, hands, part, 0.0)
        return found

    def meets(self, shape: rays.Body, hands: Hands, openings: Floats, distance: float) -> NDArray[np.bool_]:
        """Check at which TCP poses (n,) the hand, opened by ``openings`` (n,) [m], is nearer to a shape than
        a distance [m]."""
        met = np.zeros(len(openings), bool)
        for opening in np.unique(np.round(openings, 4)).tolist():
            rows = np.flatnonzero(np.round(openings, 4) == opening)
            for part in self._parts(opening):
                met[rows] |= _reaches_into(shape, hands.of(rows), part, distance)
        return met

    @cached_property
    def _kept(self) -> dict[float, list[Part]]:
        return {}

    def _parts(self, opening: float) -> list[Part]:
        """Boxes around all parts that are rigid with the tool, in the TCP frame, with the fingers open by
        ``opening`` [m]."""
        if opening not in self._kept:
            self._kept[opening] = _parts_of(self.scene.opened(opening))
        return self._kept[opening]


def _around(thing: Thing, share: float, without: str, belief: Belief) -> list[Geom]:
    """Return the geoms near a thing, in the base frame, except those of the thing ``without``.

    Args:
        share: of the diagonal of the box around the thing, by which they may be farther from its middle than
            ``AROUND``.
    """
    low, high = box_around(thing.geoms)
    centre, reach = belief.pose(thing.name).apply((low + high) / 2), share * float(np.linalg.norm(high - low))
    base, every = belief.base().inverse(), []
    for other in belief.world.things:
        at = belief.pose(other.name) if other.name in belief.poses else base * other.pose
        every += [replace(g, pose=at * g.pose) for g in other.geoms if other.name != without]
    most = reach + AROUND
    return [g for g in every if np.linalg.norm(g.pose.position - centre) < most + g.bounding_radius]


def _reaches_into(shape: rays.Body, hands: Hands, part: Part, distance: float) -> NDArray[np.bool_]:
    """Whether a part of the hand may be nearer to a shape than a distance [m], for each TCP pose (n,)."""
    met = np.ones((len(hands.positions), len(shape.geoms)), bool)
    for box in part:
        met &= overlaps(
            shape, hands.positions + hands.turns @ box.centre, hands.turns @ box.turn, box.half + distance
        )
    return np.asarray(met.any(axis=1))


def _column(hole: Feature) -> Geom | None:
    """Column along a hole's axis that extends to both sides, as the room that a peg or bar needs; None for
    other features."""
    if hole.type != HOLE or "diameter" not in hole.size:
        return None
    half = hole.size["diameter"] / 2
    if "width" in hole.size:
        return Geom("box", (half, half, AROUND), hole.pose)
    return Geom("cylinder", (half, AROUND), hole.pose)


def _parts_of(scene: Any) -> list[Part]:
    model, data = scene.compiled.model, scene.data
    mujoco.mj_kinematics(model, data)
    tool = Pose.from_matrix(data.site_xmat[scene.index.tcp].reshape(3, 3)).rotation
    at, found = data.site_xpos[scene.index.tcp], []
    for g in np.flatnonzero(scene.moved[:, -1] > 0).tolist():
        turn, place = tool.T @ data.geom_xmat[g].reshape(3, 3), tool.T @ (data.geom_xpos[g] - at)
        box = model.geom_aabb[g]
        boxes = [_Box(place + turn @ box[:3], turn, box[3:].copy())]
        if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH:
            boxes.append(_along_tool(place + _corners(model, g) @ turn.T))
        found.append(boxes)
    return found


def _corners(model: Any, geom: int) -> Floats:
    """Corners (n, 3) of a mesh in its geom's frame [m]."""
    mesh = int(model.geom_dataid[geom])
    first = int(model.mesh_vertadr[mesh])
    return np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], float)


def _along_tool(points: Floats) -> _Box:
    low, high = points.min(axis=0), points.max(axis=0)
    return _Box((low + high) / 2, np.eye(3), (high - low) / 2)
