"""Force-controlled steps of Python programs for ur_rtde, copied into each program that has such steps
(``ur_rtde_arm``).

What the URScript functions of ``urscript_search`` do, with the same conditions: force mode of type 2, alone or around moveL.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .runtime_arm import GENTLE, Arm, Failed, Vector, log

# ---- motions in force mode: they end at their goal, at the force limit [N] or at the time-out [s] ----
ALONG_Z = (0, 0, 1, 0, 0, 0)
ALL_WAYS = (1, 1, 1, 0, 0, 0)
RIM = 2.0  # a force across of more than this times the pressing force is more than the friction of a face
LEAST = 0.25  # share of the pressing force below which a slide has lost its contact


def axis(frame: Vector) -> list[float]:
    """The z axis of a frame [x, y, z, rx, ry, rz], in the base frame."""
    return turned(frame, (0.0, 0.0, 1.0))


def turned(frame: Vector, way: Vector) -> list[float]:
    """Rotate a vector from the axes of a frame to those of the base frame (Rodrigues)."""
    angle = math.hypot(*frame[3:])
    if angle < 1e-9:
        return list(way)
    k = [v / angle for v in frame[3:]]
    across = [k[1] * way[2] - k[2] * way[1], k[2] * way[0] - k[0] * way[2], k[0] * way[1] - k[1] * way[0]]
    along = sum(a * b for a, b in zip(k, way, strict=True)) * (1 - math.cos(angle))
    return [w * math.cos(angle) + c * math.sin(angle) + a * along for w, c, a in zip(way, across, k, strict=True)]


def way_along(arm: Arm, start: Vector, direction: Vector) -> float:
    """Distance that the tool has moved from a pose along a direction [m]."""
    return sum((h - s) * d for h, s, d in zip(arm.tcp()[:3], start[:3], direction, strict=True))


class ForceMode:
    """Context manager in which force mode is on; a motion that is started inside it is stopped at its end."""

    def __init__(self, arm: Arm, frame: Vector, selection: Sequence[int], wrench: Vector, limits: Vector) -> None:
        self.arm = arm
        self.order = (list(frame), list(selection), list(wrench), 2, list(limits))

    def __enter__(self) -> None:
        self.arm.done(self.arm.control.forceMode(*self.order), "forceMode")
        self.arm.taken()

    def __exit__(self, *_: object) -> None:
        self.arm.rest()


def watched(arm: Arm, step: str, limit: float, timeout: float, late: str, ended: Callable[[], bool]) -> float:
    """Wait until a condition holds; return the time that it took [s].

    Raises:
        Failed: the force exceeded its limit, or the time is over.
    """
    measured = 0.0

    def over() -> bool:
        nonlocal measured
        measured = math.hypot(*arm.force())
        return measured > limit or ended()

    waited = arm.wait(over, timeout)
    if measured > limit:
        raise Failed(f"{step}: force {measured:.3f} N > {limit:g} N")
    if waited > timeout:
        raise Failed(f"{step}: {late} within {timeout:g} s")
    return waited


def along_path(arm: Arm, waypoints: Sequence[Vector], speed: float) -> Callable[[], bool]:
    """Return a function that sends the tool to the next waypoint at each call, and returns True once the last
    one is reached."""
    left = [list(w) for w in waypoints]

    def arrived() -> bool:
        if arm.moving():
            return False
        if not left:
            return True
        target = left.pop(0)
        arm.start(lambda: bool(arm.control.moveL(target, speed, GENTLE, True)))
        return False

    return arrived


def force_move(
    arm: Arm, step: str, waypoints: Sequence[Vector], *, frame: Vector, selection: Sequence[int], wrench: Vector,
    limits: Vector, speed: float, force_limit: float, timeout: float,
) -> None:  # fmt: skip
    """Move along waypoints while the selected axes of a frame are compliant."""
    arm.at()
    with ForceMode(arm, frame, selection, wrench, limits):
        watched(arm, step, force_limit, timeout, "not done", along_path(arm, waypoints, speed))


def slide(
    arm: Arm, step: str, waypoints: Sequence[Vector], *, frame: Vector, force: float, height: float, speed: float,
    lost: float, force_limit: float, timeout: float,
) -> None:  # fmt: skip
    """Slide along waypoints on a surface, pressing along z of a frame and following the surface's height."""
    arm.at()
    direction, arrived = axis(frame), along_path(arm, waypoints, speed)
    missed, looked = 0.0, arm.time()

    def ended() -> bool:
        nonlocal missed, looked
        before, looked = looked, arm.time()
        touching = -sum(f * d for f, d in zip(arm.force(), direction, strict=True)) >= LEAST * force
        missed = 0.0 if touching else missed + min(looked - before, 0.1)  # while nobody looked, nothing was missed
        if missed > lost:
            raise Failed(f"{step}: no contact for {missed:.3f} s")
        return arrived()

    with ForceMode(arm, frame, ALONG_Z, (0, 0, force, 0, 0, 0), (0.15, 0.15, height, 0.35, 0.35, 0.35)):
        watched(arm, step, force_limit, timeout, "not done", ended)


def spiral(center: Vector, frame: Vector, pitch: float, radius: float) -> list[list[float]]:
    """Points of an Archimedean spiral in the plane across z of a frame, in chords of 1 mm."""
    points, angle, out = [], 0.0, 0.0
    while out < radius:
        angle += 0.001 / (out + 0.001)
        out = pitch * angle / math.tau
        way = turned(frame, (out * math.cos(angle), out * math.sin(angle), 0.0))
        points.append([*(c + w for c, w in zip(center[:3], way, strict=True)), *center[3:]])
    return points


def spiral_search(
    arm: Arm, step: str, *, frame: Vector, force: float, pitch: float, radius: float, speed: float, advance: float,
    force_limit: float, timeout: float,
) -> None:  # fmt: skip
    """Press along z of a frame and move across it on a spiral, until the tool sinks in or is held by the rim
    of a hole."""
    arm.at()
    direction, start = axis(frame), arm.tcp()
    arrived = along_path(arm, spiral(list(arm.receive.getTargetTCPPose()), frame, pitch, radius), speed)
    way = across = 0.0

    def ended() -> bool:
        nonlocal way, across
        measured, way = arm.force(), way_along(arm, start, direction)
        along = sum(f * d for f, d in zip(measured, direction, strict=True))
        across = math.hypot(*(f - along * d for f, d in zip(measured, direction, strict=True)))
        if way >= advance or across >= RIM * force:
            return True
        if arrived():
            raise Failed(f"{step}: nothing gave way within a radius of {radius:g} m")
        return False

    with ForceMode(arm, frame, ALONG_Z, (0, 0, force, 0, 0, 0), (0.15, 0.15, 0.02, 0.35, 0.35, 0.35)):
        waited = watched(arm, step, force_limit, timeout, "nothing gave way", ended)
    if way >= advance:
        log(f"{step}: it gave way after {waited:.3f} s")
    else:
        log(f"{step}: a rim holds it after {waited:.3f} s, {across:.3f} N")


def force_along(
    arm: Arm, step: str, *, frame: Vector, wrench: Vector, way: float, speed: float, force_limit: float, timeout: float
) -> None:
    """Push or pull with forces on x, y and z of a frame, until the tool has moved a distance along z."""
    arm.at()
    direction, start = axis(frame), arm.tcp()
    with ForceMode(arm, frame, ALL_WAYS, (*wrench, 0, 0, 0), (speed, speed, speed, 0.35, 0.35, 0.35)):
        done = watched(
            arm, step, force_limit, timeout, f"less than {way:g} m", lambda: way_along(arm, start, direction) >= way
        )
    log(f"{step}: {way:g} m after {done:.3f} s")
