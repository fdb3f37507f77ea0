"""The ATI Axia80-M20 force-torque sensor between an arm's flange and its gripper.

Height 25.4 mm, diameter 82 mm, 0.274 kg: ATI data sheet 9230-05-1512 (Axia80), without adapter plates. Noise: the resolution of the
200 N range, not checked. Precision: what weighing with an external wrist sensor spreads by (FT 300, UR forum, topic 229). Drift: ours.
"""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import Gripper, Pose, SensorErrors

HEIGHT, MASS = 0.0254, 0.274
ERRORS = SensorErrors(noise=0.1, precision=0.6, drift=0.005)


def with_sensor(gripper: Gripper) -> Gripper:
    """Return a gripper with the height and mass of the sensor added, as the sensor is between the flange
    and the gripper."""
    return replace(gripper, tcp=Pose((0.0, 0.0, HEIGHT)) * gripper.tcp, mass=gripper.mass + MASS)
