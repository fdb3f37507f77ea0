"""Scaled things: all lengths of a thing are multiplied by a factor about its own origin."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from ..model.geometry import Pose, vector3
from ..model.world.thing import Feature, Geom, Inertia, Thing


def scaled(thing: Thing, factor: float) -> Thing:
    """Scale a thing about its origin: geoms, features, looks and the dimensions of its inertia.

    Pose, mass and joint are kept.
    """
    return replace(
        thing,
        geoms=tuple(_geom(g, factor) for g in thing.geoms),
        features=tuple(_feature(f, factor) for f in thing.features),
        inertia=thing.inertia and _inertia(thing.inertia, factor),
        mesh=thing.mesh and replace(thing.mesh, scale=thing.mesh.scale * factor),
    )


def _geom(geom: Geom, factor: float) -> Geom:
    size, corners = tuple(factor * s for s in geom.size), tuple(map(vector3, factor * np.array(geom.corners)))
    return replace(geom, size=size, corners=corners, pose=_nearer(geom.pose, factor))


def _feature(feature: Feature, factor: float) -> Feature:
    return replace(feature, pose=_nearer(feature.pose, factor), size={name: factor * s for name, s in feature.size.items()})


def _inertia(inertia: Inertia, factor: float) -> Inertia:
    xx, yy, zz, xy, xz, yz = (factor**2 * m for m in inertia.moments)
    return Inertia(vector3(factor * np.array(inertia.centre)), (xx, yy, zz, xy, xz, yz))


def _nearer(pose: Pose, factor: float) -> Pose:
    return Pose(vector3(factor * np.array(pose.position)), pose.quaternion)
