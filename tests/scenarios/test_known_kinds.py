"""A cell whose things a library knows by their print: looked for, meant by a sentence, put away, and executed."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from helpers.as_a_user import cramlite
from helpers.chest import write_chest
from helpers.printed_box import printed_box, tiles

from cramlite import Engine, read_scenario
from cramlite.model import Pose

SIZES = {"oats_box": (0.06, 0.045, 0.12), "rice_box": (0.06, 0.045, 0.12), "salt_box": (0.05, 0.05, 0.10), "soap_box": (0.07, 0.05, 0.06)}
CELL = """\
scenario: groceries
title: Look for a box of oats among others, and put it into a basket
goal: {say: SENTENCE}
robot: {type: ur5e}
models: [library]
camera: {mount: flange, at: {position: [0, 90 mm, 30 mm], yaw: 180 deg}}
poses: camera
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: counter, model: table, at: {position: [0.5, 0.2, 0.1]}, with: {size: [0.4 m, 0.4 m, 20 mm]}}
  - {name: basket, model: basket, at: {position: [0.30, -0.45, 0]}, with: {size: [0.4 m, 0.3 m, 0.15 m]}}
  - {name: a, model: oats_box, at: {position: [0.52, 0.1, 0.171]}}
  - {name: b, model: rice_box, at: {position: [0.42, 0.26, 0.171]}}
  - {name: c, model: salt_box, at: {position: [0.56, 0.33, 0.161]}}
  - {name: stranger, model: block, at: {position: [0.60, 0.20, 0.141]}, with: {size: [50 mm, 50 mm, 60 mm]}}
"""

CHEST = """\
scenario: chest
title: Find a chest by camera, and open its drawer
goal: {say: open the drawer}
robot: {type: ur5e}
models: [chests]
camera: {mount: world, at: {position: [0.15, -0.65, 0.6], roll: -123 deg, yaw: -29 deg}, finds: [chest]}
poses: camera
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: chest, model: chest, at: {position: [0.62, 0.1, 5 mm], yaw: 180 deg}}
"""


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the library, in which scenarios may be written."""
    folder = tmp_path_factory.mktemp("groceries")
    for k, (name, size) in enumerate(SIZES.items()):
        (folder / "meshes" / name).mkdir(parents=True)
        printed_box(folder / "meshes" / name / f"{name}.glb", size, tiles(k, darkest=70))
    made = cramlite("library", "add", folder / "meshes", "--out", folder / "library", "--up", "z")
    assert made.returncode == 0, made.stderr
    write_chest(folder / "furniture")
    made = cramlite("library", "add", folder / "furniture", "--out", folder / "chests", "--up", "z")
    assert made.returncode == 0, made.stderr
    (folder / "chest.yaml").write_text(CHEST)
    return folder


def written(cell: Path, sentence: str) -> Path:
    """The scenario with a sentence."""
    path = cell / f"{len(sentence)}.yaml"
    path.write_text(CELL.replace("SENTENCE", sentence))
    return path


@pytest.mark.heavy
def test_what_a_sentence_means_is_put_away(cell: Path, tmp_path: Path) -> None:
    scenario = written(cell, "put the oats box into the basket")
    done = cramlite("resolve", scenario, "--out", tmp_path / "run", "--no-report", "--twins", "0", "--json")
    assert done.returncode == 0, done.stderr
    assert "oats_box_1 in basket" in (tmp_path / "run" / "trace.json").read_text()
    assert "obstacle_1" in done.stderr, "the stranger is in the way, and nothing more"
    ran = cramlite("execute", tmp_path / "run" / "program.script", "--world", scenario)
    assert ran.returncode == 0, ran.stdout + ran.stderr


@pytest.mark.heavy
def test_what_is_not_there_is_asked_back(cell: Path, tmp_path: Path) -> None:
    done = cramlite("goal", written(cell, "put the soap box into the basket"))
    assert done.returncode == 2, done.stdout
    assert "there is no 'the soap box' here" in done.stderr


@pytest.mark.heavy
def test_a_scenario_is_perceived_with_its_library(cell: Path) -> None:
    scenario = written(cell, "put the rice box into the basket")
    done = cramlite("perceive", scenario, "--query", "on=counter", "--attributes", "model", "--json")
    assert done.returncode == 0, done.stderr
    models = {a["values"]["model"]["value"] for a in json.loads(done.stdout)["answers"] if "model" in a["values"]}
    assert models == {"oats_box", "rice_box", "salt_box"}


def test_a_chest_is_known_as_the_camera_finds_it(cell: Path) -> None:
    within = CHEST + "  - {name: it, model: cube, at: {position: [0.49, 0.115, 57 mm]}}\n"
    said = within.replace("yaw: 180 deg}}", "yaw: 180 deg}, with: {joints: {slide: 100 mm}}}")
    (cell / "half_open.yaml").write_text(said)
    setting = Engine().setting(read_scenario(cell / "half_open.yaml"), twins=0)
    there, drawer = setting.world.thing("chest").pose, setting.world.thing("chest_drawer")
    assert 0 < there.distance(Pose.from_rotvec((0.62, 0.1, 0.005), (0, 0, math.pi)))[0] < 0.005, "not from the map"
    assert there.rotation[2, 2] == pytest.approx(1.0), "it stands level"
    assert drawer.joint is not None and drawer.joint.value == pytest.approx(0.1, abs=0.006)
    assert [r for r in setting.relations if r[2] == "chest_drawer"], "the cube is seen in it"


def test_what_the_camera_shall_find_is_furniture_and_there(cell: Path) -> None:
    (cell / "no_such.yaml").write_text(CHEST.replace("finds: [chest]", "finds: [shelf]"))
    done = cramlite("check", cell / "no_such.yaml")
    assert done.returncode == 2 and "no thing 'shelf' of the scenario's that is fixed" in done.stderr
    (cell / "unseen.yaml").write_text(CHEST.replace("yaw: -29 deg", "yaw: 150 deg"))
    unseen = cramlite("goal", cell / "unseen.yaml")
    assert unseen.returncode == 1 and "No picture shows 'chest'" in unseen.stderr


@pytest.mark.heavy
def test_a_drawer_of_a_kind_is_opened_where_the_camera_finds_it(cell: Path, tmp_path: Path) -> None:
    done = cramlite("resolve", cell / "chest.yaml", "--out", tmp_path / "run", "--no-report", "--twins", "0")
    assert done.returncode == 0, done.stderr
    assert "'chest_drawer open' holds" in done.stdout + done.stderr
