"""What things look like, and what a request says of where they are, tells which ones a sentence means."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine, NotUnderstood, read_scenario
from cramlite.interpretation.fluents import SymbolicWorld
from cramlite.model import Looks
from cramlite.planning.spoken_goals import understand

ENGINE = Engine()
SCENE = """\
scenario: looks
goal: [soup_1 in basket]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.8 m, 1.8 m, 20 mm]}}
  - {name: basket, model: basket, at: {position: [0.4, 0.45, 5 mm]}, with: {size: [0.3 m, 0.3 m, 0.12 m]}}
  - {name: tray, model: table, at: {position: [0.4, -0.5, 50 mm]}, with: {size: [0.3 m, 0.3 m, 20 mm]}}
  - {name: soup_1, model: can, type: cram:Product, at: {position: [0.5, -0.1, 41 mm]}, with: {radius: 30 mm, height: 70 mm}}
  - {name: sauce_1, model: block, type: cram:Product, at: {position: [0.62, 0.05, 51 mm]}, with: {size: [50 mm, 50 mm, 90 mm]}}
  - {name: cheese_1, model: block, type: cram:Product, at: {position: [0.45, -0.5, 82 mm]}, with: {size: [80 mm, 40 mm, 40 mm]}}
  - {name: pudding_1, model: block, type: cram:Product, at: {position: [0.35, 0.05, 31 mm]}, with: {size: [80 mm, 40 mm, 50 mm]}}
"""
LOOKS = {
    "soup_1": Looks(("can",), ("grey", "blue"), ("red",)),
    "sauce_1": Looks(("bottle",), ("brown",), ("green",)),
    "cheese_1": Looks(("box",), ("blue", "white")),
    "pudding_1": Looks(("box",), ("brown",)),
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> SymbolicWorld:
    """Four products whose looks are known."""
    file = tmp_path_factory.mktemp("scene") / "scene.yaml"
    file.write_text(SCENE)
    found = ENGINE.setting(read_scenario(file), twins=0).symbolic(ENGINE.knowledge.taxonomy)
    things = tuple(replace(t, looks=LOOKS.get(t.name, t.looks)) for t in found.world.things)
    return replace(found, world=replace(found.world, things=things))


@pytest.mark.parametrize(
    ("said", "goals"),
    [
        ("put the can in the basket", ["soup_1 in basket"]),
        ("the blue box goes in the basket", ["cheese_1 in basket"]),
        ("put both boxes in the basket", ["cheese_1 in basket", "pudding_1 in basket"]),
        ("put the bottle with the green cap in the basket", ["sauce_1 in basket"]),
        ("put the brown box in the basket and the blue one on the tray", ["pudding_1 in basket", "cheese_1 on tray"]),
        ("put the metal can in the basket", ["soup_1 in basket"]),
        ("everything goes in the basket", [f"{n} in basket" for n in LOOKS]),
        ("everything except the boxes goes in the basket", ["soup_1 in basket", "sauce_1 in basket"]),
        ("grab the box nearest the tray and put it in the basket", ["cheese_1 in basket"]),
        ("the box closest to the basket should go in it", ["pudding_1 in basket"]),
        ("take the box off the tray", ["cheese_1 off tray"]),
        ("pick the blue box on the tray and place it on the floor", ["cheese_1 on floor"]),
    ],
)
def test_it_is_meant(scene: SymbolicWorld, said: str, goals: list[str]) -> None:
    assert sorted(understand(said, scene, ENGINE.knowledge).goals) == sorted(goals)


@pytest.mark.parametrize(
    "said",
    [
        "put the green box in the basket",
        "put the box in the basket",
        "put the bottle with the blue cap in the basket",
    ],
)
def test_it_is_asked_back(scene: SymbolicWorld, said: str) -> None:
    with pytest.raises(NotUnderstood):
        understand(said, scene, ENGINE.knowledge)


def test_straight_behind_is_meant_more_than_askew(scene: SymbolicWorld) -> None:
    world = scene.world.put({"pudding_1": replace(scene.world.thing("pudding_1").pose, position=(0.62, 0.08, 0.031))})
    moved = replace(scene, world=world.put({"cheese_1": replace(scene.world.thing("cheese_1").pose, position=(0.75, -0.12, 0.031))}))
    assert understand("put the box behind the can in the basket", moved, ENGINE.knowledge).goals == ("cheese_1 in basket",)


def test_a_material_that_a_class_tells_must_be_right(scene: SymbolicWorld) -> None:
    tin = replace(scene.world.thing("sauce_1"), type="cram:Tin")
    things = tuple(tin if t.name == "sauce_1" else t for t in scene.world.things)
    known = replace(scene, world=replace(scene.world, things=things))
    assert understand("put the metal tin in the basket", known, ENGINE.knowledge).goals == ("sauce_1 in basket",)
    with pytest.raises(NotUnderstood, match="nothing is known of 'wooden'"):
        understand("put the wooden tin in the basket", known, ENGINE.knowledge)
