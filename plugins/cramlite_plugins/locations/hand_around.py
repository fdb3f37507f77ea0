"""Hand around the bar of a handle: the widest opening at which the hand touches nothing."""

from __future__ import annotations

from cramlite.model import Belief, GripFacts, Place, Pose, Thing
from cramlite.plugin import Context, Refused

from ..motion_planning.space import refusal
from .reached import Arm, Leg

STANDOFF = 0.08  # in front of the handle [m]: the fingers, open, are clear of the bar
SLACK = (0.05, 0.03, 0.016, 0.01)
"""Opening of the fingers beyond the bar's width [m], whose half is the bar's error; the widest that obstacles
allow."""


class HandAround:
    """Search for the opening with which a hand fits around the bar of a thing's handle, where the things are
    believed to be."""

    def __init__(self, belief: Belief, context: Context, thing: Thing) -> None:
        self.arm, self.thing = Arm(belief, context), thing

    def around(self, at: Pose, width: float, room: float = 0.0) -> Place | Refused:
        """Find the widest opening at which the hand touches nothing, at a TCP pose around the bar and at the
        stand-off before it.

        Args:
            at: of the TCP, in the base frame.
            width: of what is to be between the fingers [m].
            room: about the hand that must be free there [m].
        """
        refused = refusal(f"the bar is {1000 * width:.0f} mm thick, as wide as the hand opens")
        before = at * Pose((0, 0, -STANDOFF))
        most = self.arm.context.robot.gripper.opening[1]
        for opening in dict.fromkeys(
            round(min(width + s, most), 4) for s in SLACK if width + SLACK[-1] <= most
        ):
            bare = self.arm.scene((), opening, room)
            there = self.arm.at(Leg(at, (self.thing.name,), opening))
            if not isinstance(there, Refused) and not bare.free(there):
                there = refusal(bare.why(there), collision=bare.collision(there))
            off = there if isinstance(there, Refused) else self.arm.at(Leg(before, opening=opening), there)
            if not isinstance(off, Refused):
                return Place(
                    at,
                    before,
                    opening,
                    tuple(at.rotate((0, 0, 1))),
                    thing=self.thing.name,
                    grip=GripFacts(width),
                )
            refused = off
        return refused
