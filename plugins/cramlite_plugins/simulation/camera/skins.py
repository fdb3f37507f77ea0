"""Textured things in a camera's picture: rays hit their visual meshes instead of their collision shapes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import mujoco
import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Pose, Thing, Value

from ...shapes.skins import Skin, skin_of
from ..model.index import Data, Model, ThingIndex
from .ray_tracer import cast

Hits = tuple[NDArray[np.int32], Floats, Floats]
"""Geom ids (N,), distances (N,) [m], surface normals (N, 3), as ``cast`` gives them."""


class Skins(Value, eq=False):
    """Visual meshes of the textured things of a world.

    Args:
        things: their names; skins: their surfaces.
        bodies: of the things in the world's model.
        model: MjModel of the visual meshes, one body each, in the order of ``things``.
    """

    things: tuple[str, ...]
    skins: tuple[Skin, ...]
    bodies: tuple[int, ...]
    model: Model

    def met(self, model: Model, data: Data, eye: Floats, directions: Floats) -> tuple[Hits, NDArray[np.int32], Floats]:
        """Cast rays in a world in which visual meshes stand in for the collision shapes of textured things.

        Args:
            eye: (3,) and directions: (N, 3), unit length, world frame.

        Returns:
            What ``cast`` gives of the nearest surface, a geom of the thing for a visual mesh; the index of the textured
            thing that each ray meets first (N,), -1 for none; and its colours (N, 3), 0 to 1, where it meets one.
        """
        with _invisible(model, self.bodies):
            geom, distance, normal = cast(model, data, eye, directions)
        own = self._placed(data)
        skin, near, facing = cast(self.model, own, eye, directions)
        first = (skin >= 0) & ((geom < 0) | (near < distance))
        which = np.where(first, self.model.geom_bodyid[np.maximum(skin, 0)] - 1, -1).astype(np.int32)
        colours = np.zeros((len(directions), 3))
        for k, body in enumerate(self.bodies):
            on = which == k
            if on.any():
                frame = Pose(tuple(data.xpos[body]), tuple(data.xquat[body]))
                points = frame.inverse().apply(eye + directions[on] * near[on, None])
                colours[on] = self.skins[k].colours_at(points, frame.inverse().rotate(facing[on])) / 255.0
        representative = np.array([model.body_geomadr[b] for b in self.bodies], np.int32)
        geom = np.where(first, representative[which], geom).astype(np.int32)
        hits = geom, np.where(first, near, distance), np.where(first[:, None], facing, normal)
        return hits, which, colours

    def _placed(self, data: Data) -> Data:
        """Data of the visual model with each mesh at the pose of its thing."""
        own = mujoco.MjData(self.model)
        own.mocap_pos[:], own.mocap_quat[:] = data.xpos[list(self.bodies)], data.xquat[list(self.bodies)]
        mujoco.mj_kinematics(self.model, own)
        return own


def skins_of(things: tuple[Thing, ...], indices: Mapping[str, ThingIndex]) -> Skins | None:
    """Return the visual meshes of a world's textured things; None if it has none.

    Raises:
        UserError: a mesh file cannot be read.
    """
    found = [(t.name, skin) for t in things if t.name in indices and (skin := skin_of(t.mesh)) is not None]
    if not found:
        return None
    names, skins = tuple(n for n, _ in found), tuple(s for _, s in found)
    return Skins(names, skins, tuple(indices[n].body for n in names), visual_model(skins))


def visual_model(skins: tuple[Skin, ...]) -> Model:
    """Return a MuJoCo model with one movable body (mocap), at the origin, for each visual mesh."""
    spec = mujoco.MjSpec()
    meshes: dict[int, str] = {}
    for k, skin in enumerate(skins):
        name = meshes.get(id(skin))
        if name is None:
            name = meshes[id(skin)] = f"skin{k}"
            mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
            mesh.uservert = skin.corners.reshape(-1).astype(np.float32)
            mesh.userface = np.arange(3 * len(skin.corners), dtype=np.int32)
        body = spec.worldbody.add_body(name=f"thing{k}", mocap=True)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, contype=0, conaffinity=0)
    return spec.compile()


@contextmanager
def _invisible(model: Model, bodies: tuple[int, ...]) -> Iterator[None]:
    """Context in which the geoms of some bodies have zero opacity, so that MuJoCo's rays pass through them."""
    own = np.isin(model.geom_bodyid, bodies)
    before = model.geom_rgba[own, 3].copy()
    model.geom_rgba[own, 3] = 0.0
    try:
        yield
    finally:
        model.geom_rgba[own, 3] = before
