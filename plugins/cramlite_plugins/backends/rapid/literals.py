"""RAPID literals: mm, degrees, quaternions, zones and names; fixed digits, so that the same program always
gives the same text."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from cramlite.model import Pose

ZONES = {0.3: "z0", 1: "z1", 5: "z5", 10: "z10", 15: "z15", 20: "z20", 30: "z30", 40: "z40", 50: "z50", 60: "z60", 80: "z80",
         100: "z100", 150: "z150", 200: "z200"}  # fmt: skip
"""Predefined zones by the distance of the TCP from the target at which the corner begins [mm]: ABB, zonedata."""
NONE = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"


def zone(radius: float) -> str:
    """Return the largest predefined zone (ABB's corner rounding) that is not larger than a blend radius [m];
    ``fine`` if all are larger."""
    fitting = [name for size, name in ZONES.items() if size <= 1000 * radius]
    return fitting[-1] if fitting else "fine"


def jointtarget(q: Iterable[float], zero: tuple[float, ...]) -> str:
    """Format joint positions [rad] as a jointtarget; ``zero`` are the angles at which ABB's axes are zero [rad]."""
    return f"[[{', '.join(number(math.degrees(a - z)) for a, z in zip(q, zero, strict=True))}], {NONE}]"


def robtarget(pose: Pose, joints: tuple[float, ...], zero: tuple[float, ...]) -> str:
    """Format a tcp pose, with the configuration of its joint positions [rad], as a robtarget."""
    return f"[{mm(pose.position)}, {quat(pose)}, {configuration(joints, zero)}, {NONE}]"


def configuration(joints: tuple[float, ...], zero: tuple[float, ...]) -> str:
    """Format RAPID's confdata: the quadrants of axes 1, 4 and 6, and 0 as cfx.

    ``ConfL \\Off`` lets linear motions keep the nearest configuration.
    """
    if not joints:
        return "[0, 0, 0, 0]"
    quadrants = [math.floor(math.degrees(joints[i] - zero[i]) / 90 + 1e-9) for i in (0, 3, 5)]
    return f"[{', '.join(map(str, quadrants))}, 0]"


def way_of(frame: Pose, distance: float) -> str:
    """Format the displacement by a distance [m] along a frame's z axis, in mm."""
    return mm(tuple(distance * float(v) for v in frame.rotate((0.0, 0.0, 1.0))))


def mm(values: tuple[float, ...]) -> str:
    """Format lengths [m] as a list in mm."""
    return "[" + ", ".join(number(1000 * v) for v in values) + "]"


def quat(pose: Pose) -> str:
    """Format a pose's orientation as a quaternion list."""
    return "[" + ", ".join(f"{v + 0.0:.6f}" if abs(v) > 5e-7 else "0" for v in pose.quaternion) + "]"


def number(value: float) -> str:
    """Format a number with at most four digits after the point, never "-0"."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def plain(text: str) -> str:
    """Reduce a text to one line of plain letters, for comments and strings."""
    return " ".join(text.split()).replace('"', "'").replace("\\", "/").encode("ascii", "replace").decode()


def identifier(text: str) -> str:
    """Convert a text to a RAPID name of letters, digits and underscores: "3.Grasping/approach" becomes
    "Grasping_3_approach"."""
    moved = re.sub(r"^(\d+)\.([^/]*)", r"\2_\1", text or "pose")
    name = re.sub(r"[^A-Za-z0-9]+", "_", moved).strip("_")
    return name if name[:1].isalpha() else f"t_{name}"
