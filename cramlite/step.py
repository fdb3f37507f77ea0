"""What all steps of a typed program have in common."""

from __future__ import annotations

from dataclasses import dataclass, field

Joints = tuple[float, ...]


@dataclass(frozen=True)
class Step:
    """Common to all steps.

    Args:
        origin: the designator that this step grounds, e.g. "3.Grasping/approach"; a code line leads back to it.
        comment: one clause for the reader of the code.
        relative: a thing whose pose is late: targets and directions move along with it; "" for none.
    """

    origin: str = field(default="", kw_only=True)
    comment: str = field(default="", kw_only=True)
    relative: str = field(default="", kw_only=True)

