"""``cramlite import``: a scene file such as an MJCF becomes the beginning of a scenario."""

from __future__ import annotations

import argparse
import math
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from .arguments import Add, plugin_choice
from .texts import counted

if TYPE_CHECKING:
    from ..model.world.imported_scene import ImportedScene
    from ..scenario.imported_world import Proposal


def import_scene(arguments: argparse.Namespace) -> int:
    """Read a scene file, print how it was understood, and write a scenario around it.

    Raises:
        UserError: the file cannot be used; or the scenario exists already, or cannot be written.
    """
    from ..plugin.catalogue import Knowledge, pick
    from ..scenario.imported_world import propose, read_scene_file

    knowledge = Knowledge(plugin_choice(arguments).registry())
    out: Path | None = arguments.out
    if arguments.goal and out is None:
        raise UserError("--goal is written into a scenario: name its file with --out.")
    if out is not None and out.exists() and not arguments.force:
        raise UserError(f"'{out}' exists already; --force writes over it.")
    robot = arguments.robot or next(iter(knowledge.robots))
    pick("robot", knowledge.robots, robot, "--robot")
    packages = dict(_package(p) for p in arguments.package)
    scene = read_scene_file(arguments.scene, packages, arguments.keyframe, knowledge)
    classes = {t.name: propose(t, scene, {}, knowledge.taxonomy) for t in scene.things}
    print("\n".join(_report(arguments.scene, scene, classes)))
    if out is not None:
        jointed = next((t.name for t in scene.things if t.joint), "")
        _write(out, _scenario(arguments, packages, robot + _stand(scene), classes, jointed))
        todo = "Correct the classes" if arguments.goal else "Put tasks into it, correct the classes"
        print(f"Written: {out}. {todo}, then 'cramlite check {out}'.")
    return 0


def _write(out: Path, text: str) -> None:
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"'{out}' cannot be written: {error.strerror}; choose another file with --out.") from error


def _package(said: str) -> tuple[str, Path]:
    name, equals, folder = said.partition("=")
    if not equals or not Path(folder).is_dir():
        raise UserError(f"--package {said}: write NAME=FOLDER, with a folder that exists.")
    return name, Path(folder)


def _report(path: Path, scene: ImportedScene, classes: dict[str, Proposal]) -> list[str]:
    """Format the class of each imported thing with the reason, and the parts of the scene file that were not
    taken over."""
    lines = [f"{path}: {counted(len(scene.things), 'thing')}"]
    for thing in scene.things:
        how = f"{thing.joint.kind} joint" if thing.joint else f"{thing.mass:.3g} kg" if thing.mass is not None else "fixed"
        found = classes[thing.name]
        lines.append(f"  {thing.name}  {found.type}, because {found.reason}")
        lines.append(f"    {how}, {counted(len(thing.geoms), 'shape')}, {scene.found[thing.name]}")
        lines += [f"    {note}" for note in thing.notes]
    lines += [f"  physics options kept: {', '.join(f'{k}={v}' for k, v in scene.physics.items())}"] if scene.physics else []
    return [*lines, *(f"  not taken over: {note}" for note in scene.notes)]


def _scenario(
    arguments: argparse.Namespace, packages: dict[str, Path], robot: str, classes: dict[str, Proposal], jointed: str
) -> str:
    """Write a scenario for an imported scene, with comments on what a person still has to correct."""
    folder = arguments.out.resolve().parent
    name = re.sub(r"\W", "_", arguments.out.stem, flags=re.ASCII)
    name = name if name[:1].isalpha() else f"scene_{name}"

    def relative(path: Path) -> str:
        return Path(os.path.relpath(path.resolve(), folder)).as_posix()

    lines = [f"scenario: {name}", "world:", f"  file: {_quoted(relative(arguments.scene))}"]
    lines += [f"  keyframe: {_quoted(arguments.keyframe)}"] if arguments.keyframe else []
    lines += ["  packages:", *(f"    {n}: {_quoted(relative(p))}" for n, p in packages.items())] if packages else []
    lines += ["  # Proposed from names, else from how things move; the scenario has the last word.", "  types:"]
    lines += [f"    {n}: {c.type}  # {c.reason}" for n, c in classes.items()]
    correction = f"  # If a joint's closed end or range was read wrongly, correct it: joints: {{{jointed}: {{closed: upper}}}}"
    lines += [correction] if jointed else []
    lines += [f"robot: {{type: {robot}}}", *_start(arguments.goal)]
    return "\n".join(lines) + "\n"


def _start(goal: list[str]) -> list[str]:
    """Return the YAML lines that state the goal of a new scenario or, without a goal, an empty list of
    tasks to fill in."""
    if goal:
        return ["goal:", *(f"  - {_quoted(sentence)}" for sentence in goal)]
    return ["# What is to be done, such as {task: TASK, Patient: THING}; see 'cramlite tasks'.", "tasks: []"]


def _stand(scene: ImportedScene) -> str:
    """Format the robot's place in the new scenario: that of the scene file's first robot if it stands
    upright, else ""."""
    pose = next(iter(scene.stands.values()), None)
    if pose is None or pose.rotate((0.0, 0.0, 1.0))[2] < 0.999:
        return ""
    x, y, z = (round(v, 4) for v in pose.position)
    ahead = pose.rotate((1.0, 0.0, 0.0))
    return f", at: {{position: [{x:g}, {y:g}, {z:g}], yaw: {math.degrees(math.atan2(ahead[1], ahead[0])):g} deg}}"


def _quoted(text: str) -> str:
    import json

    return json.dumps(text, ensure_ascii=False)


def add_commands(add: Add) -> None:
    """Add the command ``import``, with its arguments, to the command line."""
    command = add("import", import_scene)
    command.add_argument("scene", type=Path, help="an MJCF or URDF file")
    command.add_argument("--out", type=Path, metavar="FILE", help="write a scenario there; else only say what is understood")
    sentence = "what is to be achieved, such as 'tin on tray'; needs --out; may be given several times"
    command.add_argument("--goal", action="append", default=[], metavar="SENTENCE", help=sentence)
    command.add_argument("--force", action="store_true", help="write over a scenario that exists")
    command.add_argument("--robot", metavar="TYPE", help="who acts in the scenario; the first robot there is, if not said")
    command.add_argument("--keyframe", default="", metavar="NAME", help="the state that the scene starts in")
    command.add_argument(
        "--package", action="append", default=[], metavar="NAME=FOLDER",
        help="where a URDF's package is; may be given several times",
    )
