"""What cannot be grasped, reached, threaded or read: the nearest miss with numbers, through the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh
from conftest import Ran, Run
from helpers import made

FLOOR = "  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}\n"
SHELF = "  - {name: shelf, model: table, at: {position: [%s, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}\n"
BLOCK = "  - {name: it, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}\n"
MESH = "  - {name: it, model: mesh, at: {position: [0.5, 0.2, 30 mm]}, with: {file: it.stl, %s}}\n"
PLACE = (
    "[{task: Grasp, Patient: it}, {task: PickUp, Locatum: it, Relatum: floor}, {task: Place, Locatum: it, Relatum: shelf}]"
)


FEW = "budget: {expansions: 30, sequences: 1}\n"
"""Enough to get as far as what is refused: every grasp that there is, and every way to it, says the same."""


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def _resolve(run: Run, folder: Path, things: str, tasks: str = "[{task: Grasp, Patient: it}]", budget: str = "") -> Ran:
    path = folder / "s.yaml"
    path.write_text(f"scenario: bad\nrobot: {{type: ur5e}}\n{budget}tasks: {tasks}\nthings:\n{FLOOR}{things}")
    ran = run("resolve", path, "--no-report", "--out", folder / "run")
    assert "Traceback" not in ran.out + ran.err
    return ran


def _says(ran: Ran, code: int, *words: str) -> None:
    assert ran.code == code, ran.err
    for word in words:
        assert word in ran.err, ran.err


def test_too_wide_for_the_gripper(run: Run, tmp_path: Path) -> None:
    wide = "  - {name: it, model: block, at: {position: [0.5, 0.2, 66 mm]}, with: {size: [120 mm, 200 mm, 130 mm]}}\n"
    _says(_resolve(run, tmp_path, wide), 1, "'it' (120 mm)", "81 mm")


def test_a_mesh_too_wide_for_the_gripper(run: Run, tmp_path: Path) -> None:
    trimesh.creation.icosphere(3, 0.06).export(tmp_path / "it.stl")
    ran = _resolve(run, tmp_path, MESH.replace("30 mm", "66 mm") % "mass: 300 g")
    _says(ran, 1, "81 mm", "'it'")


def test_a_goal_out_of_reach(run: Run, tmp_path: Path) -> None:
    ran = _resolve(run, tmp_path, BLOCK + SHELF % "1.6, -0.35", PLACE)
    _says(ran, 1, "shelf", " m > ", "of arm 'ur5e'")


@pytest.mark.heavy
def test_a_start_in_collision(run: Run, tmp_path: Path) -> None:
    from cramlite_plugins.kinematics.forward import forward
    from cramlite_plugins.robots.ur5e import UR5E

    x, y, z = forward(UR5E, UR5E.home).position
    wall = f"  - {{name: wall, model: table, at: {{position: [{x:.3f}, {y:.3f}, {z:.3f}]}}, with: {{size: [0.2, 0.2, 0.1]}}}}\n"
    _says(_resolve(run, tmp_path, BLOCK + wall, budget=FEW), 1, "wall", "mm inside", "start")


def test_a_peg_thicker_than_the_hole(run: Run, tmp_path: Path) -> None:
    things = (
        "  - {name: hook, model: hanger, at: {position: [0.87, 0, 0.45], yaw: 180 deg}}\n"
        "  - {name: it, model: boxed_product, at: {position: [0.45, -0.3, 56 mm], yaw: -70 deg},"
        " with: {size: [60 mm, 50 mm, 100 mm], hole_diameter: 5 mm}}\n"
    )
    tasks = "[{task: Grasp, Patient: it}, {task: PickUp, Locatum: it}, {task: HoleOnPeg, Locatum: it, Relatum: hook/peg}]"
    _says(_resolve(run, tmp_path, things, tasks, FEW), 1, "a hole of 5.0 mm does not move on a peg of 6.0 mm")


def test_no_mass(run: Run, tmp_path: Path) -> None:
    made.bowl().export(tmp_path / "it.stl")
    _says(_resolve(run, tmp_path, MESH % "mass: 0"), 2, "s.yaml:6", "mass 0.0 kg", "between 0.0001")
    _says(_resolve(run, tmp_path, MESH % "scale: 1"), 2, "exactly one of 'mass' and 'density'", "cm3")


def test_a_huge_mesh_and_one_in_millimetres(run: Run, tmp_path: Path) -> None:
    with (tmp_path / "it.stl").open("wb") as file:
        file.truncate(84 + 50 * 2_400_000)
    _says(_resolve(run, tmp_path, MESH % "mass: 300 g"), 2, "s.yaml:6", "2,400,000 faces", "500,000", "Simplify")
    mesh = made.bowl()
    mesh.apply_scale(1000)
    mesh.export(tmp_path / "it.stl")
    _says(_resolve(run, tmp_path, MESH % "mass: 300 g"), 2, "140 x 140 x 50 m", "'scale: 0.001'")


def test_a_missing_mesh(run: Run, tmp_path: Path) -> None:
    made.bowl().export(tmp_path / "itt.stl")
    _says(_resolve(run, tmp_path, MESH % "mass: 300 g"), 2, "no such file", "did you mean 'itt.stl'")


@pytest.mark.heavy
def test_an_open_mesh_is_repaired_and_said_so(run: Run, tmp_path: Path) -> None:
    made.opened(made.tagged(), 1).export(tmp_path / "it.stl")
    ran = _resolve(run, tmp_path, MESH.replace("30 mm", "56 mm") % "mass: 300 g")
    _says(ran, 0, "not watertight, 3 open edges; closed by adding 1 faces", "hole of")
