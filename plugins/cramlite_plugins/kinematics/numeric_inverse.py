"""Inverse kinematics of arms without a solution in closed form: many starts, then a sweep of a redundant
joint.

Each start is led to the pose by a differential inverse kinematics problem with joint limits (mink: Zakka,
2024; a quadratic program a step). An arm with more than six joints can still move while its tool rests, so
from each solution the last joint is put at every value of a grid, one after the other, and the other joints
follow (Newton's method). The starts are drawn once and for all: the same pose has the same solutions in every
process.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from cramlite.model import Floats, Pose, Robot

Joints = tuple[float, ...]
Table = tuple[tuple[float, float, float], ...]
Refine = Callable[[Sequence[float], int | None], Joints | None]
"""Newton's method from joint positions, with one joint held or none; None where it does not converge."""

STARTS = 14  # 48 % of starts reach a reachable pose of the FR3 (200 starts, measured): 14 miss one in 10,000
# Six joints have no self-motion that leads on: 14 starts find a given branch in 51 %, 40 in 80 % (100, 60
# poses)
STARTS_OF_SIX = 40
ROUNDS = 20  # quadratic programs of a start
NEAR = 1e-3  # error that Newton's method is started below [m, rad]
LONGEST = 0.8  # longest step of a joint in one round [rad]: the linearisation does not hold for more
DAMPING = 1e-4  # of the quadratic program, in units of its cost
SWEEP = 0.48  # step of the redundant joint [rad]: 13 values for one that turns almost once around
SAME = 1e-4  # two solutions nearer than this are one [rad]


def solutions(robot: Robot, flange: Pose, refine: Refine) -> list[Joints]:
    """Solve inverse kinematics for the flange in the base frame: joint positions inside the limits,
    unordered."""
    found: list[Joints] = []
    for start in _reached(robot, flange):
        exact = refine(start, None)
        if exact is None or not inside(robot, exact):
            continue
        for q in _swept(robot, exact, refine):
            if not any(_near(q, other) for other in found):
                found.append(q)
    return found


def inside(robot: Robot, q: Sequence[float]) -> bool:
    """Check whether all joints are within their limits."""
    return all(low <= v <= high for v, (low, high) in zip(q, robot.limits, strict=True))


def grid(limits: tuple[float, float], step: float) -> list[float]:
    """Return the values at which a redundant joint is put [rad]: evenly between its limits, these
    included, some ``step`` apart."""
    low, high = limits
    values: list[float] = np.linspace(low, high, round((high - low) / step) + 1).tolist()
    return values


def _near(a: Joints, b: Joints) -> bool:
    return all(abs(x - y) < SAME for x, y in zip(a, b, strict=True))


def _swept(robot: Robot, start: Joints, refine: Refine) -> Iterator[Joints]:
    """Yield a solution, and others for the same flange pose: one for each value of a grid over the last
    joint's range."""
    yield start
    if len(start) <= 6:
        return
    values = grid(robot.limits[-1], SWEEP)
    for row in ([v for v in values if v >= start[-1]], [v for v in reversed(values) if v < start[-1]]):
        q = start
        for value in row:
            moved = refine((*q[:-1], value), len(start) - 1)
            if moved is None or not inside(robot, moved):
                break
            yield (q := moved)


def _reached(robot: Robot, flange: Pose) -> Iterator[Joints]:
    """Yield joint positions that bring the flange near a pose, each found from one of several starts."""
    import mink

    configuration, task, limits, starts = _solver(robot, threading.get_ident())
    task.set_target(mink.SE3(np.array([*flange.quaternion, *flange.position])))
    for start in starts:
        configuration.update(start)
        for _ in range(ROUNDS):
            if float(np.abs(task.compute_error(configuration)).max()) < NEAR:
                yield tuple(float(v) for v in configuration.q[: len(robot.joints)])
                break
            way = mink.solve_ik(configuration, [task], 1.0, "daqp", damping=DAMPING, limits=limits)
            longest = float(np.abs(way).max())
            configuration.integrate_inplace(way * min(1.0, LONGEST / max(longest, 1e-9)), 1.0)


@lru_cache(maxsize=8)
def _solver(robot: Robot, thread: int) -> tuple[Any, Any, list[Any], Floats]:
    """Return what mink solves with: the arm's model, the pose task of its flange, its joint limits, and start
    positions (count, n).

    Each thread has its own: solving moves the model.
    """
    import mink
    import mujoco

    model = mujoco.MjModel.from_xml_string(robot.mjcf())
    low, high = np.array(robot.limits).T
    count = STARTS if len(low) > 6 else STARTS_OF_SIX
    starts = np.zeros((count, model.nq))
    starts[:, : len(low)] = np.random.default_rng(0).uniform(low, high, (count, len(low)))
    starts[0, : len(low)] = robot.home
    task = mink.FrameTask("flange", "site", position_cost=1.0, orientation_cost=1.0)
    return mink.Configuration(model), task, [mink.ConfigurationLimit(model)], starts


@lru_cache(maxsize=4)
def span(robot: Robot) -> float:
    """Compute the largest distance of the wrist (origin of the last axis) from the origin of joint 2, within
    the joint limits [m].

    Each joint in turn is put where the distance is largest, until none can make it larger: its square depends
    on one joint's angle t as A + B cos t + C sin t, whose largest value within limits is known.
    """
    dh = robot.dh
    assert dh is not None
    best = 0.0
    for corner in (0.0, 0.5, 1.0):
        q = [low + corner * (high - low) for low, high in robot.limits]
        far, more = 0.0, 1.0
        while more > 1e-9:
            for j in range(1, len(dh) - 1):
                q[j] = _farthest(dh, q, j, robot.limits[j])
            far, more = _distance(dh, q), _distance(dh, q) - far
        best = max(best, far)
    return best


def _farthest(dh: Table, q: Sequence[float], j: int, limits: tuple[float, float]) -> float:
    """Return the angle of joint j that puts the wrist farthest from the origin of joint 2 [rad]."""

    def square(angle: float) -> float:
        return _distance(dh, [*q[:j], angle, *q[j + 1 :]]) ** 2

    east, north, west = (square(a) for a in (0.0, math.pi / 2, math.pi))
    middle = (east + west) / 2
    top = math.atan2(north - middle, (east - west) / 2)
    turned = [top + k * math.tau for k in (-1, 0, 1) if limits[0] <= top + k * math.tau <= limits[1]]
    return max((*turned, *limits), key=square)


def _distance(dh: Table, q: Sequence[float]) -> float:
    """Return the distance of the wrist (origin of the last axis) from the origin of joint 2 [m]."""
    from ..robots.dh_arm import forward

    return float(np.linalg.norm(forward(dh[1:-1], tuple(q[1:-1])).position))
