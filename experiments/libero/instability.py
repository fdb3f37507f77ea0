"""Detection of unstable simulations: MuJoCo resets these to their initial state, and only a counter of warnings shows it."""

from __future__ import annotations

from typing import Any

WARNINGS = ("BADQPOS", "BADQVEL", "BADQACC")
"""Warnings of mjtWarning after which mj_step resets the state."""


def instability(data: Any) -> str:
    """Explain in words why a simulation cannot go on from where it was; "" while it can.

    Args:
        data: MuJoCo's, after a step.
    """
    import mujoco

    kinds = (getattr(mujoco.mjtWarning, f"mjWARN_{name}") for name in WARNINGS)
    if not any(data.warning[int(kind)].number for kind in kinds):
        return ""
    return "The benchmark's simulation became unstable, and began anew from its file: nothing is where it was"
