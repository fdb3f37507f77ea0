"""Turn of a held thing between the fingers: a slanted rim aligns with the finger pads when the thing is lifted."""

from __future__ import annotations

from ...base.value import Value
from ..geometry import Pose, Vector3, quaternion_product, rotvec_quaternion


class Swing(Value):
    """Declared turn of a held thing in the hand: poses of the thing in the TCP frame.

    Args:
        start, end: before and after it.
        pivot: the point of the thing, in its frame, that stays between the pads: it goes straight from where it is to where it will be [m].
    """

    start: Pose
    end: Pose
    pivot: Vector3

    def at(self, share: float) -> Pose:
        """Return the pose of the swinging thing in the TCP frame after a share (0 to 1) of its turn in the hand."""
        turn = rotvec_quaternion([share * v for v in (self.start.inverse() * self.end).rotvec])
        turned = Pose((0.0, 0.0, 0.0), quaternion_product(self.start.quaternion, turn))
        first, last, off = (pose.apply(self.pivot).tolist() for pose in (self.start, self.end, turned))
        x, y, z = (a + share * (b - a) - c for a, b, c in zip(first, last, off, strict=True))
        return Pose((x, y, z), turned.quaternion)

    def part(self, first: float, last: float) -> Swing:
        """Return a section of the thing's turn in the hand, from the share ``first`` to the share ``last`` (0 to 1) of that turn.

        It goes backwards if ``first`` is larger.
        """
        return Swing(self.at(first), self.at(last), self.pivot)
