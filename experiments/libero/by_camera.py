"""LIBERO as a benchmark that tells a robot only what a cell could: camera pictures and the task's sentence, no
model, state or goal formula."""

from __future__ import annotations

import base64
from functools import lru_cache
from pathlib import Path
from typing import Any

from msgspec import json

from cramlite import Engine, Setting, UserError
from cramlite.model import Pose, RobotMount, Thing, World
from cramlite.planning.spoken_goals import understand
from cramlite_plugins.benchmarks.benchmark_process import PATIENCE
from cramlite_plugins.benchmarks.benchmark_scene import scene_model, scene_setting

from .connection import Libero
from .panda import library
from .placed_kinds import Placed, files_of, scene_of
from .sight import located, pictured, seen

ALLOWED = ("reset", "look", "hello", "step", "check", "end")
"""Requests that this connection sends; a robot cell could answer all but ``reset`` and ``check``, which start and judge an episode."""
ASKED = "asked.json"
"""File of an episode with all requests to the benchmark, and the names of the fields of its answers."""


class LiberoByCamera(Libero):
    """LIBERO, asked only for pictures with depth, joint values and the task's sentence."""

    def __init__(self, environment: Path | None = None, patience: float = PATIENCE) -> None:
        super().__init__(environment, patience)
        self.sentence, self.seed = "", 0
        self.asked: list[dict[str, Any]] = []

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode, and remember the task's sentence."""
        self.asked, self.seed = [], task * 1000 + state
        return super().reset(suite, task, state)

    def ask(self, ask: dict[str, Any], patience: float) -> dict[str, Any]:
        """Send a request that a robot cell could answer, and return the answer; the request and the answer's
        keys are recorded.

        Raises:
            UserError: it asks for more, or as that of any benchmark.
        """
        if ask["ask"] not in ALLOWED:
            raise UserError(f"The benchmark is not sent the request '{ask['ask']}': a robot cell has no such sensor.")
        said = super().ask(ask, patience)
        self.asked.append({**ask, "answered": sorted(said)})
        if ask["ask"] == "reset":
            self.sentence = str(said.get("language", ""))
        return said

    def picture(self) -> bytes:
        """Return the colours of what the camera sees now, as PNG."""
        return base64.b64decode(self.ask({"ask": "look"}, self.patience)["rgb"])

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Take a picture, and write the scene that it shows as a scenario whose goal is the task's sentence; return
        its file, and the ``Setting`` of the search: world, robot and backend."""
        said = self.ask({"ask": "look"}, self.patience)
        hello = self.hello()
        mount = RobotMount("robot", "libero_panda", joints=tuple(said["joints"]), opening=min(said["opening"], 0.08))
        view, table, camera = located(engine, pictured(said, self.seed), mount)
        library = library_folder()
        found, obstacles = seen(engine, view, table, kinds_of(library), mount)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ASKED).write_bytes(json.format(json.encode({
            "asked": self.asked, "sentence": self.sentence, "table": table, "camera": camera,
            "seen": [{"kind": f.kind, "position": f.pose.position, "quaternion": f.pose.quaternion, "confidence": f.confidence,
                      "joints": f.joints} for f in found],
            "obstacles": [{"position": o.pose.position, "half_extents": o.geoms[0].half_extents} for o in obstacles],
        })))  # fmt: skip
        placed = [Placed(f.kind, f.pose, {name: value for name, value, _ in f.joints}) for f in found]
        xml, state = scene_of(placed, files_of(library), table, obstacles)
        x, y, _ = view.camera.position

        def goal(setting: Setting) -> list[str]:
            scene = setting.symbolic(engine.knowledge.taxonomy)
            return list(understand(self.sentence, scene, engine.knowledge, f"{x:.3f}, {y:.3f}").goals)

        limits = {"advisory": ["bystanders"], "may_push": True}
        scene = {"xml": xml, "qpos": state}
        model = scene_model(engine, folder, scene, hello, twins, robot={"type": "libero_panda"}, limits=limits)
        return scene_setting(engine, model, folder, scene, hello, goal, now)


def library_folder() -> Path:
    """Return the folder with the library of object models for LIBERO's kinds of things.

    Raises:
        UserError: it is not there; says how it is made.
    """
    folder = library()
    if not (folder / "library.yaml").is_file():
        raise UserError(f"There is no library of LIBERO's kinds in '{folder}'; docs/how-to/libero.md#by-camera says how one is made.")
    return folder


@lru_cache(maxsize=1)
def kinds_of(library: Path) -> tuple[Thing, ...]:
    """Return one thing of each kind in a library of object models, placed at the origin."""
    makers = Engine().knowledge.registry.first("read_models", path=library) or ()
    return tuple(maker.make(name=maker.name, pose=Pose()) for maker in makers)


def connect(environment: Path | None) -> LiberoByCamera:
    """Return LIBERO as a benchmark that is asked only for pictures with depth, joint values and the task's
    sentence."""
    return LiberoByCamera(environment)
