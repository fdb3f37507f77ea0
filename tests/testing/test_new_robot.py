"""``cramlite new robot NAME --from FILE``: what is found is printed, the package passes its own test, and nothing is left of a bad file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import Run

from cramlite.testing.robot_skeleton import _needed

DATA = Path(__file__).parents[1] / "plugins" / "imports" / "robots_data"
KEYS = "payload: 4 kg\nhome: [0, 0.3, 1.6, 0, 1.24, 0]\nsensor: flange\n"


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    path = tmp_path / "keys.yaml"
    path.write_text(KEYS)
    return path


def outcome(folder: Path, name: str) -> str:
    """What the package's own test of its kinematics and contract says; its scenario is run elsewhere."""
    plain = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--rootdir", folder, "-k", "contract or kinematics")
    environment = {**os.environ, "PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pytest", *plain, folder / "tests" / f"test_{name}.py"]
    done = subprocess.run(list(map(str, command)), cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return done.stdout


@pytest.mark.heavy
def test_a_package_of_an_arm_and_its_hand_passes_its_own_test(run: Run, keys: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    files = ("--from", DATA / "six.urdf", "--gripper", DATA / "linked_hand.xml")
    done = run("new", "robot", "made_arm", *files, "--keys", keys, "--out", out)
    assert done.code == 0, done.err
    assert "found: six.urdf: 6 joints" in done.out
    assert "found: linked_hand.xml: a hand that close closes" in done.out
    assert "to check: it grips with 62 N at half its opening" in done.out
    assert "2 passed" in outcome(out, "made_arm")


def test_what_is_missing_is_said_and_nothing_is_written(run: Run, keys: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    cases = {
        ("--from", DATA / "six.urdf"): "state 'payload' as the data sheet does",
        ("--from", DATA / "nowhere.urdf", "--keys", keys): "there is no robot file",
        ("--from", DATA / "six.urdf", "--keys", tmp_path / "nowhere.yaml"): "cannot be read",
        ("--from", DATA / "six.urdf", "--gripper", DATA / "six.urdf", "--keys", keys): "drives move the hand",
        ("--keys", keys): "--from FILE",
    }
    for arguments, said in cases.items():
        done = run("new", "robot", "made_arm", *arguments, "--out", out)
        assert done.code == 2
        assert said in done.err
        assert not out.exists()
    assert run("new", "task", "made_task", "--from", DATA / "six.urdf").code == 2


def test_what_a_model_does_not_name_stays_where_it_is(tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    for name, text in {
        "arm.urdf": '<mesh filename="package://arm/link.obj"/>', "arm/link.obj": "mtllib link.mtl", "arm/link.mtl": "map_Kd skin.png",
        "skin.png": "", "LICENSE": "", "other.urdf": "", "arm/README.md": "", "arm/arm.urdf": "",
    }.items():  # fmt: skip
        (tmp_path / name).write_text(text)
    needed = [p.relative_to(tmp_path).as_posix() for p in _needed(tmp_path / "arm.urdf")]
    assert needed == ["arm.urdf", "LICENSE", "arm/link.obj", "arm/link.mtl", "skin.png"]
