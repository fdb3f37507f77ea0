"""The judge's masses in the model that it hands out.

MuJoCo 2.3.7 computes other volumes of meshes than later versions do, and LIBERO's model states densities: its bowl of 31 g would weigh
46 g in another simulator, its cabinet 2.2 kg instead of 1.0 kg. Nothing of cramlite is imported here.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

KINDS = (("pos", "body_ipos"), ("quat", "body_iquat"), ("mass", "body_mass"), ("diaginertia", "body_inertia"))
"""Attributes of an ``inertial``, and where a compiled model has them."""


def with_masses(text: str, model: Any) -> str:
    """State mass and inertia of each body that has a mass and does not state it.

    Args:
        text: MJCF.
        model: compiled of it, a ``mujoco.MjModel``.
    """
    root = ET.fromstring(text)
    for body in root.iterfind("worldbody//body"):
        row = model.body(body.get("name")).id
        if body.find("inertial") is None and model.body_mass[row] > 0:
            stated = {name: " ".join(f"{v:.9g}" for v in getattr(model, of)[row].flat) for name, of in KINDS}
            body.insert(0, ET.Element("inertial", stated))
    return ET.tostring(root, encoding="unicode")
