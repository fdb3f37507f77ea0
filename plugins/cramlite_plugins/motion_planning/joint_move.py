"""Motions through joint positions as steps of a program, slowed where the tool would be faster than it may
be."""

from __future__ import annotations

from collections.abc import Sequence

from cramlite.model import TOOL_SPEED, Motion, MoveJoints, Robot

from ..kinematics.tool_speed import passable_speed


def joint_move(
    motion: Motion,
    robot: Robot,
    points: Sequence[tuple[float, ...]],
    pace: tuple[float, float],
    radii: Sequence[float] = (),
) -> MoveJoints:
    """Return the program step that carries out a motion along joint positions.

    Args:
        points: joint positions, the start included [rad].
        pace: speed and acceleration of the leading axis that are wanted [rad/s, rad/s2].
        radii: of the corners [m].
    """
    speed = passable_speed(robot, points, *pace)
    slower = (
        f"{speed:g} instead of {pace[0]:g} rad/s, as the tool goes {TOOL_SPEED:g} m/s at most"
        if speed < pace[0]
        else ""
    )
    comment = "; ".join(filter(None, (motion.reason, slower)))
    return MoveJoints(tuple(points[1:]), speed, pace[1], tuple(radii), origin=motion.name, comment=comment)
