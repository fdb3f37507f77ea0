"""Robots whose fingers open further, for the question whether a wider gripper would do."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from xml.etree import ElementTree

import numpy as np
from msgspec.structs import replace

from .robot import Robot


def with_wider_gripper(robot: Robot, by: float) -> Robot | None:
    """Return a robot whose fingers open further by a distance [m]; None for one whose fingers are more than two slides."""
    low, high = robot.gripper.opening
    text = _widened(robot.mjcf(), by, (high + by - low) / (high - low)) if robot.gripper.linkage is None else None
    if text is None:
        return None
    return replace(robot, gripper=replace(robot.gripper, opening=(low, high + by)), mjcf=_said(text))


def _said(text: str) -> Callable[[], str]:
    return lambda: text


def _widened(text: str, by: float, share: float) -> str | None:
    """Return MJCF text with both fingers farther out, and a longer range of their slides; None if there are no two.

    Args:
        share: of the new stroke in the old one, by which the command of the actuator "gripper" is to pull farther.
    """
    root = ElementTree.fromstring(text)
    actuator = root.find(".//actuator/general[@name='gripper']")
    if actuator is None:
        return None
    slides = {j.get("joint") for j in root.findall(f".//tendon/fixed[@name='{actuator.get('tendon')}']/joint")}
    fingers = [(b, j) for b in root.iter("body") for j in b.findall("joint[@type='slide']") if j.get("name") in slides]
    if len(fingers) != 2 or any({"quat", "euler", "axisangle", "xyaxes", "zaxis"} & set(b.keys()) for b, _ in fingers):
        return None
    for body, joint in fingers:
        place, axis = (np.array(list(map(float, v.split()))) for v in (body.get("pos", "0 0 0"), joint.get("axis", "0 0 1")))
        body.set("pos", _text(place - by / 2 * axis))
        low, high = map(float, joint.get("range", "0 0").split())
        joint.set("range", _text((low, high + by / 2)))
    actuator.set("gainprm", _text(share * float(v) for v in actuator.get("gainprm", "1").split()))
    return ElementTree.tostring(root, encoding="unicode")


def _text(values: Iterable[float]) -> str:
    return " ".join(f"{v:.9g}" for v in values)
