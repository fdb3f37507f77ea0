"""LIBERO as a benchmark that tells a robot only what a cell could: camera pictures and the task's sentence, no
model, state or goal formula."""

from __future__ import annotations

import base64
from functools import lru_cache
from pathlib import Path
from typing import Any

from msgspec import json
from msgspec.structs import replace

from cramlite import Engine, Setting, UserError
from cramlite.engine.recovery.expectation import RunWatch
from cramlite.language.sentence import cancels
from cramlite.model import Pose, RobotMount, Rollout, Thing, View, Watch, World
from cramlite.planning.spoken_goals import understand
from cramlite_plugins.backends.stream.messages import Action, State
from cramlite_plugins.benchmarks.benchmark_process import PATIENCE
from cramlite_plugins.benchmarks.benchmark_scene import scene_model, scene_setting

from .camera_watch import EVERY, CameraWatch
from .connection import Libero
from .panda import library
from .picture_belief import PictureBelief, kinds_in, with_looks
from .placed_kinds import Placed, files_of, scene_of
from .sight import again, around, located, pictured, seen

ALLOWED = ("reset", "look", "hello", "step", "check", "end")
"""Requests that this connection sends; a robot cell could answer all but ``reset`` and ``check``, which start and judge an episode."""
LATER = "pictures.json"
"""File with the number of pictures since the start of an episode, and what those told that were not as expected."""
ASKED = "asked.json"
"""File of an episode with all requests to the benchmark, and the names of the fields of its answers."""


class LiberoByCamera(Libero):
    """LIBERO, asked only for pictures with depth, joint values and the task's sentence."""

    def __init__(self, environment: Path | None = None, patience: float = PATIENCE) -> None:
        super().__init__(environment, patience)
        self.asked: list[dict[str, Any]] = []
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Forget the episode before."""
        self.asked, self.seed, self.pictures = [], seed, 0
        self.sentence, self.heard, self.goals = "", "", list[str]()
        self.belief: PictureBelief | None = None
        self.logged = 0
        self.camera, self.table = Pose(), 0.0

    def reset(self, suite: str, task: int, state: int) -> str:
        """Begin an episode, and remember the task's sentence."""
        self.begin(task * 1000 + state)
        return super().reset(suite, task, state)

    def ask(self, ask: dict[str, Any], patience: float) -> dict[str, Any]:
        """Send a request that a robot cell could answer, and return the answer; the request and the answer's
        keys are recorded.

        Raises:
            UserError: it asks for more, or as that of any benchmark.
        """
        if ask["ask"] not in ALLOWED:
            raise UserError(f"The benchmark is not sent the request '{ask['ask']}': a robot cell has no such sensor.")
        ask = ask | {"tracked": False} if ask["ask"] == "reset" else ask
        said = super().ask(ask, patience)
        self.asked.append({**ask, "answered": sorted(said)})
        if ask["ask"] == "reset":
            self.sentence = str(said.get("language", ""))
        return said

    def picture(self) -> bytes:
        """Return the colours of what the camera sees now, as PNG."""
        return base64.b64decode(self.ask({"ask": "look"}, self.patience)["rgb"])

    def look(self, *, colour: bool = True) -> tuple[View, RobotMount]:
        """Take a picture with the errors of a camera; return it, and the robot as its encoders have it."""
        said = self.ask({"ask": "look"} if colour else {"ask": "look", "colour": False}, self.patience)
        view = pictured(said, self.seed, self.pictures)
        self.pictures += 1
        mount = RobotMount("robot", "libero_panda", joints=tuple(said["joints"]), opening=min(said["opening"], 0.08))
        return (replace(view, camera=self.camera) if self.belief else view), mount

    def setting(self, engine: Engine, folder: Path, twins: int, now: World | None = None) -> tuple[Path, Setting]:
        """Take a picture, and write the scene that it shows as a scenario whose goal is the task's sentence; return
        its file, and the ``Setting`` of the search: world, robot and backend.

        Raises:
            UserError: it is asked for after a run whose pictures are all as its proof predicts them: there is nothing to tell; or a thing
                of the goal is nowhere in the picture.
        """
        if self.model is None or self.belief is None:
            return self._first(engine, folder, twins)
        if now is None:
            self._look_again()
            if self.belief.displaced or not self.belief.log[self.logged :]:
                raise UserError(self.belief.displaced or "The picture is as the proof of the program that was run predicts it.")
        if lost := sorted(n for n in self.belief.gone if any(n in goal.split() for goal in self.goals)):
            raise UserError(f"'{lost[0]}' of the goal is nowhere in the picture.")
        model, believed = self.model, self.belief.world
        there = {t.name: t for t in believed.things}
        first = {t.name for t in model.setting.world.things}
        scene = {
            "poses": {n: [*t.pose.position, *t.pose.quaternion] for n, t in there.items() if n in first and (t.movable or t.joint)},
            "absent": sorted(first - there.keys()),
        }  # fmt: skip
        come = [t for t in believed.things if t.name not in first]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / LATER).write_bytes(json.format(json.encode({"pictures": self.pictures, "told": self.belief.log})))
        return scene_setting(engine, model, folder, scene, self.hello(), lambda _: self.goals, now, come)

    def _first(self, engine: Engine, folder: Path, twins: int) -> tuple[Path, Setting]:
        """Take the first picture of an episode, write the scene that it shows, and understand the sentence."""
        view, mount = self.look()
        hello = self.hello()
        view, self.table, offset = located(engine, view, mount)
        library = library_folder()
        kinds = kinds_of(library)
        found, obstacles = seen(engine, view, self.table, kinds, mount)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ASKED).write_bytes(json.format(json.encode({
            "asked": self.asked, "sentence": self.sentence, "table": self.table, "camera": offset,
            "seen": [{"kind": f.kind, "position": f.pose.position, "quaternion": f.pose.quaternion, "confidence": f.confidence,
                      "joints": f.joints} for f in found],
            "obstacles": [{"position": o.pose.position, "half_extents": o.geoms[0].half_extents} for o in obstacles],
        })))  # fmt: skip
        placed = [Placed(f.kind, f.pose, {name: value for name, value, _ in f.joints}) for f in found]
        xml, state = scene_of(placed, files_of(library), self.table, obstacles)
        limits = {"advisory": ["bystanders"], "may_push": True}
        scene = {"xml": xml, "qpos": state}
        self.model = scene_model(engine, folder, scene, hello, twins, robot={"type": "libero_panda"}, limits=limits)
        self.camera, self.engine = view.camera, engine
        path, setting = scene_setting(engine, self.model, folder, scene, hello, self._understood)
        world = setting.world

        def recognise(believed: World) -> tuple[list[Thing], list[Thing]]:
            return again(engine, self.look()[0], self.table, kinds, believed)

        names = kinds_in(world.things, [k.name for k in kinds])
        self.belief = PictureBelief(engine, replace(world, robots=(mount, *world.robots[1:])), names, view, recognise, around(self.table))
        return path, setting

    def _understood(self, setting: Setting) -> list[str]:
        knowledge = self.engine.knowledge
        x, y, _ = self.camera.position
        scene = setting.symbolic(knowledge.taxonomy)
        scene = replace(scene, world=with_looks(scene.world, kinds_of(library_folder())))
        self.goals = list(understand(self.sentence, scene, knowledge, f"{x:.3f}, {y:.3f}").goals)
        return self.goals

    def _look_again(self) -> None:
        """Take a picture into the belief, with the arm where it stands."""
        assert self.belief is not None
        view, mount = self.look(colour=False)
        world = self.belief.world
        self.belief.update(view, replace(world, robots=(mount, *world.robots[1:])), afresh=bool(self.belief.gone))

    def play(self, program: str, setting: Setting, watch: Watch | None = None) -> Rollout:
        """Stream a program to the simulated robot; if it is watched, pictures are taken meanwhile."""
        if not isinstance(watch, RunWatch) or self.belief is None:
            return super().play(program, setting, watch)
        self.logged = len(self.belief.log)
        seeing = CameraWatch(watch, self.belief, lambda: self.look(colour=False), lambda: self.hold(EVERY))
        rollout = super().play(program, setting, seeing)
        if rollout.outcome != "finished":
            seeing.look_afresh()
        return rollout

    def step(self, action: Action) -> State:
        """Send an action and return the state of the robot after it, with another goal if one was said."""
        state = super().step(action)
        if state.sentence and state.sentence != self.heard:
            self.heard = state.sentence
            self.goals = self._heard(state.sentence)
        return replace(state, poses={}, goal=tuple((g,) for g in self.goals) if self.heard else None)

    def _heard(self, sentence: str) -> list[str]:
        """Return the goals of another sentence, in the scene of the first picture; none, so that the arm stops, of one that cancels the
        task or is not understood."""
        assert self.model is not None
        if cancels(sentence):
            return []
        self.sentence = sentence
        try:
            return self._understood(self.model.setting)
        except UserError:
            return []


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
