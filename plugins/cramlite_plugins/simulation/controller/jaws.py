"""Finger mechanisms of a gripper as its drive moves and measures them: two slides that share an opening, or a
linkage read from a robot file."""

from __future__ import annotations

from bisect import bisect_right
from typing import Any, Protocol

import numpy as np

from cramlite.model import Gripper

from ..model.index import LinkageIndex, RobotIndex
from .gripper_order import COUNTS


class Jaws(Protocol):
    """The finger mechanism of a gripper, through which its drive sets the opening, measures it and limits the force."""

    def measured(self, data: Any) -> float:
        """Return the measured opening [m]."""

    def order(self, data: Any, opening: float) -> None:
        """Command the fingers to an opening [m]."""

    def limit(self, force: float, opening: float) -> None:
        """Set the largest force with which each pad may press [N], at the present opening of the fingers [m]."""


def jaws_of(gripper: Gripper, index: RobotIndex, model: Any) -> Jaws:
    """Return the mechanism of a gripper."""
    return Slides(gripper, index, model) if index.linkage is None else Linked(index.linkage, model)


class Slides:
    """Two coupled slides: each travels half of a change of the opening."""

    def __init__(self, gripper: Gripper, index: RobotIndex, model: Any) -> None:
        self.index, self.model = index, model
        low, self.widest = gripper.opening
        self.stroke = self.widest - low
        fingers = [(a, np.flatnonzero(model.jnt_qposadr == a)[0]) for a in index.fingers]
        self.fingers = [(a, self.stroke / len(fingers) / float(model.jnt_range[j, 1])) for a, j in fingers]

    def measured(self, data: Any) -> float:
        """Return the measured opening [m]."""
        qpos = data.qpos
        return float(self.widest - sum([scale * qpos.item(a) for a, scale in self.fingers]))  # a generator would take twice as long

    def order(self, data: Any, opening: float) -> None:
        """Command the fingers to an opening [m]."""
        data.ctrl[self.index.gripper] = COUNTS * (self.widest - opening) / self.stroke

    def limit(self, force: float, opening: float) -> None:
        """Limit the grip force of each pad [N]: the tendon pulls both, so twice that of one (robots/parallel_gripper.py)."""
        self.model.actuator_forcerange[self.index.gripper] = (-2 * force, 2 * force)


class Linked:
    """Finger linkage from a robot file: openings, commands and forces are interpolated in a table along its stroke."""

    def __init__(self, linkage: LinkageIndex, model: Any) -> None:
        self.linkage, self.model = linkage, model
        self.encoders = [(a, w) for a, w in zip(linkage.joints, linkage.measured, strict=True) if w]
        self.narrow = [-o for o in linkage.openings]

    def measured(self, data: Any) -> float:
        """Return the opening [m] that follows from the encoders of the drives, as if the linkage did not
        bend."""
        qpos = data.qpos
        return _between(sum([w * qpos.item(a) for a, w in self.encoders]), self.linkage.readings, self.linkage.openings)

    def order(self, data: Any, opening: float) -> None:
        """Command the fingers to an opening [m]."""
        for a, column in zip(self.linkage.actuators, self.linkage.controls, strict=True):
            data.ctrl[a] = _between(-opening, self.narrow, column)

    def limit(self, force: float, opening: float) -> None:
        """Limit the grip force of each pad [N], by the linkage's leverage at an opening [m]."""
        for a, column in zip(self.linkage.actuators, self.linkage.forces, strict=True):
            most = force * _between(-opening, self.narrow, column)
            self.model.actuator_forcerange[a] = (-most, most)


def _between(x: float, xs: Any, ys: Any) -> float:
    """Interpolate a rising table at one number; NumPy takes ten times as long for that."""
    k = min(max(bisect_right(xs, x) - 1, 0), len(xs) - 2)
    share = min(max((x - xs[k]) / (xs[k + 1] - xs[k]), 0.0), 1.0)
    return float(ys[k] + share * (ys[k + 1] - ys[k]))
