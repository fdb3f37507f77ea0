"""Joints of object models that are known as one rigid shape: which of its parts each joint moves, and how."""

from __future__ import annotations

from ...base.value import Value
from ..geometry import Pose
from .joint import Joint


class KindJoint(Value):
    """Joint within an object model, such as that of a cabinet's drawer.

    Args:
        name: of the joint in the model's file.
        joint: with its ``pose`` in the model's frame, and the ``value`` at which the model's shape was read.
        faces: ranges of the triangles that it moves in the model's visual mesh, [first, last + 1].
        geoms: indices of the geoms that it moves.
        lever: greatest distance by which it displaces a point, per metre or radian of its value.
        part: name of that one of the model's parts whose own joint it is; "" if it is that of none.
    """

    name: str
    joint: Joint
    faces: tuple[tuple[int, int], ...] = ()
    geoms: tuple[int, ...] = ()
    lever: float = 1.0
    part: str = ""

    def step(self, value: float) -> Pose:
        """Return the displacement of what the joint moves from where its shape was read, in the model's frame."""
        return self.joint.moved(Pose(), value - self.joint.value)
