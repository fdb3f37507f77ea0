"""Skeleton of a plugin for a robot that is read from a file such as a URDF; the file is copied into the package."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import UserError
from ..base.value import Value, replace
from ..base.yaml_file import load_yaml
from ..model.robot_file import HandFile, RobotFile
from .skeleton import fill

if TYPE_CHECKING:
    from ..model.imported_robot import ImportedRobot

PARTS = (".xml", ".mjcf", ".urdf", ".stl", ".obj", ".msh", ".png", ".jpg", ".mtl", ".dae")
"""File name extensions of a robot model and of the files that it consists of."""
LARGEST = 200 * 2**20
"""Largest size of a model with its files [bytes]."""


class WrittenRobot(Value):
    """Package of a robot that was read from a file.

    Args:
        files: the files, the folder first.
        read: what was found in the robot's file.
    """

    files: tuple[Path, ...]
    read: ImportedRobot


def write_robot(name: str, arm: Path, keys: Path | None, gripper: Path | None, out: Path | None = None) -> WrittenRobot:
    """Write a plugin package for a robot that a file describes, with copies of the arm's and the gripper's
    files.

    Args:
        name: of the plugin and the robot's type.
        arm, gripper: MJCF or URDF; None for the gripper that the keys say.
        keys: YAML file with keys of a scenario's ``robot``, such as "payload: 5 kg".
        out: as for ``write_skeleton``.

    Raises:
        UserError: the file is no arm, or lacks what a key has to say; the name or folder cannot be used. Nothing is left then.
    """
    from ..plugin.catalogue import Knowledge
    from ..plugin.registry import Registry

    file = _described(arm, keys, gripper)
    Knowledge(Registry()).read_robot(file)  # what is wrong with the file is said of it, not of its copy
    inside = f"cramlite_{name}"
    stated, hand = file.stated, file.stated.gripper
    local = replace(file, path=f"{inside}/model/{arm.name}")
    if isinstance(hand, HandFile) and hand.path:
        local = replace(local, stated=replace(stated, gripper=replace(hand, path=f"{inside}/gripper/{Path(hand.path).name}")))
    folder, *files = fill("robot_file", "robot", name, out, {"model": arm.name, "stated": _source(local, inside)})
    try:
        files += _copied(arm, folder / inside / "model")
        if isinstance(hand, HandFile) and hand.path:
            files += _copied(Path(hand.path), folder / inside / "gripper")
        return WrittenRobot((folder, *files), Knowledge(Registry()).read_robot(_in(local, folder)))
    except UserError:
        shutil.rmtree(folder)
        raise


def robot_text(written: WrittenRobot) -> str:
    """Return text on the data that were found in a robot's files, and on those that are missing."""
    found = [f"  found: {line}" for line in written.read.found]
    return "\n".join([*found, *(f"  to check: {line}" for line in written.read.notes)])


def _described(arm: Path, keys: Path | None, gripper: Path | None) -> RobotFile:
    """Read an arm's file and a gripper's file; the YAML file ``keys`` adds what a scenario may state about
    its robot."""
    from ..scenario.robots import file_of
    from ..scenario.scenario import scenario_from

    stated = {} if keys is None else load_yaml(keys)
    if not isinstance(stated, dict):
        raise UserError(f"{keys}:1: this file is a mapping with keys of a scenario's robot, such as 'payload: 5 kg'.")
    robot: dict[str, Any] = {**stated, "file": str(arm.absolute())}
    if gripper is not None:
        own = stated.get("gripper", {})
        robot["gripper"] = {**(own if isinstance(own, dict) else {}), "file": str(gripper.absolute())}
    scenario = {"scenario": "robot", "tasks": [], "things": [], "robot": robot}
    described = file_of(scenario_from(keys or arm, scenario))
    assert described is not None  # it has a file
    return described


def _copied(model: Path, folder: Path) -> list[Path]:
    """Copy a model with its licence and the files that it needs, such as meshes."""
    own = _needed(model)
    if sum(p.stat().st_size for p in own) > LARGEST:
        raise UserError(
            f"'{model}' needs more than {LARGEST >> 20} MB of files; make its meshes smaller, or leave out those that only look good."
        )
    files = [folder / p.relative_to(model.parent) for p in own]
    for source, target in zip(own, files, strict=True):
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
    return files


def _needed(model: Path) -> list[Path]:
    """Return a model's file with all files below its folder that it names, directly or through these files, and licences."""
    near = [p for p in sorted(model.parent.rglob("*")) if p.is_file() and p != model]
    found = [model, *(p for p in near if p.stem == "LICENSE" and p.parent == model.parent)]
    left = [p for p in near if p.suffix.lower() in PARTS]
    for file in found:  # grows
        text = file.read_bytes()
        named = [p for p in left if p.name.encode() in text]
        found += named
        left = [p for p in left if p not in named]
    return found


def _in(local: RobotFile, folder: Path) -> RobotFile:
    """Put a folder before the paths of the arm's and the gripper's file in a robot's description."""
    hand = local.stated.gripper
    moved = replace(local, path=str(folder / local.path))
    if not isinstance(hand, HandFile) or not hand.path:
        return moved
    return replace(moved, stated=replace(local.stated, gripper=replace(hand, path=str(folder / hand.path))))


def _source(local: RobotFile, inside: str) -> str:
    """Return Python code of what is stated about an arm besides its file: a line for each field that differs from its default."""
    return "\n".join(f"        {name}={_code(value, inside)}," for name, value in _stated(local.stated))


def _stated(value: Value) -> Iterator[tuple[str, Any]]:
    default = type(value)()
    yield from ((n, getattr(value, n)) for n in value.__struct_fields__ if getattr(value, n) != getattr(default, n))


def _code(value: Any, inside: str) -> str:
    if isinstance(value, str) and value.startswith(f"{inside}/"):
        return f'str(HERE / "{value.removeprefix(f"{inside}/")}")'
    if isinstance(value, Value):
        said = ", ".join(f"{n}={_code(v, inside)}" for n, v in _stated(value))
        return f"{type(value).__name__}({said})"
    return repr(value)
