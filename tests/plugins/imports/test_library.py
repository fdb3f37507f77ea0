"""``cramlite library add``: what is taken of meshes and MJCF files, what is refused, and how scenarios use it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.as_a_user import cramlite
from helpers.printed_box import printed_box

from cramlite import Engine, UserError
from cramlite.model import Pose
from cramlite_plugins.imports.library.mjcf_kind import from_mjcf
from cramlite_plugins.shapes.skins import skin_of

CABINET = """<mujoco model="chest">
  <asset>
    <texture name="wood" type="2d" file="wood.png"/>
    <material name="wood" texture="wood"/>
    <mesh name="front" file="parts/front.obj"/>
  </asset>
  <worldbody>
    <body name="base">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="drawer" pos="0.1 0 0">
        <joint name="top" type="slide" axis="1 0 0" range="0 0.08"/>
        <geom type="mesh" mesh="front" material="wood" contype="0" conaffinity="0"/>
        <geom type="box" size="0.01 0.08 0.03" density="500"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A carton as OBJ with its texture, a plain cube as STL, a flat mesh, and a chest as MJCF with a part."""
    from PIL import Image

    found = tmp_path / "meshes"
    (found / "carton").mkdir(parents=True)
    printed_box(found / "carton" / "textured.obj", (0.08, 0.05, 0.12))
    trimesh.creation.box((0.04, 0.04, 0.04)).export(str(found / "cube.stl"))
    trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]).export(str(found / "sheet.obj"))
    (found / "chest" / "parts").mkdir(parents=True)
    (found / "chest" / "chest.xml").write_text(CABINET)
    Image.fromarray(np.full((8, 8, 3), (150, 90, 30), np.uint8)).save(found / "chest" / "wood.png")
    printed_box(found / "chest" / "parts" / "front.obj", (0.02, 0.16, 0.06))
    return found


def test_a_library_says_what_it_took_and_what_it_refused(folder: Path, tmp_path: Path) -> None:
    done = cramlite("library", "add", folder, "--out", tmp_path / "lib", "--density", 400)
    assert done.returncode == 0, done.stderr
    assert "carton: 80 x 50 x 120 mm, 12 triangles, texture 120 x 20" in done.stdout
    assert "mass 192 g, its volume at 400 kg/m3" in done.stdout
    assert "cube: 40 x 40 x 40 mm, 12 triangles, no texture" in done.stdout
    assert "joints: top 0 to 80 mm" in done.stdout
    assert "fixed (with joints" in done.stdout
    assert "Refused, 1 file" in done.stdout and "encloses no volume" in done.stdout
    assert "3 kinds in" in done.stdout
    again = cramlite("library", "add", folder, "--out", tmp_path / "lib", "--density", 400)
    assert again.stdout.count("(unchanged)") == 3
    (folder / "cube.stl").write_bytes(trimesh.creation.box((0.05, 0.04, 0.04)).export(file_type="stl"))
    changed = cramlite("library", "add", folder, "--out", tmp_path / "lib", "--density", 400)
    assert "cube: 50 x 40 x 40 mm" in changed.stdout
    assert "carton (unchanged)" in changed.stdout


def test_two_files_of_one_name_are_not_one_kind(folder: Path, tmp_path: Path) -> None:
    cramlite("library", "add", folder, "--out", tmp_path / "lib")
    (tmp_path / "more").mkdir()
    trimesh.creation.box((0.03, 0.03, 0.03)).export(str(tmp_path / "more" / "cube.stl"))
    trimesh.creation.box((0.03, 0.03, 0.06)).export(str(tmp_path / "more" / "post.stl"))
    done = cramlite("library", "add", tmp_path / "more", "--out", tmp_path / "lib")
    assert "'cube' is the name of" in done.stdout and "post: 30 x 30 x 60 mm" in done.stdout


def test_kinds_are_object_models_with_their_look(folder: Path, tmp_path: Path) -> None:
    cramlite("library", "add", folder, "--out", tmp_path / "lib", "--up", "z")
    models = Engine(models=[tmp_path / "lib"]).knowledge.models
    carton = models["carton"].make(name="mine", pose=Pose((0.5, 0, 0.06)), mass="300 g")
    assert (carton.name, carton.mass) == ("mine", pytest.approx(0.3))
    assert carton.mesh is not None and carton.mesh.up == (0.0, 0.0, 1.0)
    skin = skin_of(carton.mesh)
    assert skin is not None
    colours = skin.colours_at(np.array([[0.04, 0.0, 0.0], [0.0, 0.0, 0.06]]), np.array([[1.0, 0, 0], [0, 0, 1.0]]))
    assert np.abs(colours - [(255, 0, 0), (255, 0, 255)]).max() < 8
    chest = models["chest"].make(name="chest", pose=Pose())
    assert chest.mass is None and len(chest.geoms) == 2
    drawer = skin_of(chest.mesh)
    assert drawer is not None
    assert drawer.corners[..., 0].min() == pytest.approx(0.09, abs=1e-6)  # in the frame of the base
    assert np.abs(drawer.colours_at(np.array([[0.11, 0, 0]]), np.array([[1.0, 0, 0]])) - (150, 90, 30)).max() < 8


def test_scenarios_name_libraries(folder: Path, tmp_path: Path) -> None:
    cramlite("library", "add", folder, "--out", tmp_path / "lib")
    scenario = tmp_path / "scenario.yaml"
    text = (
        "scenario: grasps_a_carton\nmodels: [lib]\ntasks: [{task: Grasping, Patient: box}]\nrobot: {type: ur5e}\nthings:\n"
        "  - {name: table, model: table, at: {position: [0.5, 0, 0]}}\n"
        "  - {name: box, model: carton, at: {position: [0.45, 0, 60 mm]}}\n"
    )
    scenario.write_text(text)
    assert cramlite("check", scenario).returncode == 0
    scenario.write_text(text.replace("[lib]", "[nothing]"))
    refused = cramlite("check", scenario)
    assert refused.returncode == 2
    assert "nothing' is no library of object models" in refused.stderr and "cramlite library add" in refused.stderr


def test_what_cannot_be_a_library_is_refused_in_one_paragraph(folder: Path, tmp_path: Path) -> None:
    missing = cramlite("library", "add", tmp_path / "none", "--out", tmp_path / "lib")
    assert missing.returncode == 2 and "There is no folder" in missing.stderr
    (tmp_path / "empty").mkdir()
    empty = cramlite("library", "add", tmp_path / "empty", "--out", tmp_path / "lib")
    assert empty.returncode == 2 and "could be read as a kind" in empty.stderr
    wrong = cramlite("library", "add", folder, "--density", 0)
    assert wrong.returncode == 2 and "kg/m3" in wrong.stderr
    cramlite("library", "add", folder, "--out", tmp_path / "lib")
    (tmp_path / "lib" / "cube.glb").unlink()
    with pytest.raises(UserError, match=r"names 'cube\.glb', and there is no such file"):
        _ = Engine(models=[tmp_path / "lib"]).knowledge.models


def test_a_window_of_a_model_is_not_seen(tmp_path: Path) -> None:
    model = """<mujoco><worldbody><body name="door">
      <geom type="box" size=".02 .1 .1" {opacity} mass="1" contype="0" conaffinity="0"/>
      <geom type="box" size=".03 .02 .1" pos="0 .1 0" rgba=".2 .2 .2 1" mass="1" contype="0" conaffinity="0"/>
    </body></worldbody></mujoco>"""
    seen = []
    for name, opacity in (("window", 'rgba=".4 .4 .4 .25"'), ("board", 'rgba=".4 .4 .4 1"')):
        (tmp_path / f"{name}.xml").write_text(model.format(opacity=opacity))
        seen.append(float(np.ptp(from_mjcf(tmp_path / f"{name}.xml", name).mesh.vertices[:, 1])))
    assert seen == pytest.approx([0.04, 0.22])
