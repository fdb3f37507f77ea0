"""A rack: two boards that lean towards each other, with a trough between them."""

from __future__ import annotations

import math

from cramlite.model import Feature, Geom, Pose, Thing
from cramlite.plugin import Angle, Length

Colour = tuple[float, float, float, float]
BOARD = 0.006  # thickness [m]
LEG = 0.02  # thickness [m]
LEAN = math.radians(35.0)


def rack(
    name: str,
    pose: Pose,
    length: Length = 0.18,
    board: Length = 0.07,
    lean: Angle = LEAN,
    height: Length = 0.12,
    friction: float = 0.4,
    rgba: Colour = (0.62, 0.46, 0.30, 1.0),
) -> Thing:
    """Make two boards that meet along a line, on two legs. Frame: the middle of that line, x along it, z up. Feature "trough": there, z up.

    Args:
        length: of the boards (x).
        board: width of each.
        lean: how far each rises to its outer edge; below 0 they make a roof.
        height: of the line over what the rack stands on.
    """
    half = (length / 2, board / 2, BOARD / 2)
    boards = [
        Geom("box", half, Pose.from_rotvec((0, 0, 0), (side * lean, 0, 0)) * Pose((0, side * board / 2, -BOARD / 2)), rgba=rgba)
        for side in (1, -1)
    ]
    leg = (height - BOARD) / 2
    legs = [Geom("box", (LEG / 2, LEG / 2, leg), Pose((side * (length - LEG) / 2, 0, leg - height)), rgba=rgba) for side in (1, -1)]
    trough = Feature("trough", "vrps:SurfaceFeature", Pose(), {"width": length, "depth": 2 * board * math.cos(lean)})
    return Thing(name, "soma:DesignedFurniture", pose, (*boards, *legs), (trough,), None, friction)
