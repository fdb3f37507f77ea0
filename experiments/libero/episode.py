"""One episode of LIBERO as a scenario: what the judge says of its world, in the words of cramlite."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from cramlite import Engine, Setting, UserError, read_scenario
from cramlite.model import replace
from cramlite_plugins.backends.stream.messages import Hello

from .goals import goal_sentences

SEARCH = {"sequences": 3, "proofs": 4}
"""Work that an episode's search may take: less than usual (12 and 8), so that a refusal takes a minute or two."""


def prepare(engine: Engine, scene: dict[str, Any], hello: Hello, folder: Path, twins: int) -> tuple[tuple[str, ...], Setting]:
    """Write scene and scenario of an episode, and build its setting: the goal, and where it is to be achieved."""
    folder.mkdir(parents=True, exist_ok=True)
    state = " ".join(f"{v:.17g}" for v in scene["qpos"])
    key = f'<keyframe><key name="state" qpos="{state}"/></keyframe></mujoco>'
    (folder / "scene.xml").write_text(scene["xml"].replace("</mujoco>", key))
    x, y, z, *turn = scene["base"]
    if abs(turn[0]) < 0.999999:
        raise UserError(f"The robot's base is turned by the quaternion {turn}; all of LIBERO's stand straight.")
    spec: dict[str, Any] = {
        "scenario": "episode", "robot": {"type": "libero_panda", "at": {"position": [x, y, z]}},
        "world": {"file": str(folder.resolve() / "scene.xml"), "keyframe": "state"}, "budget": SEARCH,
        "limits": {"advisory": ["bystanders"]},  # LIBERO does not ask about them
    }  # fmt: skip
    setting = engine.setting(read_scenario(spec | {"tasks": []}), twins=twins)
    goal = goal_sentences(scene, setting.world.things)
    (folder / "scenario.yaml").write_text(yaml.safe_dump(spec | {"goal": goal}, sort_keys=False))
    mount = replace(setting.world.robots[0], joints=hello.joints, opening=min(hello.opening, setting.robot.gripper.opening[1]))
    return tuple(goal), replace(setting, world=replace(setting.world, robots=(mount,)))
