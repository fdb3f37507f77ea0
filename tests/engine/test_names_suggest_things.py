"""What recordings call things suggests which things of the world are meant; contents matter to who shakes."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.own_worlds import own_world
from helpers.recorded_people import read, shaking

from cramlite import Engine, Trace, read_scenario
from cramlite.model import Object
from cramlite.planning.task_sequences import plans_from_interpretation
from cramlite.plugin import Context, Grounding
from cramlite_plugins.locations.objects import resolve_object

ENGINE = Engine()
REAL = Path(__file__).resolve().parents[3] / "shared" / "data" / "neem_real"
WORLD = """
scenario: names
tasks: [{task: Shaking, Patient: jug}]
robot: {type: ur5e}
things:
  - {name: bowl, model: bowl, at: {position: [0.5, -0.2, 0.026]}}
  - {name: can, model: can, at: {position: [0.5, 0, 0.06]}}
  - {name: jug, model: jug, at: {position: [0.5, 0.2, 0.051]}, with: {GRAINS}}
"""


def chosen(folder: Path, wanted: Object, grains: str = "grains: 6") -> list[str]:
    """The things of the world that may be meant, best first."""
    (folder / "names.yaml").write_text(WORLD.replace("GRAINS", grains))
    setting = ENGINE.setting(read_scenario(folder / "names.yaml"))
    context = Context(setting.robot, setting.world.robots[0], {}, ENGINE.knowledge.taxonomy)
    return [str(a.value) for a in resolve_object(wanted, setting.belief(), context) or () if isinstance(a, Grounding)]


def test_a_name_suggests_a_class_and_those_just_above_it() -> None:
    episode = read(shaking())
    found = ENGINE.interpret(episode)
    plan, _ = next(plans_from_interpretation("shown", found, episode, ENGINE.knowledge.tasks, Trace()))
    salt, _, plate = plan.objects
    assert salt.filled and salt.like == () and salt.types == ()  # "salt_shaker": no ontology has the word
    assert plate.like == ("soma:Plate", "soma:Crockery") and not plate.filled


def test_what_has_contents_comes_first_where_contents_matter(tmp_path: Path) -> None:
    assert chosen(tmp_path, Object("object_1", filled=True)) == ["jug", "bowl", "can"]
    assert chosen(tmp_path, Object("object_1", filled=True), "grains: 0") == ["bowl", "can", "jug"]


def test_a_class_that_a_name_suggests_is_asked_for_where_the_world_has_it(tmp_path: Path) -> None:
    plate = Object("object_1", like=("soma:Plate", "soma:Crockery"))
    assert chosen(tmp_path, plate) == ["bowl", "jug"]
    assert chosen(tmp_path, Object("object_1", like=("soma:Bowl", "soma:Crockery"))) == ["bowl", "jug"]


def test_a_class_that_a_name_suggests_and_the_world_lacks_refuses_nothing(tmp_path: Path) -> None:
    assert chosen(tmp_path, Object("object_1", like=("soma:Spoon", "soma:Cutlery"))) == ["bowl", "can", "jug"]


@pytest.mark.skipif(not REAL.exists(), reason="the real recordings are not here")
@pytest.mark.parametrize("name", ["KitchenLabNEEM", "ShakingMotionNEEM"])
def test_a_real_recording_needs_its_bowl_within_reach(name: str, tmp_path: Path) -> None:
    trace = Trace()
    (tmp_path / "own.yaml").write_text(own_world(REAL / name, 480, "bowl out of reach"))
    assert next(ENGINE.resolve(read_scenario(tmp_path / "own.yaml"), trace=trace), None) is None
    assert any("reach of arm 'ur5e'" in e.reason for e in trace.entries if e.text == "bowl")


@pytest.mark.heavy
@pytest.mark.skipif(not REAL.exists(), reason="the real recordings are not here")
@pytest.mark.parametrize(("name", "does"), [("KitchenLabNEEM", "Pouring"), ("ShakingMotionNEEM", "Shaking")])
def test_a_real_recording_gives_a_program_in_a_world_of_ones_own(name: str, does: str, tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text(own_world(REAL / name, 480))
    solution = next(iter(ENGINE.resolve(read_scenario(tmp_path / "own.yaml"))))
    done = [(a.task.split(":")[1], *(r.entity for r in a.roles.values())) for a in solution.candidate.actions]
    about = ("jug", "bowl") if does == "Pouring" else ("jug",)
    assert done[:2] == [("Grasping", "jug"), ("PickingUp", "jug", "counter")] and (does, *about) in done
    assert ("Releasing", "jug", "counter") in done


TOO_FEW = "the tasks need more things of soma:Crockery than the 2 that the world has: add one"


@pytest.mark.parametrize(
    ("taken", "said"),
    [
        ({"object_1": "bowl", "object_2": "jug"}, [TOO_FEW, TOO_FEW]),
        ({"object_1": "bowl"}, []),
    ],
)
def test_more_things_of_a_kind_than_the_world_has_are_said(tmp_path: Path, taken: dict[str, str], said: list[str]) -> None:
    (tmp_path / "names.yaml").write_text(WORLD.replace("GRAINS", "grains: 6"))
    setting = ENGINE.setting(read_scenario(tmp_path / "names.yaml"))
    context = Context(setting.robot, setting.world.robots[0], taken, ENGINE.knowledge.taxonomy)
    answers = resolve_object(Object("object_3", types=("soma:Crockery",)), setting.belief(), context) or ()
    reasons = [a.reason.split("; ") for a in answers if not isinstance(a, Grounding)]
    assert [r[1] for r in reasons if len(r) > 1] == said
