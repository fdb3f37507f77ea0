"""The arms that come with cramlite."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Robot
from cramlite.plugin import hookimpl


@hookimpl
def robots() -> Iterable[Robot]:
    """Declare the arms."""
    from .fr3 import FR3, FR3_2F85
    from .irb1200 import IRB1200
    from .universal_robots import robot
    from .ur5 import UR5
    from .ur5e import UR5E
    from .ur5e_mobile import UR5E_MOBILE
    from .ur_arms import ARMS

    return [FR3, FR3_2F85, IRB1200, UR5, UR5E, UR5E_MOBILE, *map(robot, ARMS)]
