"""``cramlite show``: the world of a scenario as a picture, before anything is resolved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import Run
from PIL import Image

WORLD = """
scenario: one_tin
tasks: []
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: tin, model: block, type: cram:Tin, at: {position: [0.4, 0.3, 30 mm]}}
"""
SECOND = "  - {name: other, model: block, type: cram:Tin, at: {position: [0.5, -0.3, 30 mm]}}\n"


def test_a_world_is_drawn_with_all_its_things_before_it_has_any_task(run: Run, tmp_path: Path) -> None:
    drawn = []
    for name, text in (("one", WORLD), ("two", WORLD + SECOND)):
        (tmp_path / f"{name}.yaml").write_text(text)
        done = run("show", tmp_path / f"{name}.yaml", "--out", tmp_path / f"{name}.png")
        assert done.code == 0 and done.out.strip() == str(tmp_path / f"{name}.png"), done.err
        drawn.append(np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB"), dtype=float))
    assert drawn[0].shape == (720, 960, 3) and drawn[0].std() > 10, "nothing is to be seen"
    assert np.abs(drawn[0] - drawn[1]).max() > 50, "the second thing is not to be seen"


def test_a_world_that_drives_fills_vessels_and_has_joints_is_drawn(run: Run, tmp_path: Path) -> None:
    for name in ("tasks/looking_at_mobile", "tasks/pouring", "tasks/opening"):
        out = tmp_path / f"{Path(name).name}.png"
        done = run("show", name, "--out", out)
        assert done.code == 0, done.err


def test_a_picture_is_not_written_over(run: Run, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"mine")
    done = run("show", "place_on_shelf", "--out", tmp_path / "a.png")
    assert done.code == 2 and "exists already" in done.err and (tmp_path / "a.png").read_bytes() == b"mine"
