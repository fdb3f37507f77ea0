"""Order of the checks of placements: pure functions, each returns a reason with numbers, or nothing.

Those of the shapes alone are asked before the arm is; all work in the robot's base frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from msgspec.structs import replace

from cramlite.plugin import Refused, checkpoint

from ....motion_planning.space import refusal
from ..query import Placement, Query
from ..visibility import visible
from .hand import collision_free, hand_off, let_in, pushed_way, reachable, room, room_to_open
from .rest import dropped, lying_there, rests_there
from .shapes import beside, clear, falls, falls_in, in_region, inside, near, over_region, supported

Check = Callable[[Placement, Query], "str | Refused"]
"""Check of a placement: returns the reason for an objection, with the obstacles if the check looks for them;
"" without an objection."""


def first_objection(placement: Placement, query: Query, checks: Mapping[str, Check]) -> Refused | None:
    """Return the refusal of a placement by the first check that objects, with the number of checks passed
    before; None if all pass.

    What stands on the target is blamed whenever nothing else is: it takes away positions that are not even
    looked at.
    """
    checkpoint()
    for passed, (name, objects) in enumerate(checks.items()):
        no = objects(placement, query)
        if no:
            why = no if isinstance(no, Refused) else refusal(no, blocking=query.standing_there())
            return replace(why, reason=f"not {name}: {why.reason}", check=name).of(placement.name, passed)
    return None


SHAPES: Mapping[str, Mapping[str, Check]] = {
    "on": {
        "supported": supported,
        "clear": clear,
        "near": near,
        "beside": beside,
        "in its region": in_region,
        "let in": let_in,
    },
    "in": {"inside": inside, "falls": falls, "near": near, "beside": beside, "in its region": in_region},
    "within": {"near": near, "beside": beside, "in its region": in_region, "let in": let_in},
    "dropped": {"near": near, "beside": beside, "let in": let_in},
    "at rest": {"near": near, "beside": beside, "over its region": over_region},
    "toppled": {"lying there": lying_there, "near": near, "beside": beside},
    "before": {"near": near, "beside": beside, "let in": pushed_way},
}
"""Checks of the payload and its surroundings without hand and arm, by kind of stable pose. For "at rest", on
a support that is not level, simulation has already shown what supports the payload."""
REACHED: Mapping[str, Check] = {
    "at rest": dropped, "free to fall": falls_in, "collision-free": room, "reachable": reachable,
    "visible": visible, "collision-free with the arm": collision_free, "free to open": room_to_open,
    "let down by the thing alone": hand_off, "at rest there": rests_there,
}  # fmt: skip
"""Checks of a placement with the hand, the arm and the camera, in their order."""
