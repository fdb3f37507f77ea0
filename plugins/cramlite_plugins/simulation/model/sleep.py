"""Sleep of resting things: MuJoCo leaves them out of its equations until a moving one touches them.

A thing falls asleep together with all that it touches, once all of these rest, and never while it touches a robot. In the step in
which something that is awake touches one of them, all of them wake, before forces are computed. What sleeps keeps its pose; its
contacts are left out of the state (``awake_copy`` has them).
"""

from __future__ import annotations

from collections import deque

import mujoco
import numpy as np

from cramlite.model import Floats

from .grains import is_grain
from .index import Data, Model

SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
NEVER, ALLOWED = (int(getattr(mujoco.mjtSleepPolicy, f"mjSLEEP_{name}")) for name in ("NEVER", "ALLOWED"))
MAY = int(mujoco.mjtSleepPolicy.mjSLEEP_AUTO_ALLOWED)  # MuJoCo's own answer for what no actuator moves
SHAKES = 1e-3
"""Largest speed of a resting thing at any moment [m/s]. A can that stands on a box shakes in place with up to 5e-4, by the rounding
of contact normals, and stays within 5 um for as long as it stands (measured); a block or a bowl keeps 1e-6."""
CREEPS = 2e-5
"""Largest mean speed of a resting thing over one of ``WINDOWS`` [m/s]: a creeping thing would move by 2 mm in 100 s, less than half of a
bystander's default tolerance."""
ROLLS = 2e-4
"""Largest mean speed of a resting grain over one of ``WINDOWS``, of its moving and rolling together [m/s]: balls of 6 mm that lie in a
vessel roll on at up to 1e-4 (measured), and would keep the vessel awake."""
WINDOWS = 0.05, 0.5
"""Windows of mean speeds [s]: the shorter one lets most things sleep early, over the longer one a thing that shakes gets nowhere."""
PERIOD = 0.024  # of the samples that means are taken of [s]: three control cycles


class Sleep:
    """Watch over the sleep of a simulation's things: those that rest may sleep, the others are kept awake.

    Args:
        model: whose things sleep from now on. Where tendons are tied to each other none does: MuJoCo 4.0 would end with an error.
        cycle: how often ``look`` is called [s].
    """

    def __init__(self, model: Model, cycle: float) -> None:
        self._model = model
        tied = model.eq_active0.astype(bool) & (model.eq_type == mujoco.mjtEq.mjEQ_TENDON)
        may = (model.tree_sleep_policy == MAY) & ~tied.any()
        self._trees = np.flatnonzero(may)
        self._bodies = model.tree_bodyadr[self._trees]
        self._creeps = np.array([ROLLS if is_grain(model.body(b).name) else CREEPS for b in self._bodies])
        self._lever = model.dof_length[model.tree_dofadr[self._trees] + model.tree_dofnum[self._trees] - 1]
        self._every, self._cycles = max(1, round(PERIOD / cycle)), 0
        self._back = [round(window / (self._every * cycle)) for window in WINDOWS]
        self._seen: deque[Floats] = deque(maxlen=max(self._back) + 1)
        if len(self._trees):
            model.opt.enableflags |= SLEEP
            model.opt.sleep_tolerance = SHAKES
            model.tree_sleep_policy[self._trees] = NEVER

    def look(self, data: Data) -> None:
        """Let things that rest sleep, and keep the others awake; once a control cycle."""
        self._cycles += 1
        if not len(self._trees) or self._cycles % self._every:
            return
        asleep = data.tree_asleep[self._trees] >= 0
        if asleep.all():
            self._seen.clear()
            return
        self._seen.append(np.concatenate([data.xpos[self._bodies], data.xquat[self._bodies]], axis=1))
        self._model.tree_sleep_policy[self._trees] = np.where(asleep | self._still(), ALLOWED, NEVER)

    def _still(self) -> Floats:
        """Flags (T,) of T trees of bodies: whether each had a mean speed below its limit (``CREEPS``, for grains
        ``ROLLS``) over at least one of the time windows."""
        still = np.zeros(len(self._trees), dtype=bool)
        for window, back in zip(WINDOWS, self._back, strict=True):
            if len(self._seen) > back:
                squares = np.square(self._seen[-1] - self._seen[-1 - back])
                moved, turned = np.sqrt(np.add.reduceat(squares, (0, 3), axis=1)).T  # a third of the time of numpy's norms
                still |= moved + 2.0 * self._lever * turned < self._creeps * window
        return still


def awake_copy(model: Model, data: Data) -> Data:
    """Return a copy of a state in which everything is awake, with all contacts and their forces."""
    copy, flags = mujoco.MjData(model), int(model.opt.enableflags)
    mujoco.mj_copyData(copy, model, data)
    model.opt.enableflags = flags & ~SLEEP
    mujoco.mj_forward(model, copy)
    model.opt.enableflags = flags
    return copy
