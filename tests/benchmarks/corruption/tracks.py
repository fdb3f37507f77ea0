"""Measures of a recorded run, from its tracks alone: poses, touches, joint values and forces. They ask no validator."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from cramlite.model import Rollout

SETTLED = 25
"""Sample at which things have come to rest on what they stand on: 0.5 s at 50 Hz."""


def way(run: Rollout, thing: str) -> Any:
    """Return the positions of a thing from when it had settled, (N, 3) [m]."""
    return run.poses[thing][SETTLED:, :3]


def rest(run: Rollout, thing: str) -> list[float]:
    """Return where a thing stood at first [m]."""
    return [float(n) for n in way(run, thing)[0]]


def end(run: Rollout, thing: str) -> list[float]:
    """Return where a thing was at last [m]."""
    return [float(n) for n in way(run, thing)[-1]]


def moved(run: Rollout, thing: str) -> float:
    """Return how far a thing ever was from where it stood [m]."""
    return float(np.linalg.norm(way(run, thing) - way(run, thing)[0], axis=1).max())


def climbed(run: Rollout, thing: str) -> float:
    """Return how far a thing ever was above where it stood [m]."""
    return float((way(run, thing)[:, 2] - way(run, thing)[0, 2]).max())


def apart(run: Rollout, other: Rollout, thing: str) -> float:
    """Return how far a thing's last places in two runs are apart [m]."""
    return float(np.linalg.norm(way(run, thing)[-1] - way(other, thing)[-1]))


def _of(body: str, thing: str) -> bool:
    return body == thing or body.startswith(f"{thing}/")


def press(run: Rollout, a: str, b: str) -> Any:
    """Return the force between two things, or parts of them, at each sample (N,) [N]."""
    return np.array(
        [
            sum(t.force for t in ts if (_of(t.a, a) and _of(t.b, b)) or (_of(t.a, b) and _of(t.b, a)))
            for ts in run.touches
        ]
    )


def held(run: Rollout, thing: str) -> Any:
    """Return whether a thing was between both pads, at each sample; closed fingers that press on a thing do not hold it."""
    return (
        (press(run, "effector/left", thing) > 0) & (press(run, "effector/right", thing) > 0) & (run.opening > 0.005)
    )


def holds(run: Rollout, thing: str) -> int:
    """Return how many times a thing was held for 0.2 s or more; gaps of less than that do not count."""
    change = np.flatnonzero(np.diff(np.concatenate([[0], _closed(held(run, thing)).astype(int), [0]])))
    return int(sum(b - a >= 10 for a, b in zip(change[::2], change[1::2], strict=True)))


def _closed(on: Any) -> Any:
    """Fill gaps of less than ten samples."""
    filled, k = on.copy(), np.flatnonzero(on)
    for a, b in pairwise(k):
        if b - a < 10:
            filled[a:b] = True
    return filled


def release(run: Rollout, thing: str) -> int:
    """Return the last sample at which a thing was held, 0 for never."""
    found = np.flatnonzero(held(run, thing))
    return int(found[-1]) if found.size else 0


def fell(run: Rollout, thing: str) -> float:
    """Return the longest way down of a thing without a touch of the hand [m]."""
    free = press(run, "effector", thing) <= 0
    deepest, top = 0.0, None
    for loose, height in zip(free[SETTLED:], way(run, thing)[:, 2], strict=True):
        top = (height if top is None else max(top, height)) if loose else None
        deepest = deepest if top is None else max(deepest, top - height)
    return float(deepest)


def _turns(run: Rollout, thing: str) -> Any:
    """Return the angle of a thing's z axis from where that pointed at first, at each sample [deg]."""
    w, x, y, z = run.poses[thing][SETTLED:, 3:].T
    axes = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    return np.degrees(np.arccos(np.clip(axes @ axes[0], -1, 1)))


def turned(run: Rollout, thing: str) -> float:
    """Return by how much a thing leans at last, compared with how it stood [deg]."""
    return float(_turns(run, thing)[-1])


def tipped(run: Rollout, thing: str) -> float:
    """Return by how much a thing ever leant [deg]."""
    return float(_turns(run, thing).max())


def spun(run: Rollout, other: Rollout, thing: str) -> float:
    """Return the angle between a thing's last attitudes in two runs [deg]."""
    same = abs(float(run.poses[thing][-1, 3:] @ other.poses[thing][-1, 3:]))
    return float(np.degrees(2 * np.arccos(min(same, 1.0))))


def spilled(run: Rollout, vessel: str, into: str) -> int:
    """Return how many balls are at last in neither of two vessels: farther than 0.12 m from the middle of both."""
    balls = run.grains[vessel][-1]
    far = [np.linalg.norm(balls - np.array(end(run, v)), axis=1) > 0.12 for v in {vessel, into}]
    return int(np.logical_and.reduce(far).sum())


def caught(run: Rollout, vessel: str, into: str) -> int:
    """Return how many balls of a vessel are within 0.09 m of the middle of another one at last, and not over its rim."""
    gap = run.grains[vessel][-1] - np.array(end(run, into))
    return int(((np.linalg.norm(gap[:, :2], axis=1) < 0.09) & (gap[:, 2] < 0.08)).sum())


def speed(run: Rollout) -> float:
    """Return the highest speed of the tool [m/s]."""
    return float(
        (np.linalg.norm(np.diff(way(run, "effector"), axis=0), axis=1) / np.diff(run.times[SETTLED:])).max()
    )


def value(run: Rollout, thing: str) -> float:
    """Return the last value of the joint that a thing moves on [m, rad]."""
    return float(run.values[thing][-1])


def closing_axis(run: Rollout, sample: int) -> list[float]:
    """Return the direction from one pad to the other at a sample, a unit vector."""
    gap = run.poses["effector/left"][sample, :3] - run.poses["effector/right"][sample, :3]
    return [float(n) for n in gap / np.linalg.norm(gap)]


def hand(run: Rollout, sample: int) -> list[float]:
    """Return the pose of the tool at a sample: x, y, z [m] and a rotation vector [rad]."""
    from scipy.spatial.transform import Rotation

    x, y, z, *turn = run.poses["effector"][sample].tolist()
    return [x, y, z, *Rotation.from_quat([*turn[1:], turn[0]]).as_rotvec().tolist()]
