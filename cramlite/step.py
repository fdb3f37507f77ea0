"""What all steps of a typed program have in common."""

from __future__ import annotations

from .value import Value

Joints = tuple[float, ...]


class Step(Value, kw_only=True):
    """Common to all steps.

    Args:
        origin: the designator that this step grounds, e.g. "3.Grasping/approach"; a code line leads back to it.
        comment: one clause for the reader of the code.
        relative: a thing whose pose is late: targets and directions move along with it; "" for none.
    """

    origin: str = ""
    comment: str = ""
    relative: str = ""
