"""Rest: what supports a thing, whether it hangs, and whether it is at rest at the end of a run; one on a peg
may swing a little."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import GRAVITY, Floats, Pose, Rollout, Thing, Vector3, rotations, thing_of

CARRIES = 0.5  # what bears this share of a thing's weight carries it along: a drawer its contents, a tray its cups
REST = 0.01  # a thing at rest moves slower than this over the last half second [m/s]
SWING = 0.04
"""Largest speed of a thing that hangs on a peg at rest [m/s]: a pendulum on a peg has nothing to brake it.

Source: a body whose centre is d below the peg and swings by +-A gains h = A^2 / (2 d) of height at its turning points
(pendulum, small angles), and comes off only if it rises by the r of the peg's bent tip. Its period
2 pi sqrt((k^2 + d^2) / (g d)) is about 0.55 s for the products here (d = 70 mm, radius of gyration k = 34 mm), so that half a
second shows nearly the whole 2 A: 0.04 m/s are A = 10 mm, h = 0.7 mm, an eighth of r = 6 mm. Measured: 4.3 mm to and fro after
letting go, 3.7 mm after 12 s and 2.8 mm after 19 s; the hole moved by 0.5 mm in all that time.
"""
TURN = REST / 0.1
"""Rate of turn below which a thing is at rest over the last half second [rad/s]: a point 0.1 m from its axis is then slower than ``REST``,
too. Measured: what had been dropped into a basket turned by less than 0.001 rad/s when its run ended."""
SWING_TURN = SWING / 0.05
"""Largest rate of turn of a thing that hangs on a peg [rad/s]: that of ``SWING`` for a body that swings 50 mm below its peg; the products
here hang 60 to 70 mm below it. Measured: 0.01 to 0.03."""


def at_the_end(rollout: Rollout, name: str) -> Thing:
    """Return a thing at the pose that it has at the end of the run."""
    thing, row = rollout.world.thing(name), rollout.poses[name][-1]
    return replace(thing, pose=Pose.from_row(row))


def borne_by(rollout: Rollout, thing: str, sample: int) -> list[str]:
    """Return the things that bear a thing at a sample: at least ``CARRIES`` of its weight."""
    weight = (rollout.world.thing(thing).mass or 0.0) * GRAVITY
    touched = [(thing_of(t.a), thing_of(t.b), t.lift) for t in rollout.touches[sample]]
    lifts = [(a, lift) for a, b, lift in touched if b == thing] + [(b, -lift) for a, b, lift in touched if a == thing]
    return [other for other, lift in lifts if lift > CARRIES * weight]


def hangs(rollout: Rollout, thing: str, sample: int) -> bool:
    """Return whether a thing with a hole is borne by one with a peg at a sample."""
    pegs = {t.name for t in rollout.world.things if t.feature("vrps:Peg")}
    return bool(rollout.world.thing(thing).feature("vrps:Hole")) and bool(pegs.intersection(borne_by(rollout, thing, sample)))


def restless(rollout: Rollout, thing: str, *, hanging: bool) -> str:
    """Describe a thing that still moves or turns at the end of a run; empty if it is at rest.

    Of a hanging thing the hole must be at rest, and the rest may swing a little.
    """
    hole = rollout.world.thing(thing).feature("vrps:Hole") if hanging else None
    speed = _speed(rollout, thing, hole.pose.position if hole else (0.0, 0.0, 0.0))
    if speed > REST:
        what = f"the hole of '{thing}'" if hole else f"'{thing}'"
        return f"{what} still moves at {1000 * speed:.0f} mm/s at the end"
    swing = _speed(rollout, thing, (0.0, 0.0, 0.0)) if hole else 0.0
    if swing > SWING:
        return f"'{thing}' still swings at {1000 * swing:.0f} mm/s at the end"
    turn, limit = _turn(rollout, thing), SWING_TURN if hole else TURN
    said = f"'{thing}' still turns at {turn:.2g} rad/s at the end, limit {limit:.2g} rad/s"
    return said if turn > limit else ""


def _speed(rollout: Rollout, thing: str, point: Vector3) -> float:
    """Speed of a point of a thing in the last half second [m/s]: the diagonal of the box around its path,
    divided by the time."""
    recent = rollout.times >= rollout.times[-1] - 0.5
    poses = [Pose.from_row(row) for row in rollout.poses[thing][recent]]
    way = float(np.linalg.norm(np.ptp([p.apply(point) for p in poses], axis=0)))
    return way / (float(np.ptp(rollout.times[recent])) or 1.0)


def _turn(rollout: Rollout, thing: str) -> float:
    """Turning speed of a thing in the last half second [rad/s]: the largest of its summed rotations since
    then, about any axis, divided by the time."""
    recent = rollout.times >= rollout.times[-1] - 0.5
    turns = rotations(rollout.poses[thing][recent, 3:])
    if len(turns) < 2:
        return 0.0
    turned = np.cumsum(_rotvecs(turns[1:] @ turns[:-1].transpose(0, 2, 1)), axis=0)
    return float(np.linalg.norm(turned, axis=1).max() / np.ptp(rollout.times[recent]))


def _rotvecs(turns: Floats) -> Floats:
    """Rotation vectors (N, 3) of rotation matrices (N, 3, 3) by less than half a turn [rad]."""
    axes = np.array([turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]]).T / 2
    sines = np.linalg.norm(axes, axis=1)
    angles = np.arctan2(sines, (np.trace(turns, axis1=1, axis2=2) - 1) / 2)
    return np.asarray(axes * (angles / np.maximum(sines, 1e-300))[:, None])
