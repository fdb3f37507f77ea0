"""A rollout: what a simulator recorded, sample by sample.

Both a human demonstration and the execution of a program give one; the same
event detection turns either into an episode.
"""

from __future__ import annotations

from msgspec import field

from .geometry import Floats, Vector3
from .value import Value
from .world import World


class Touch(Value):
    """A contact between two bodies at one sample.

    Args:
        a, b: "thing" or "thing/part" for things; "effector/left" and "effector/right" for the two
            finger pads (thumb and index of a hand); "effector/body" for the rest of it.
        force: normal force, summed over the contact points [N].
        lift: vertical component of the whole force that ``a`` exerts on ``b`` [N], up positive.
    """

    a: str
    b: str
    force: float
    lift: float


class Message(Value):
    """A line of the program's own log.

    Args:
        time: since the start [s].
        text: what the program wrote.
        line: of the program, 0 for none.
    """

    time: float
    text: str
    line: int = 0


class Rollout(Value):
    """Samples at a constant rate.

    Args:
        world: the world at the start.
        effector: name of the hand or robot.
        times: (N,) [s].
        poses: thing name -> (N, 7), position and quaternion (w, x, y, z), world frame; further
            frames "effector", "effector/left", "effector/right" (finger tips).
        touches: N tuples.
        joints: (N, J) arm joints [rad]; J = 0 for a hand.
        wrench: (N, 6) what the effector applies to its environment, at the sensor, world axes [N, Nm].
        opening: (N,) distance between the finger pads [m].
        lines: (N,) program line under execution, 0 for none.
        messages: the program's log.
        outcome: "finished", or why it ended: "halted", "protective stop", "timeout", "error".
        reason: one clause with numbers when the outcome is not "finished".
        extra: further numbers that a simulator measured, by name.
        values: thing name -> (N,) value of the joint that it moves on [m, rad].
        grains: thing name -> (N, count, 3) centres of the balls that it was filled with, world frame [m].
        sizes: of what is in ``poses`` and no thing: "mount/base" is a robot's platform; length, width, height over its
            frame [m].
        seen: thing name -> when a camera first saw it [s], infinite for never; of what nobody knew at the start where it
            is (``World.poses``), so it is empty where everything is known.
        force: (N,) what the program feels, URScript's ``force()``: at the TCP, without the weight of what the program says
            that it carries, since the last tare; before the first one as ``wrench`` [N]; None where no controller ran.
    """

    world: World
    effector: str
    times: Floats
    poses: dict[str, Floats]
    touches: tuple[tuple[Touch, ...], ...]
    joints: Floats
    wrench: Floats
    opening: Floats
    lines: Floats
    messages: tuple[Message, ...] = ()
    outcome: str = "finished"
    reason: str = ""
    extra: dict[str, float] = field(default_factory=dict)
    values: dict[str, Floats] = field(default_factory=dict)
    grains: dict[str, Floats] = field(default_factory=dict)
    sizes: dict[str, Vector3] = field(default_factory=dict)
    seen: dict[str, float] = field(default_factory=dict)
    force: Floats | None = None

    def contact_force(self) -> Floats:
        """(N,) ``force``, or, where nobody tared a sensor, the magnitude of ``wrench`` [N]."""
        norm: Floats = (self.wrench[:, :3] ** 2).sum(axis=1) ** 0.5
        return norm if self.force is None else self.force
