"""Force at the wrist of a robosuite robot during an action, for the benchmarks' scripts beside this file.

They run in environments of their own, so nothing of cramlite is imported here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


class WristForce:
    """Recorder of the force at a robot's wrist in each physics step of an action, for its mean.

    robosuite's own value is that of the last physics step. An impact on something hard lasts for one of them: a drawer that met its stop at
    15 mm/s was felt with 63 N for 2 ms, which one sample in 25 sees: a program stopped for it that had pressed with 2 N. The sensors of
    arms are filtered, and so is that of the proof: at 10 Hz, about as a mean over 50 ms.

    Args:
        env: of robosuite; its next reset forgets this.
        read: returns what the sensor says now (3,) [N].
    """

    def __init__(self, env: Any, read: Callable[[], Any]) -> None:
        from robosuite.utils.observables import Observable, sensor

        self.felt = [np.array(read())]

        @sensor(modality="wrist_force")
        def wrist_force(_: Any) -> Any:
            self.felt.append(np.array(read()))
            return self.felt[-1]

        env.add_observable(Observable("wrist_force", wrist_force, sampling_rate=1.0 / env.model_timestep))

    def begin(self) -> None:
        """Discard the forces of earlier actions, at the beginning of an action."""
        self.felt.clear()

    def mean(self) -> Any:
        """Return the mean of the forces (3,) that the sensor has read since the action began [N], in the axes
        of the sensor."""
        return np.mean(self.felt, axis=0)
