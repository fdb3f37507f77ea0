"""Masses of the bodies in the MJCF text that the benchmark hands out.

The text that MuJoCo saves leaves out which groups of geoms the masses were taken from (``inertiagrouprange``), so that shapes which are
only drawn weigh too where it is read again, and LIBERO states densities: a bowl of 5.6 g has 31 g then. MuJoCo 2.3.7 also computes
other volumes of meshes than later versions do, which make it 46 g. Nothing of cramlite is imported here.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

KINDS = (("pos", "body_ipos"), ("quat", "body_iquat"), ("mass", "body_mass"), ("diaginertia", "body_inertia"))
"""Attributes of an ``inertial`` element, with the fields of a compiled model that hold them."""


def with_masses(text: str, model: Any) -> str:
    """State mass and inertia of each body that does not state them, as the compiled model has them.

    Args:
        text: MJCF, as MuJoCo saved it.
        model: compiled of it, a ``mujoco.MjModel``; its bodies are in the order of the text, the world first.
    """
    root = ET.fromstring(text)
    bodies = (body for top in root.iterfind("worldbody") for body in top.iter("body"))
    for row, body in enumerate(bodies, 1):
        if body.find("inertial") is None:
            stated = {name: " ".join(f"{v:.17g}" for v in getattr(model, of)[row].flat) for name, of in KINDS}
            body.insert(0, ET.Element("inertial", stated))
    return ET.tostring(root, encoding="unicode")
