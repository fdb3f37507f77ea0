"""Things made from mesh files: any product, any tool, with the features that are found in its shape or declared."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from pydantic import Field

from cramlite.model import Feature, Geom, Inertia, MeshFile, Pose, Thing
from cramlite.plugin import Length, Mass, Spec, UserError

from ..shapes.shape import Shape, shape_of

Colour = tuple[float, float, float, float]
Direction = tuple[float, float, float]
STANDS = 0.0005  # what is this far above the lowest point is still underside [m]


class DeclaredFeature(Spec):
    """A feature as scenarios write it, in the file's frame: z is the functional axis, ``up`` its y axis."""

    name: str
    type: str
    position: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    axis: Direction = (0.0, 0.0, 1.0)
    up: Direction | None = None
    size: dict[str, Length] = Field({})

    def feature(self) -> Feature:
        """Convert a feature as scenarios declare it to a feature of the thing's model.

        Raises:
            ValueError: the axis is zero, or up is along it.
        """
        up = self.up or ((0.0, 1.0, 0.0) if abs(self.axis[2]) >= 0.9 else (0.0, 0.0, 1.0))
        side = np.cross(up, self.axis)
        if np.linalg.norm(side) < 1e-6:
            raise UserError(f"feature '{self.name}': axis {self.axis} and up {up} must be two directions")
        return Feature(self.name, self.type, Pose.from_axes(self.position, self.axis, side), dict(self.size))


def mesh_thing(
    name: str,
    pose: Pose,
    file: str,
    scale: float = 1.0,
    mass: Mass | None = None,
    density: float | None = None,
    fixed: bool = False,
    friction: float = 0.6,
    features: tuple[DeclaredFeature, ...] = (),
    detect: bool = True,
    rgba: Colour = (0.62, 0.58, 0.70, 1.0),
) -> Thing:
    """Make a thing from an STL, OBJ, PLY, OFF or GLB file, in the file's frame, z up.

    Its collision shape is convex parts, between which holes stay open; mass is ``mass``, or ``density`` times the volume.
    Holes ("hole"), handles ("handle") and the face it stands on ("bottom") are found in the shape; a declared feature
    of the same name takes the place of the found one.

    Args:
        file: the mesh.
        scale: from the file's unit to metres: 0.001 for millimetres.
        mass: exactly one of mass, density and `fixed: true`.
        density: kg/m3; the mass is this times the volume.
        fixed: furniture.
        features: `name`, `type`, `position`, `axis` (its z), `up` (its y), `size` (named lengths); one of
            a found name takes its place.
        detect: look for holes and handles.

    Raises:
        UserError: the scale, the choice of mass or density, or the file (``shapes.files``) cannot be used.
    """
    if not 1e-6 <= scale <= 1e6:
        raise UserError(f"scale {scale:g}; it must lie between 1e-6 and 1e6, e.g. 0.001 for a file in millimetres")
    shape = shape_of(Path(file), scale)
    weight = None if fixed else _mass(shape, mass, density)
    found = (*(shape.features if detect else ()), *_bottom(shape))
    declared = {d.name: d.feature() for d in features}
    geoms = tuple(Geom(g.shape, g.size, g.pose, g.part, rgba=rgba, corners=g.corners) for g in shape.geoms)
    return Thing(
        name, "cram:Product", pose, geoms, (*(f for f in found if f.name not in declared), *declared.values()),
        weight, friction, None if weight is None else _inertia(shape, weight), MeshFile(file, scale), shape.notes,
    )  # fmt: skip


def _mass(shape: Shape, mass: float | None, density: float | None) -> float:
    if (mass is None) == (density is None):
        raise UserError(
            f"a mesh of {1e6 * shape.volume:.1f} cm3 needs exactly one of 'mass' and 'density' (kg/m3: full cartons 300 to"
            " 800, water 1000, plastic 1100), or 'fixed: true'"
        )
    return mass if mass is not None else (density or 0.0) * shape.volume


def _inertia(shape: Shape, mass: float) -> Inertia:
    """Return the inertia of a body of even density; no principal moment is below that of a ball of 1 mm.

    This keeps the simulation stable.
    """
    xx, yy, zz, xy, xz, yz = (m * mass / shape.volume for m in shape.moments)
    least = 0.4 * mass * 1e-6
    return Inertia(shape.centre, (max(xx, least), max(yy, least), max(zz, least), xy, xz, yz))


def _bottom(shape: Shape) -> Iterable[Feature]:
    """Yield the face that a mesh stands on as a feature, if its lowest points form a face."""
    corners = np.concatenate([g.pose.apply(np.asarray(g.corners)) for g in shape.geoms])
    lowest = corners[:, 2].min()
    face = corners[corners[:, 2] < lowest + STANDS]
    width, depth = (float(v) for v in np.ptp(face[:, :2], axis=0))
    if min(width, depth) > 0.005:
        middle = (face[:, :2].min(axis=0) + face[:, :2].max(axis=0)) / 2
        at = Pose.from_axes((float(middle[0]), float(middle[1]), float(lowest)), (0, 0, -1), (1, 0, 0))
        yield Feature("bottom", "vrps:SurfaceFeature", at, {"width": width, "depth": depth})
