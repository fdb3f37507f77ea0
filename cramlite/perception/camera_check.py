"""Check whether a camera is where it is believed to be, from the fixtures and the robot in its picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..model.geometry import Pose
from .active_perception import ask
from .query import ObjectQuery

if TYPE_CHECKING:
    from ..model.view import CameraOffset, Depth, View
    from ..model.world.thing import Thing
    from ..plugin.catalogue import Knowledge

OFFSET = "camera_offset"


def camera_offset(
    view: View, fixtures: tuple[Thing, ...], knowledge: Knowledge, robot: Depth | None = None
) -> tuple[CameraOffset | None, str]:
    """Measure how wrong a camera's believed pose is, on fixtures and the robot; return the error and how it was found, or
    None and why it is unknown.

    Args:
        fixtures: things whose poses are known.
        robot: the depth at which the camera would see the robot itself [m].
    """
    if not any(OFFSET in e.outputs for e in knowledge.experts):
        return None, "no plugin tells it"
    found = ask(ObjectQuery(wanted=(OFFSET,)), view, fixtures, knowledge, robot=robot)
    said = found.scene.get(OFFSET)
    if said is None:
        return None, "; ".join(f for r in found.runs for f in r.failures) or "no fixture is in the picture"
    offset: CameraOffset = said.value
    return offset, said.judged.reason


def camera_warning(view: View, fixtures: tuple[Thing, ...], knowledge: Knowledge, robot: Depth | None = None) -> str:
    """Return a warning if a camera's pose error is larger than the one for which programs are proven; else
    ""."""
    if not fixtures:
        return ""
    offset, reason = camera_offset(view, fixtures, knowledge, robot)
    if offset is None or not offset.off:
        return ""
    return f"{reason}; 'cramlite calibrate SCENARIO --view PICTURE' writes the corrected pose, if the fixtures are where the map has them"


def moved_text(moved: Pose) -> str:
    """Format a motion of a camera in its own frame, such as "3 mm to the right, 1 mm down, ..."."""
    (right, down, forward), turn = (1000 * v for v in moved.position), math.degrees(moved.distance(Pose())[1])
    return f"{right:+.1f} mm to the right, {down:+.1f} mm down, {forward:+.1f} mm forward, turned by {turn:.2f} deg"
