"""Errors of a force-torque sensor, as a robot declares them."""

from __future__ import annotations

from ..base.value import Value


class SensorErrors(Value):
    """Errors of the force-torque sensor of a robot.

    Torques have noise only: its standard deviation in Nm is a twentieth of ``noise``, which is in N.

    The defaults are those of the sensor in the flange of a UR5e, for robots that do not say. Its data sheet has a precision of 3.5 N.
    Right after a tare, warm and without turning the wrist, a threshold of 1 N is met: the noise is ours so that the largest of a
    thousand filtered readings is about 1 N. Its zero went from (-0.5, -0.1, 0.1) N to (-0.2, 1.3, 4.1) N within five minutes at rest
    (Universal_Robots_ROS_Driver #633).

    Args:
        noise: standard deviation of a reading of a control cycle, of each axis, before the controller's filter [N].
        precision: how far a reading is off whatever the cause, noise aside [N]: of the zero before a tare, and again of what a
            tare at one orientation leaves at another.
        drift: how fast the zero wanders at most [N/s].
    """

    noise: float = 0.5
    precision: float = 3.5
    drift: float = 0.014
