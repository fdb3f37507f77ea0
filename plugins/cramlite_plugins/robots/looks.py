"""Looks of a robot: the visible meshes of its bodies in place of the simpler shapes of its collision checks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from cramlite.model import Pose, Value


class Skin(Value):
    """Visible mesh of a body.

    Args:
        file: of the mesh, OBJ or STL [m].
        at: pose of its frame in the body's.
    """

    file: Path
    at: Pose = Pose()


def covered(mjcf: str, skins: Mapping[str, Skin]) -> str:
    """Return the MJCF text of a robot as cameras see it: bodies with a skin show this alone, but for the pads of fingers.

    Args:
        skins: from the name of a body.
    """
    root = ElementTree.fromstring(mjcf)
    assets = root.find("asset")
    if assets is None:
        assets = ElementTree.SubElement(root, "asset")
    for body in root.iter("body"):
        if (name := body.get("name", "")) in skins:
            for hidden in [g for g in body.findall("geom") if "_pad" not in g.get("name", "")]:
                body.remove(hidden)
            mesh, at = f"{name}_skin", skins[name].at
            ElementTree.SubElement(assets, "mesh", name=mesh, file=str(skins[name].file), inertia="shell")
            geom = ElementTree.SubElement(body, "geom", name=mesh, type="mesh", mesh=mesh, mass="0", contype="0", conaffinity="0")
            geom.set("pos", _text(at.position))
            geom.set("quat", _text(at.quaternion))
    return ElementTree.tostring(root, encoding="unicode")


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{v:.9g}" for v in values)
