"""Pegs and holes in foreign scenes: posts that a hole of a thing goes over, and those that none does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cramlite.model import Feature, ImportedScene, Thing
from cramlite_plugins.imports.scenes.reader import read_scene
from cramlite_plugins.shapes.peg_fit import aligned, play, stands

DATA = Path(__file__).parent / "scenes_data" / "pegs.xml"
RING = "".join(
    f'<geom type="box" size=".012 .011 .008" pos="{0.035 * np.cos(a):.5f} {0.035 * np.sin(a):.5f} 0" euler="0 0 {np.degrees(a):.3f}"/>'
    for a in np.arange(12) * np.pi / 6
)
TABLE = '<body name="desk"><geom type="box" size=".4 .4 .02"/></body>'


def _scene(tmp_path: Path, text: str) -> ImportedScene:
    path = tmp_path / "scene.xml"
    path.write_text(text)
    scene = read_scene(path, {}, "", {})
    assert scene is not None
    return scene


def _changed(tmp_path: Path, old: str, new: str) -> ImportedScene:
    text = DATA.read_text()
    assert old in text
    return _scene(tmp_path, text.replace(old, new))


def _thing(scene: ImportedScene, name: str) -> Thing:
    return next(t for t in scene.things if t.name == name)


def _features(scene: ImportedScene, name: str, type_: str) -> list[Feature]:
    return [f for f in _thing(scene, name).features if f.type == type_]


def test_a_square_post_that_a_nut_goes_over_is_a_peg_from_what_it_stands_in(tmp_path: Path) -> None:
    scene = _scene(tmp_path, DATA.read_text())
    (peg,) = _features(scene, "post", "vrps:Peg")
    assert peg.size == pytest.approx({"radius": 0.012, "width": 0.024, "length": 0.13})
    foot = _thing(scene, "post").pose * peg.pose
    assert foot.position == pytest.approx((0.55, 0.15, 0.22)) and foot.rotate((0, 0, 1)) == pytest.approx((0, 0, 1))
    assert {g.part for g in _thing(scene, "post").geoms} == {"peg"}
    assert "peg of 12 x 24 x 130 mm" in scene.found["post"]


def test_the_hole_between_the_shapes_of_a_nut_has_sides(tmp_path: Path) -> None:
    scene = _scene(tmp_path, DATA.read_text())
    (hole,) = _features(scene, "nut", "vrps:Hole")
    assert hole.size == pytest.approx({"diameter": 0.032, "width": 0.032, "depth": 0.018}, abs=1e-6)
    assert hole.pose.position == pytest.approx((0, 0, 0), abs=1e-6)
    x, y, z = hole.pose.rotation.T
    assert abs(x[:2]).max() == pytest.approx(1.0, abs=1e-6) and y == pytest.approx((-1, 0, 0), abs=1e-6)
    assert abs(z[2]) == pytest.approx(1.0, abs=1e-6)
    (peg,) = _features(scene, "post", "vrps:Peg")
    assert aligned(hole, peg) and play(hole, peg) == pytest.approx(0.004, abs=1e-6)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('size="0.012 0.012 0.09"', 'size="0.0165 0.0165 0.09"'),  # thicker than the hole
        ('pos="0.55 0.15 0.26"', 'pos="0.55 0.15 0.17"'),  # hardly out of the table
        ('size="0.012 0.012 0.09"', 'size="0.012 0.02 0.09"'),  # a board
        ('size="0.012 0.012 0.09"', 'size="0.006 0.006 0.09"'),  # a hole with more play than the peg is thick goes around it
        ("<freejoint/>", ""),  # nothing can be threaded
        ('<body name="post"', '<body name="lid" pos="0.55 0.15 0.37"><geom type="box" size=".1 .1 .01"/></body><body name="post"'),
    ],
    ids=["thick", "short", "board", "loose", "glued", "covered"],
)
def test_a_post_that_nothing_goes_over_is_no_peg(old: str, new: str, tmp_path: Path) -> None:
    scene = _changed(tmp_path, old, new)
    assert not _features(scene, "post", "vrps:Peg")
    assert not _features(scene, "nut", "vrps:Hole")


def test_a_ring_of_boxes_has_a_round_hole_for_a_round_peg_on_a_wall(tmp_path: Path) -> None:
    wall = '<body name="wall"><geom type="box" size=".02 .4 .4" pos=".4 0 .4"/></body>'
    bolt = '<body name="bolt" pos=".33 0 .4"><geom type="cylinder" size=".015 .07" euler="0 90 0"/></body>'
    ring = f'<body name="ring" pos="0 0 .03"><freejoint/>{RING}</body>'
    scene = _scene(tmp_path, f"<mujoco><worldbody>{TABLE}{wall}{bolt}{ring}</worldbody></mujoco>")
    (peg,), (hole,) = _features(scene, "bolt", "vrps:Peg"), _features(scene, "ring", "vrps:Hole")
    assert peg.size == pytest.approx({"radius": 0.015, "length": 0.12}) and "width" not in hole.size
    axis = (_thing(scene, "bolt").pose * peg.pose).rotate((0.0, 0.0, 1.0))
    assert axis == pytest.approx((-1, 0, 0), abs=1e-6) and not stands(axis)
    assert hole.size["diameter"] / 2 == pytest.approx(0.023, abs=5e-4)


def test_a_square_peg_goes_into_a_round_hole_by_its_corners() -> None:
    hole = Feature("hole", "vrps:Hole", size={"diameter": 0.030})
    thin, thick = ({"radius": r, "width": 2 * r, "length": 0.1} for r in (0.010, 0.011))
    assert play(hole, Feature("peg", "vrps:Peg", size=thin)) == pytest.approx(0.00085786, abs=1e-7)
    assert play(hole, Feature("peg", "vrps:Peg", size=thick)) < 0.0
    assert play(hole, Feature("peg", "vrps:Peg", size={"radius": 0.011, "length": 0.1})) == pytest.approx(0.004)
