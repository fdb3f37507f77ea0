"""Sites of the MJCF text that the benchmark hands out, as high as its check begins over them.

A thing is on a flat site where its origin is higher than ``BELOW`` under the site's upper side (LIBERO's ``SiteObject.under``); the box of
a thicker site begins lower, and a goal would count as reached where LIBERO does not. Nothing of cramlite is imported here.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection

BELOW = 0.005
"""Height under a site's upper side above which an origin counts as on it [m]."""
FLAT = 0.5
"""Largest ratio of a flat site's height to its sides."""


def with_levels(text: str, names: Collection[str]) -> str:
    """Let flat sites that things are to be on begin where LIBERO's check begins; their upper sides stay.

    Args:
        text: MJCF, as MuJoCo saved it.
        names: of the sites.
    """
    root = ET.fromstring(text)
    for site in (s for s in root.iter("site") if s.get("name") in names and s.get("type") == "box"):
        *sides, half = map(float, site.get("size", "").split())
        if (by := half - BELOW / 2) > 0 and half < FLAT * min(sides):
            up, at = _up(site), [float(v) for v in site.get("pos", "0 0 0").split()]
            site.set("pos", " ".join(f"{a + by * u:.9g}" for a, u in zip(at, up, strict=True)))
            site.set("size", " ".join(f"{v:.9g}" for v in (*sides, BELOW / 2)))
    return ET.tostring(root, encoding="unicode")


def _up(site: ET.Element) -> tuple[float, float, float]:
    """The site's z axis in the frame of its body."""
    w, x, y, z = map(float, site.get("quat", "1 0 0 0").split())
    return 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)
