"""Paths of MJCF and URDF files that a scenario names; an error about a missing file lists those in its folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError, nearest

if TYPE_CHECKING:
    from .scenario import Scenario

ENDINGS = (".xml", ".urdf", ".mjcf")


def existing_file(scenario: Scenario, name: str, what: str, *keys: str) -> Path:
    """Return the path of a model file that a scenario names, checked to exist.

    Args:
        what: "robot" or "scene".
        keys: where the scenario names it.

    Raises:
        UserError: there is none; with file and line, and the names of those beside it.
    """
    path = scenario.resolve_path(name)
    if path.is_file():
        return path
    said = f"{scenario.where(*keys)}: there is no {what} file '{path}'"
    if path.is_dir():
        raise UserError(f"{said}, but a folder; name the MJCF or URDF file in it.")
    folder = path.parent
    beside = [p.name for p in folder.iterdir() if p.suffix in ENDINGS and p.is_file()] if folder.is_dir() else []
    raise UserError(f"{said}; {nearest(path.name, beside)}." if beside else f"{said}, and no other MJCF or URDF file in that folder.")
