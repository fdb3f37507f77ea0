"""Peak forces of a wrist sensor between two samples: a single cycle would make peaks a matter of chance."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Floats

from ..controller.controller import Controller


class Peaks:
    """A collector of peak forces at the recorder's sample times.

    Args:
        period: of the samples [s].
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.wrenches: list[Floats] = []
        self.forces: list[float] = []
        self.commanded: list[float] = []
        self._wrench, self._force, self._wanted = np.zeros(6), 0.0, 0.0

    def see(self, time: float, arm: Controller) -> None:
        """Record a control cycle: the tool's wrench (``Rollout.wrench``), the felt force (``Rollout.force``), and the one that
        the program asks for (``Rollout.commanded``)."""
        wrench = arm.applied()
        force = math.hypot(*(arm.wrench() if arm.sensor.tared else wrench)[:3])
        if np.linalg.norm(wrench[:3]) > np.linalg.norm(self._wrench[:3]):
            self._wrench = wrench
        self._force = max(self._force, force)
        mode = arm.force_mode
        wanted = 0.0 if mode is None else float(np.linalg.norm((mode.selection * mode.wrench)[:3]))
        self._wanted = max(self._wanted, wanted)
        if time >= len(self.wrenches) * self.period - 1e-9:
            self.wrenches.append(self._wrench)
            self.forces.append(self._force)
            self.commanded.append(self._wanted)
            self._wrench, self._force, self._wanted = wrench, force, wanted

    def arrays(self) -> dict[str, Floats]:
        """Return the fields of a rollout: wrench (N, 6) [N, Nm], force (N,) and commanded (N,) [N]."""
        fields = {"wrench": self.wrenches, "force": self.forces, "commanded": self.commanded}
        return {name: np.array(values) for name, values in fields.items()}
