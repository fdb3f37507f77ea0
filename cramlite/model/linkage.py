"""Linkage of a gripper from a file: joints and actuators that move its pads, at each opening."""

from __future__ import annotations

from ..base.value import Value


class Linkage(Value):
    """Positions of a gripper's joints and commands to its actuators at K openings along its stroke, widest first; J
    joints, A actuators.

    Args:
        openings: distance between the pads (K), falling [m].
        joints: names in the model.
        positions: of the joints (K, J) [rad, m].
        measured: weight of each joint (J) in what its encoder reads; readings rise as the hand closes.
        actuators: names in the model.
        controls: of the actuators (K, A), in their own units.
        forces: of each actuator for one newton between the pads (K, A) [N or Nm].
    """

    openings: tuple[float, ...]
    joints: tuple[str, ...]
    positions: tuple[tuple[float, ...], ...]
    measured: tuple[float, ...]
    actuators: tuple[str, ...]
    controls: tuple[tuple[float, ...], ...]
    forces: tuple[tuple[float, ...], ...]

    @property
    def readings(self) -> tuple[float, ...]:
        """Return the encoder reading at each opening, (K,) [m, rad]: the joints' positions, weighted by
        ``measured``."""
        return tuple(sum(w * q for w, q in zip(self.measured, row, strict=True)) for row in self.positions)
