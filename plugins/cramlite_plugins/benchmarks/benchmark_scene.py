"""Scene of a benchmark's simulator as a scenario: the world from its file, in its present state, with the robot at its place."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from msgspec import json
from msgspec.structs import replace

from cramlite import Engine, Setting, read_scenario, setting_as_read
from cramlite.model import Pose, Thing, Value, World

from ..backends.stream.messages import Hello

SEARCH = {"proofs": 4, "expansions": 300}
"""Limits of an episode's search for each task sequence, below the defaults (8 and 3000), so that a refusal takes some ten seconds. The
limits count work, so that an episode has the same program on any machine."""
MIDWAY = 200
"""Work of a search while the arm stands in the middle of an episode, for each part of a goal (``Budget.work``): searches that found a
program took at most 94, and the arm goes back the way it came where there is none."""
NOISE = 0.06
"""Noise of poses that are read while a benchmark moves things [m]: smaller differences from the proof are not noticed. A benchmark may move
a thing into another, where it stays: a basket's wall was 15 mm inside a box, at rest; a box that leaned on a bowl fell by 40 mm once they
were apart."""
RESTING = 0.03
"""Noise of poses of a benchmark's things at rest [m]: soft contacts let a lying bottle rest 17 mm deep in a table."""
LATER = "# Resolved in the world of world.json; the scene's file has the poses that things had at first.\n"
"""First line of a scenario whose things are no longer at the poses in the scene's file."""
SEQUENCES = 3
"""Number of task sequences that are tried for each part of a goal; 12 is the default for a whole goal. Each part may have things in its
way, which one sequence finds out."""


class SceneModel(Value, eq=False):
    """Scene of an episode, whose file is read once; the settings of later moments are made from read poses.

    Args:
        setting: world with all things of the file, those included that are absent at first; robot and backend.
        spec: the scenario but for its goal, and for what is absent.
        noise: how far poses may be off [m]; things deeper inside others than the simulator permits are moved by less than that.
    """

    setting: Setting
    spec: Mapping[str, Any]
    noise: float


def scene_model(engine: Engine, folder: Path, scene: Mapping[str, Any], hello: Hello, twins: int, **spec: Any) -> SceneModel:
    """Write a benchmark's scene as an MJCF file, and read its things.

    Args:
        folder: for ``scene.xml``.
        scene: with its MJCF text, ``xml``, and its state, ``qpos``.
        hello: what the robot feels.
        spec: further keys of the scenario; ``robot`` at least.
    """
    folder.mkdir(parents=True, exist_ok=True)
    state = " ".join(f"{v:.17g}" for v in scene["qpos"])
    key = f'<keyframe><key name="state" qpos="{state}"/></keyframe></mujoco>'
    (folder / "scene.xml").write_text(scene["xml"].replace("</mujoco>", key), encoding="utf-8", newline="\n")
    noise = RESTING if hello.poses is None else NOISE
    file = str(folder.resolve() / "scene.xml")
    world = {"file": file, "keyframe": "state", "packages": _assets(scene["xml"]), "noise": f"{noise} m"}
    whole = {"scenario": "episode", "world": world, **spec}
    return SceneModel(engine.setting(read_scenario(whole | {"tasks": []}), twins=twins), whole, noise)


def scene_setting(
    engine: Engine, model: SceneModel, folder: Path, scene: Mapping[str, Any], hello: Hello, goal: Callable[[Setting], list[str]],
    now: World | None = None, come: Sequence[Thing] = (),
) -> tuple[Path, Setting]:  # fmt: skip
    """Return a scenario's file with the setting of a benchmark's present scene: world, robot, belief.

    Args:
        folder: for ``scenario.yaml``, and for ``world.json`` where poses are no longer as in the scene's file.
        scene: what is ``absent``; the ``poses`` of bodies where they are no longer as in the file: position [m], quaternion (w, x, y, z).
        hello: what the robot feels.
        goal: what shall hold in the world of a setting.
        now: the world as it was read last; what its robot holds stays where it was read.
        come: things that are not in the scene's file.
    """
    folder.mkdir(parents=True, exist_ok=True)
    start, absent, poses = model.setting, set(scene.get("absent", ())), scene.get("poses", {})
    things = start.world.put({t.name: Pose.from_row(poses[t.name]) for t in start.world.things if t.name in poses}).things
    present = (*(t for t in things if t.name not in absent), *come)
    read = replace(start.world, things=present, robots=now.robots if now else start.world.robots)
    setting = setting_as_read(start, read, engine.knowledge, model.noise)
    parts = goal(setting)
    world = model.spec["world"] | ({"leave_out": sorted(absent)} if absent else {})
    asked = {"budget": {"sequences": SEQUENCES * len(parts), **SEARCH, **({"work": MIDWAY * len(parts)} if poses else {})}, "goal": parts}
    scenario = folder / "scenario.yaml"
    said = yaml.safe_dump({**model.spec, "world": world} | asked, sort_keys=False)
    scenario.write_text(f"{LATER if poses else ''}{said}", encoding="utf-8", newline="\n")
    mount = replace(read.robots[0], joints=hello.joints, opening=min(hello.opening, start.robot.gripper.opening[1]))
    setting = replace(setting, world=replace(setting.world, robots=(mount,)))
    if poses:
        (folder / "world.json").write_bytes(json.encode(setting.world))
    return scenario, setting




def _assets(xml: str) -> dict[str, str]:
    """Folder of the benchmark's meshes, which its scene names by absolute paths; the folder is trusted like the benchmark's own process."""
    folders = [str(Path(file).parent) for file in re.findall(r'\bfile="([^"]+)"', xml) if Path(file).is_absolute()]
    return {"assets": os.path.commonpath(folders)} if folders else {}
