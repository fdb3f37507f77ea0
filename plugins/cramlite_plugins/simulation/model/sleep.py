"""Sleep of what rests: MuJoCo leaves a thing that is still out of its equations until something that moves touches it.

A thing falls asleep together with all that it touches, once all of these were still for ten steps, and never while it touches a
robot. In the step in which something that is awake touches one of them, all of them wake, before forces are computed. What sleeps
keeps its pose; its contacts are left out of the state (``awake_copy`` has them).
"""

from __future__ import annotations

import mujoco

from .index import Data, Model

STILL = 1e-5
"""What moves no faster is still [m/s]; of what turns it is the speed of its outside. A thing that crept so for 100 s would be 1 mm
away, a fifth of how far a bystander may get. MuJoCo's default of 1e-4 would hide 10 mm."""
SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


def let_sleep(model: Model) -> None:
    """Let the things of a model sleep. Where tendons are tied to each other nothing sleeps: MuJoCo 4.0 then ends with an error."""
    tied = model.eq_active0.astype(bool) & (model.eq_type == mujoco.mjtEq.mjEQ_TENDON)
    if not tied.any():
        model.opt.enableflags |= SLEEP
        model.opt.sleep_tolerance = STILL


def awake_copy(model: Model, data: Data) -> Data:
    """Return a copy of a state in which everything is awake, with all contacts and their forces."""
    copy, flags = mujoco.MjData(model), int(model.opt.enableflags)
    mujoco.mj_copyData(copy, model, data)
    model.opt.enableflags = flags & ~SLEEP
    mujoco.mj_forward(model, copy)
    model.opt.enableflags = flags
    return copy
