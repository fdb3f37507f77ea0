"""Pieces of URScript that a person might write into a generated program, with the functions that it has."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Lines = tuple[str, ...]
Pose = Sequence[float]

DOWN = (0.0, 3.141593, 0.0)
"""Rotation vector of a hand that points down, its fingers along the base's y axis, as ParkingArms leaves it [rad]."""

WIDE = 15
"""Position of the fingers at an opening of 80 mm, as the programs have it [0 to 255]."""

SHUT = 255
"""Position of closed fingers [0 to 255]."""

USUAL_GRIP = 33
"""Force of the fingers for 0.2 kg, as the programs have it [0 to 255]."""


def go(pose: Pose, speed: float = 0.2) -> str:
    """Move the tool on a straight line.

    Args:
        pose: x, y, z [m] and, unless the hand points down, a rotation vector [rad].
    """
    numbers = ", ".join(f"{n:.6f}" for n in (*pose, *DOWN)[:6])
    return f"  movel(p[{numbers}], a=0.5, v={speed:.3f})"


def fingers(position: int, grip: int = 0) -> str:
    """Move the fingers, whatever stops them."""
    return f'  move_gripper({position}, 157, {grip}, "any", 3.0, "fingers")'


def wait(seconds: float) -> str:
    """Stand still."""
    return f"  sleep({seconds:.2f})"


def above(pose: Pose, height: float) -> list[float]:
    """Return a pose that is higher by so much."""
    return [pose[0], pose[1], pose[2] + height, *pose[3:]]


def aside(pose: Pose, x: float, y: float) -> list[float]:
    """Return a pose beside another one."""
    return [pose[0] + x, pose[1] + y, *pose[2:]]


def excursion(lines: Iterable[str]) -> Lines:
    """Come back to the joint positions at which the lines begin."""
    return "  global here = get_actual_joint_positions()", *lines, "  movej(here, a=1.4, v=1.05)"


def taken(at: Pose, clearance: float = 0.15, grip: int = USUAL_GRIP) -> Lines:
    """Grip what stands somewhere."""
    return go(above(at, clearance)), fingers(WIDE), go(at, 0.1), fingers(SHUT, grip)


def put(at: Pose, clearance: float = 0.15, by: float = 0.002) -> Lines:
    """Bring the held thing to a place, open the fingers over that, and rise.

    Args:
        by: how far over the place they open [m].
    """
    return (
        go(above(at, max(clearance, by))),
        go(above(at, by), 0.1),
        fingers(WIDE),
        wait(0.5),
        go(above(at, max(clearance, by)), 0.1),
    )


def moved(at: Pose, to: Pose, lift: float = 0.1, by: float = 0.002) -> Lines:
    """Carry a thing from one place to another."""
    return *taken(at), go(above(at, lift), 0.1), go(above(to, lift)), *put(to, max(lift, 0.1), by)


def pressed(at: Pose, force: float, depth: float = 0.12) -> Lines:
    """Press closed fingers down, from ``depth`` over a point, until it pushes back [N]; then rise and open them."""
    down = f'  move_until_contact([0.0, 0.0, -1.0], {depth:.3f}, 0.02, {force:.1f}, 15.0, "any", "press")'
    return fingers(SHUT), go(above(at, depth)), down, go(above(at, depth), 0.1), fingers(0)


def shoved(start: Pose, end: Pose, speed: float = 0.05) -> Lines:
    """Move closed fingers low along a line, from above and back up; then open them."""
    return (
        fingers(SHUT),
        go(above(start, 0.2)),
        go(start, 0.1),
        go(end, speed),
        go(above(end, 0.2), 0.1),
        fingers(0),
    )


def leaning(pose: Pose, angle: float, axis: Sequence[float]) -> list[float]:
    """Return a pose of the hand that is turned about an axis of the base's frame [rad]."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_rotvec([angle * n for n in axis]) * Rotation.from_rotvec(list(pose[3:6]))
    return [*pose[:3], *turned.as_rotvec().tolist()]
