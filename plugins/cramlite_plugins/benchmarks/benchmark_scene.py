"""Scene of a benchmark's simulator as a scenario: the world from its file, in its present state, with the robot at its place."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml
from msgspec.structs import replace

from cramlite import Engine, Setting, read_scenario
from cramlite.model import World

from ..backends.stream.messages import Hello

SEARCH = {"proofs": 4, "expansions": 300}
"""Work that an episode's search may take over one task sequence: less than usual (8 and 3000), so that a refusal takes some ten seconds;
all of it is counted, so that an episode has the same program on any machine."""
NOISE = "60 mm"
"""Noise of poses that are read while a benchmark moves things: smaller differences from the proof are not noticed. It may move a thing into
another, where it stays: a basket's wall was 15 mm inside a box, at rest; a box that leaned on a bowl fell by 40 mm once they were apart."""
SEQUENCES = 3
"""Task sequences for each part of its goal, usually 12 in all: each part may have things in its way, which a sequence finds out."""


def scene_setting(
    engine: Engine, folder: Path, scene: Mapping[str, Any], hello: Hello, goal: Callable[[Setting], list[str]], twins: int,
    now: World | None = None, **spec: Any,
) -> tuple[Path, Setting]:  # fmt: skip
    """Write a benchmark's scene as MJCF and scenario files, and return the scenario's file with its setting
    (world, robot, belief).

    Args:
        folder: for ``scene.xml`` and ``scenario.yaml``.
        scene: with its MJCF text, ``xml``, and its state, ``qpos``.
        hello: what the robot feels.
        goal: what shall hold in the world of a setting.
        now: the world as it was read last; what its robot holds stays where it was read.
        spec: further keys of the scenario; ``robot`` at least.

    Returns:
        The scenario's file, and where it is to be resolved.
    """
    folder.mkdir(parents=True, exist_ok=True)
    state = " ".join(f"{v:.17g}" for v in scene["qpos"])
    key = f'<keyframe><key name="state" qpos="{state}"/></keyframe></mujoco>'
    (folder / "scene.xml").write_text(scene["xml"].replace("</mujoco>", key), encoding="utf-8", newline="\n")
    absent = {"leave_out": list(scene["absent"])} if scene.get("absent") else {}
    world = {"file": str(folder.resolve() / "scene.xml"), "keyframe": "state", "packages": _assets(scene["xml"])} | absent
    world |= {"noise": NOISE} if hello.poses is not None else {}
    whole = {"scenario": "episode", "world": world, **spec}
    setting = engine.setting(read_scenario(whole | {"tasks": []}), twins=twins, now=now)
    parts = goal(setting)
    asked = {"budget": {"sequences": SEQUENCES * len(parts), **SEARCH}, "goal": parts}
    scenario = folder / "scenario.yaml"
    scenario.write_text(yaml.safe_dump(whole | asked, sort_keys=False), encoding="utf-8", newline="\n")
    mount = replace(setting.world.robots[0], joints=hello.joints, opening=min(hello.opening, setting.robot.gripper.opening[1]))
    return scenario, replace(setting, world=replace(setting.world, robots=(mount,)))


def _assets(xml: str) -> dict[str, str]:
    """Folder of the benchmark's meshes, which its scene names by absolute paths; it is trusted, as the benchmark's
    own process is."""
    folders = [str(Path(file).parent) for file in re.findall(r'\bfile="([^"]+)"', xml) if Path(file).is_absolute()]
    return {"assets": os.path.commonpath(folders)} if folders else {}
