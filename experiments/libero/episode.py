"""Episode of LIBERO as a scenario of cramlite, written from the benchmark's description of its world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cramlite import Engine, Setting, UserError
from cramlite.model import World
from cramlite_plugins.backends.stream.messages import Hello
from cramlite_plugins.benchmarks.benchmark_scene import SceneModel, scene_model, scene_setting

from .goals import goal_sentences

MOVED = "1 mm"
"""Distance that an obstacle may be moved where SafeLIBERO forbids it."""
ANYTHING = {"bystander_motion": "1 m", "bystander_tilt": "180 deg"}
"""Tolerances for the bystanders, whose motion LIBERO does not judge."""


def read_model(engine: Engine, scene: dict[str, Any], hello: Hello, folder: Path, twins: int) -> SceneModel:
    """Write the scene of an episode as a file, and read its things."""
    x, y, z, *turn = scene["base"]
    if abs(turn[0]) < 0.999999:
        raise UserError(f"The robot's base is turned by the quaternion {turn}; all of LIBERO's stand straight.")
    kept = dict.fromkeys(scene.get("keep", ()), MOVED)
    limits: dict[str, Any] = {"keep": kept, **ANYTHING} if kept else {"advisory": ["bystanders"], "may_push": True}
    return scene_model(engine, folder, scene, hello, twins, robot={"type": "libero_panda", "at": {"position": [x, y, z]}}, limits=limits)


def prepare(
    engine: Engine, model: SceneModel, scene: dict[str, Any], hello: Hello, folder: Path, now: World | None = None
) -> tuple[Path, Setting]:
    """Write the scenario of an episode's present scene; return its file, and the ``Setting`` of the search: world, robot and backend."""
    return scene_setting(engine, model, folder, scene, hello, lambda setting: goal_sentences(scene, setting.world.things), now)
