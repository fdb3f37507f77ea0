"""A scene: the shapes of a run and where they are over time, for eyes. Whoever draws it needs no simulator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .geometry import Floats
from .value import Value


class Solid(Value):
    """A rigid piece of a body, as triangles.

    Args:
        body: whose frame it is given in.
        vertices: (V, 3) [m].
        faces: (F, 3) indices, counter-clockwise seen from outside.
        colour: red, green, blue and opacity, 0 to 1.
    """

    body: str
    vertices: Floats
    faces: Any
    colour: tuple[float, float, float, float]


class Scene(Value):
    """Shapes in motion.

    Args:
        times: (N,) [s].
        solids: what is seen.
        poses: body -> (N, 7), position [m] and quaternion (w, x, y, z) in the world; (1, 7) for what never moves.
        owners: body -> the thing or robot that it belongs to.
    """

    times: Floats
    solids: tuple[Solid, ...]
    poses: Mapping[str, Floats]
    owners: Mapping[str, str]
