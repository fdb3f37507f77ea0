"""Readings written by hand, and the proof that they are compared with: a second in which a block stands about."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cramlite.engine.recovery.expectation import EXACT, Expectation, Noise, RunWatch
from cramlite.model import Deviation, Floats, Notice, Pose, Readings

COUNT, PERIOD = 51, 0.02
STANDS = Pose((0.5, 0.0, 0.05))
TOOL = Pose((0.5, 0.0, 1.05))
SIDE = Pose.from_rotvec((0.3, 0.2, 0.5), (math.pi / 2, 0.0, 0.0))  # the tool's -z is the world's +y


def readings(time: float, **changed: Any) -> Readings:
    """Return the sensor readings at a time while a block stands still and the only joint moves."""
    pose = changed.pop("block", STANDS)
    poses = {"block": pose} if pose is not None else {}
    usual = {"line": 1, "joints": (time,), "opening": 0.08, "force": 0.0, "pressing": 0.0}
    hand = {"tool": TOOL, "across": (1, 0, 0)}
    return Readings(time, **({"poses": poses} | usual | hand | changed))


def track(pose: Pose) -> Floats:
    return np.tile([*pose.position, *pose.quaternion], (COUNT, 1))


def proof() -> Expectation:
    """Return the expectation of a second in which a block stands still, 1 m below the tool, and the only joint moves."""
    return Expectation(
        np.ones(COUNT), np.arange(COUNT) * PERIOD, {"block": track(STANDS)},
        {"block": np.tile([0.0, 0.0, -1.0], (COUNT, 1))}, ("",) * COUNT, np.full(COUNT, 0.08), np.zeros(COUNT),
        np.linspace(0, 1, COUNT)[:, None], ("block",), frozenset({"block"}),
        {1: "1.Reaching/move", 3: "2.Grasping/close"},
    )  # fmt: skip


def seen(watch: RunWatch, *those: Readings) -> Notice | None:
    """Return the notice of a run's watcher after the last of some readings; it must give none before."""
    found = [watch.see(one) for one in those]
    assert not any(found[:-1]), found
    return found[-1]


def twice(expected: Expectation, noise: Noise = EXACT, began: float = 0.0, **changed: Any) -> Notice | None:
    """Return the notice after a deviating reading was repeated, following one reading as in the proof."""
    first = readings(began, line=changed.get("line", 1))
    return seen(RunWatch(expected, noise), first, *(readings(began + k, **changed) for k in (0.02, 0.04)))


def kind(notice: Notice | None) -> Deviation | None:
    return notice.kind if notice else None
