"""Tasks that a person is told to show: hands hold by friction alone, and the first reading says what was told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.shown_cases import CASES, reading

from cramlite import Engine, PluginError, read_scenario
from cramlite.engine.recording import record_episode, tasks_in_words
from cramlite.model import Pose
from cramlite.plugin import Performance, RecordScript, Shown, UserError
from cramlite.scenario.worlds import build_world
from cramlite_plugins.person.demonstrate import demonstrate

ENGINE = Engine()
QUICK = (
    "Grasping", "Placing", "Pushing", "SlidingObject", "Opening a drawer", "Closing a door", "ExtractHoleFromPeg",
    "PickAndPlace out of a drawer",
)  # fmt: skip
WORLD = """
scenario: kitchen
tasks: [{task: Grasping, Patient: block}]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: block, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [WIDTH, WIDTH, 100 mm], mass: MASS}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
physics: {pad_friction: FRICTION}
record:
  tasks:
    - {task: Placing, Locatum: block, Relatum: shelf}
"""


def world(folder: Path, width: str = "50 mm", friction: float = 0.9, mass: str = "200 g") -> Path:
    text = WORLD.replace("WIDTH", width).replace("FRICTION", str(friction)).replace("MASS", mass)
    (folder / "kitchen.yaml").write_text(text)
    return folder / "kitchen.yaml"


@pytest.mark.parametrize("name", QUICK)
def test_the_first_reading_says_what_was_shown(name: str) -> None:
    assert reading(ENGINE, CASES[name], 11) == (CASES[name].said, "")


@pytest.mark.heavy
@pytest.mark.parametrize("name", [n for n in CASES if n not in QUICK])
def test_the_first_reading_says_what_was_shown_of_the_others(name: str) -> None:
    """Ten people each, and with distractors: tests/benchmarks/shown_tasks.py."""
    assert reading(ENGINE, CASES[name], 12) == (CASES[name].said, "")


def test_a_list_in_the_scenario_is_shown_in_its_own_world(tmp_path: Path) -> None:
    found = record_episode(read_scenario(world(tmp_path)), ENGINE, seed=0, out=tmp_path / "neem")
    assert found.failure == ""
    assert found.episode.tracks["block"].poses[-1, 2] > 0.15


def test_without_friction_it_does_not_come_off_and_the_recording_says_so(tmp_path: Path) -> None:
    scenario = read_scenario(world(tmp_path, friction=0.0))
    found = record_episode(scenario, ENGINE, seed=0, out=tmp_path / "neem")
    assert found.failure == "'block' does not stand on 'shelf'"
    assert found.episode.tracks["block"].poses[-1, 2] < 0.1


def test_a_thing_wider_than_the_hand_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="finds no grasp of 'block'"):
        record_episode(read_scenario(world(tmp_path, width="110 mm")), ENGINE, seed=0, out=tmp_path / "neem")


def test_a_seed_is_one_person_and_another_another(tmp_path: Path) -> None:
    tasks = tasks_in_words("PickingUp Relatum=floor block", ENGINE.knowledge.tasks)
    assert tasks[0].roles == {"Locatum": "block", "Relatum": "floor"}
    hands = []
    for k, seed in enumerate((3, 3, 4)):
        found = record_episode(read_scenario(world(tmp_path)), ENGINE, seed=seed, out=tmp_path / f"neem_{k}", tasks=tasks)
        hands.append(found.episode.tracks["hand"].poses)
    assert np.array_equal(hands[0], hands[1]) and not np.array_equal(hands[0][:50], hands[2][:50])


SCRIPT = """
from cramlite.plugin import Performance, RecordScript, UserError, hookimpl


def prepare(world, fillers, rng):
    name = fillers.get("Patient", "block")

    def act(person):
        person.wait(0.2)
        above = person.aim
        person.move([type(above)((*above.position[:2], above.position[2] + rng.uniform(0.05, 0.1)), above.quaternion)], 0.2)

    return Performance(act, missed=lambda person: "" if person.holds(name) else f"'{name}' was not taken")


@hookimpl
def record_scripts():
    return [RecordScript("wave", prepare)]
"""


def test_a_script_of_a_plugin_is_performed(tmp_path: Path) -> None:
    (tmp_path / "waving.py").write_text(SCRIPT)
    path = world(tmp_path)
    path.write_text(path.read_text().split("record:")[0] + "record: {script: wave}\n")
    engine = Engine(files=[tmp_path / "waving.py"])
    found = record_episode(read_scenario(path), engine, seed=0, out=tmp_path / "neem")
    assert found.failure == "'block' was not taken"
    with pytest.raises(UserError, match=r"there is no script 'wave'; valid are: hang_onto_hanger"):
        record_episode(read_scenario(path), ENGINE, seed=0, out=tmp_path / "again")


@pytest.mark.parametrize(
    ("old", "new", "error", "says"),
    [
        ("    return Performance(", "    return (", PluginError, "script 'wave' prepares "),
        ("    def act(person):\n", "    def act(person):\n        return\n", UserError, "takes no time, so nothing was recorded"),
    ],
)
def test_a_script_that_shows_nothing_is_named(old: str, new: str, error: type[Exception], says: str, tmp_path: Path) -> None:
    script = SCRIPT.replace(old, new)
    (tmp_path / "waving.py").write_text(script.replace("(act, missed=", "(act, ") if error is PluginError else script)
    path = world(tmp_path)
    path.write_text(path.read_text().split("record:")[0] + "record: {script: wave}\n")
    with pytest.raises(error, match=says):
        record_episode(read_scenario(path), Engine(files=[tmp_path / "waving.py"]), seed=0, out=tmp_path / "neem")
    assert not (tmp_path / "neem").exists()


def test_a_wrist_that_cannot_turn_so_far_is_a_demonstration_that_did_not_come_off(tmp_path: Path) -> None:
    """The hand turns right round on its way to a block."""
    scenario = read_scenario(world(tmp_path))
    built, _ = build_world(scenario, scenario.spec.things, (), ENGINE.knowledge, 0)
    rest = Pose.from_axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, -1))
    behind = Pose.from_axes((0.3, 0, 0.5), z=(-1, 0, 0), x=(0, 0, -1))

    def script(*way: Pose) -> RecordScript:
        return RecordScript("turn", lambda *_: Performance(lambda person: person.move(way, 0.3), rests=(rest,)))

    turned = demonstrate(built, [Shown(script(behind))], seed=1)
    assert turned.outcome == "failed" and "wrist would have to turn by 17" in turned.reason
    assert demonstrate(built, [Shown(script(Pose((0.3, 0, 0.5), rest.quaternion)))], seed=1).outcome == "finished"
