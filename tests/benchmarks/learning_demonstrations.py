"""Demonstrations for learning rules: every task with a rule that a hand can show, and when the person did which task.

Written before the learner and without it: worlds and tasks are those of the shipped scenarios, people the shipped scripts. What is true is
what the person was told to do: the time from the beginning to the end of the script of each task.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.value import Value
from cramlite.engine.recording import record_episode
from cramlite.model import Episode, Event, Track
from cramlite.plugin import Performance, Performer, RecordScript

SCENARIOS: Mapping[str, tuple[str, ...]] = {
    "artm:AssumingArmPoseConstrained": ("tasks/assuming_arm_pose_constrained",),
    "artm:CloseGripperTask": ("tasks/close_gripper_task",),
    "artm:ExtractHoleFromPeg": ("tasks/extract_hole_from_peg",),
    "artm:InsertHoleOntoPeg": ("tasks/insert_hole_onto_peg",),
    "artm:NoOp": ("tasks/no_op",),
    "artm:OpenGripperTask": ("tasks/open_gripper_task",),
    "artm:SlidingGripper": ("tasks/sliding_gripper",),
    "artm:SlidingObject": ("tasks/sliding_object",),
    "artm:Ungrasping": ("tasks/ungrasping",),
    "cram:Shaking": ("tasks/shaking",),
    "cram:TurningOff": ("tasks/turning_off",),
    "cram:TurningOn": ("tasks/turning_on", "tasks/turning_on_switch"),
    "soma:AssumingArmPose": ("tasks/assuming_arm_pose",),
    "soma:Closing": ("tasks/closing", "tasks/closing_drawer"),
    "soma:Grasping": ("tasks/grasping",),
    "soma:Holding": ("tasks/holding",),
    "soma:Opening": ("tasks/opening", "tasks/opening_door"),
    "soma:PickingUp": ("tasks/picking_up",),
    "soma:Placing": ("tasks/placing",),
    "soma:Pouring": ("tasks/pouring",),
    "soma:Pushing": ("tasks/pushing",),
    "soma:PuttingDown": ("tasks/putting_down",),
    "soma:Reaching": ("tasks/reaching",),
    "soma:Releasing": ("tasks/releasing",),
    "soma:Retracting": ("tasks/retracting",),
    "soma:Transporting": ("tasks/transporting",),
}
"""Task with a rule file -> scenarios in which a person is told to do it; of several, people alternate."""


class Done(Value):
    """One task that a person did.

    Args:
        task: its class.
        start, end: when its script began and ended [s].
        fillers: role -> thing, as the person was told.
    """

    task: str
    start: float
    end: float
    fillers: dict[str, str]


class Shown(Value):
    """Demonstration with the true actions of the person; ``failure`` names an action that failed."""

    name: str
    episode: Episode
    done: tuple[Done, ...]
    failure: str = ""


def shown(engine: Engine, scenario: str, seed: int, cache: Path) -> Shown:
    """A demonstration of a scenario's tasks, from the cache where it was made before."""
    folder = cache / f"{scenario.replace('/', '_')}_{seed}"
    name = f"{scenario.split('/')[-1]}_{seed}"
    if not (folder / "done.json").exists():
        done: list[Done] = []
        with _timed(engine, done):
            recorded = record_episode(read_scenario(find_scenario(scenario)), engine, seed=seed, out=folder)
        said = {"done": [[d.task, d.start, d.end, d.fillers] for d in done], "failure": recorded.failure}
        (folder / "done.json").write_text(json.dumps(said), encoding="utf-8")
    said = json.loads((folder / "done.json").read_text(encoding="utf-8"))
    return Shown(name, replace(engine.read_episode(folder), name=name), tuple(Done(*d) for d in said["done"]), said["failure"])


class _timed:
    """Let scripts of the engine's plugins write down their begin and end while the context lasts."""

    def __init__(self, engine: Engine, done: list[Done]) -> None:
        self.knowledge, self.done = engine.knowledge, done

    def __enter__(self) -> None:
        self.before = self.knowledge.record_scripts
        timed = {n: RecordScript(n, self._prepared(n, s)) for n, s in self.before.items()}
        self.knowledge.__dict__["record_scripts"] = timed

    def __exit__(self, *_: object) -> None:
        self.knowledge.__dict__["record_scripts"] = self.before

    def _prepared(self, name: str, script: RecordScript):  # noqa: ANN202
        def prepare(world, fillers, rng) -> Performance:  # noqa: ANN001
            made = script.prepare(world, fillers, rng)

            def act(person: Performer) -> None:
                start = float(person.data.time)
                made.act(person)
                told = {k: v for k, v in fillers.items() if isinstance(v, str)}
                self.done.append(Done(name, start, float(person.data.time), told))

            return replace(made, act=act)

        return prepare


def named(one: Shown) -> Episode:
    """The episode with the tasks that the person was told to do written down, as a labelled recording has them."""
    last = one.episode.span[1]
    events = tuple(Event(f"told {k}", d.task, "action", d.start, min(d.end, last), d.fillers) for k, d in enumerate(one.done))
    return replace(one.episode, events=tuple(sorted((*one.episode.events, *events), key=lambda e: e.start)))


def with_losses(episode: Episode, share: float, rng: np.random.Generator) -> Episode:
    """The episode without a share of its poses, each row of each track at random; first rows stay."""
    tracks = {}
    for name, track in episode.tracks.items():
        kept = rng.random(len(track.times)) >= share
        kept[:1] = True
        tracks[name] = Track(track.times[kept], track.poses[kept])
    return replace(episode, tracks=tracks)


def all_shown(engine: Engine, seeds: range, cache: Path) -> Iterator[tuple[str, Shown]]:
    """Each task with its demonstrations by people of some seeds that came off."""
    for task, scenarios in SCENARIOS.items():
        for k, seed in enumerate(seeds):
            made = shown(engine, scenarios[k % len(scenarios)], seed, cache)
            if not made.failure and any(d.task == task for d in made.done):
                yield task, made


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        for task, one in all_shown(Engine(), range(500, 502), Path(place)):
            print(task, one.name, one.failure, [(d.task, round(d.start, 2), round(d.end, 2), d.fillers) for d in one.done])
