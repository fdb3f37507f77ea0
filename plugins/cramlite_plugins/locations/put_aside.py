"""What is put aside before something is shut: beside where it stood on a surface, as the way there and on is short then.

Before something is opened it goes farther: a bottle that was put 150 mm aside was in the way of a drawer again.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import shapely

from ..kinematics.kinematics import forward
from ..shapes.bounds import support
from .free_area import Offset, around
from .later import closes_next
from .place_filters import Wanted

ON = 0.005  # from a surface to what stands on it at most [m]: more than it is known by, less than boards are thick
AWAY = 0.1  # between it there and where it stood [m]: half a hand, which has room where it stood then


def beside_where_it_stood(wanted: Wanted, free: Any, radius: float) -> Iterator[Offset]:
    """Generate positions in a free area of a surface beside where the held thing stood on it, nearest to the robot first; none unless the
    next task that is about anything else shuts that.

    Args:
        radius: of the disc in the outline of the held thing [m].
    """
    stood = _stood(wanted)
    if stood is not None and closes_next(wanted.thing.name, wanted.context):
        x, y, _ = wanted.target.pose.inverse().apply((0.0, 0.0, 0.0)).tolist()
        yield from around(free, stood, 2 * radius + AWAY, (x, y))


def _stood(wanted: Wanted) -> Offset | None:
    """Where on a surface the held thing stood when it was taken; None where that was elsewhere, or the robot drove since."""
    held = wanted.belief.held
    if held is None or not held.joints or wanted.belief.at is not None:
        return None
    there, level = forward(wanted.context.robot, held.joints) * held.tcp_to_thing, wanted.target.pose.position[2]
    x, y, _ = wanted.target.pose.inverse().apply(there.position).tolist()
    low = -support(wanted.thing, there, (0.0, 0.0, -1.0))
    return (x, y) if abs(low - level) < ON and wanted.target.area.covers(shapely.Point(x, y)) else None
