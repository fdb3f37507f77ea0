"""Proven programs that the rules edit: scenarios of the corpus, resolved once, with a run of the text as it is."""

from __future__ import annotations

import json
from contextlib import redirect_stderr, redirect_stdout
from functools import cached_property
from io import StringIO
from pathlib import Path
from typing import Any

from cramlite.base.value import Value
from cramlite.cli.main import main
from cramlite.model import Rollout
from cramlite.model.run.rollout import load_rollout, save_rollout
from cramlite.model.world.world import World
from cramlite.plugin.catalogue import Knowledge
from cramlite.scenario.worlds import read_world

from . import tracks
from .script import Script, script_of

SCENARIOS = Path(__file__).parent / "scenarios"


class Base(Value):
    """Kind of program that is edited.

    Args:
        name: of its scenario file.
        held: what the tasks are about.
        place: where that goes, or what it is fixed to.
        stranger: what no task names.
        is_a: what rules may ask for: "lifted", "placed" (put down onto a surface), "dropped" (into a container), "vessel", "joint", ...
        scenario: file, where it is not named after the base.
        suffix: of the program's file in a run directory.
    """

    name: str
    held: str
    place: str
    stranger: str
    is_a: frozenset[str]
    scenario: str = ""
    suffix: str = "script"


def _base(
    name: str, held: str, place: str, stranger: str, is_a: str, scenario: str = "", suffix: str = "script"
) -> Base:
    return Base(name, held, place, stranger, frozenset(is_a.split()), scenario or name, suffix)


BASES = (
    _base("shelf", "block", "shelf", "tin", "shelf lifted placed stranger parked"),
    _base("stack", "upper", "lower", "third", "stack lifted placed stranger parked"),
    _base("fragile", "egg_box", "shelf", "vase", "fragile lifted placed stranger parked"),
    _base("lid", "lid", "pot", "tin", "lid placed stranger parked"),
    _base("drawer", "tin", "drawer", "box", "drawer lifted dropped joint stranger"),
    _base("basket", "block", "basket", "tin", "basket lifted dropped stranger parked"),
    _base("fetch", "tea", "basket", "tin", "fetch dropped stranger parked"),
    _base("hang", "pack", "hook", "tin", "hang stranger parked"),
    _base("pour", "jug", "bowl", "tin", "pour vessel"),
    _base("shake", "jug", "counter", "tin", "shake vessel stranger"),
    _base("push", "block", "floor", "tin", "push stranger"),
    _base("slide", "block", "floor", "tin", "slide stranger"),
    _base("door", "door", "cabinet", "tin", "door joint turning stranger parked"),
    _base("knob", "knob", "panel", "tin", "knob joint turning stranger parked"),
    _base("shut", "door", "cabinet", "tin", "shut joint stranger parked"),
    _base("off", "knob", "panel", "tin", "off joint turning stranger parked"),
    _base("goals", "block", "shelf", "tin", "goals lifted placed stranger"),
    _base("typed", "block", "shelf", "tin", "typed", "shelf", "json"),
    _base("typed_drawer", "tin", "drawer", "box", "typed_drawer", "drawer", "json"),
)
"""Programs in URScript, and two of them as typed JSON."""


class Ready(Value, dict=True):
    """Resolved base.

    Args:
        base: which one.
        folder: its run directory.
        world: that it was proven in.
        run: of the text as it is.
    """

    base: Base
    folder: Path
    world: World
    run: Rollout

    @cached_property
    def text(self) -> str:
        """The program."""
        return (self.folder / f"program.{self.base.suffix}").read_text()

    @cached_property
    def script(self) -> Script:
        """The program, by its steps."""
        return script_of(self.text)

    @property
    def typed(self) -> dict[str, Any]:
        """The typed program, as data that may be changed."""
        found: dict[str, Any] = json.loads(self.text)
        return found

    @cached_property
    def grasp(self) -> list[float]:
        """Where the hand grips what is held: x, y, z and rotation vector."""
        return self.script.numbers(self.script.variables(r"grasping(_\d)?_approach_pose")[0])

    @cached_property
    def release(self) -> list[float]:
        """Where the hand lets go of it for the last time."""
        return tracks.hand(self.run, tracks.release(self.run, self.base.held))

    def rest(self, thing: str) -> list[float]:
        """Return where a thing stands at first."""
        return tracks.rest(self.run, thing)


def ready(base: Base, work: Path, knowledge: Knowledge) -> Ready:
    """Resolve a base, or read it where that was done; the seed is 0, and no twins are asked.

    Args:
        work: folder of the run directories.
    """
    folder = work / base.scenario
    if not (folder / "summary.json").is_file():
        _resolve(base, folder)
    world = read_world(str(folder), knowledge, 0)
    record = folder / f"as_it_is_{base.suffix}.npz"
    if not record.is_file():
        save_rollout(simulated((folder / f"program.{base.suffix}").read_text(), world, knowledge), record)
    return Ready(base, folder, world, load_rollout(record, world))


def simulated(text: str, world: World, knowledge: Knowledge) -> Rollout:
    """Run a text without any validator."""
    return knowledge.simulator.execute(text, world, knowledge.robots_of(world), mount=world.robots[0].name, seed=0)


def _resolve(base: Base, folder: Path) -> None:
    file = SCENARIOS / f"{base.scenario}.yaml"
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as said:
        code = main(["resolve", str(file), "--twins", "0", "--no-report", "--out", str(folder)])
    if code:
        raise RuntimeError(f"{base.scenario} is not proven: {said.getvalue()}")
