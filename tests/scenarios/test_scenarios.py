"""Every shipped scenario resolves, and its program grounds the same objects every time: golden files."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

GOLDEN = {
    "place_on_shelf": (
        "Grasping -> PickingUp -> Placing -> ParkingArms",
        {"block": "block", "floor": "floor", "shelf": "shelf"},
    ),
    "grasp_one_thing": ("Grasping", {"something": "coffee"}),
    "take_off_hanger_tasks": (
        "Grasping -> ExtractHoleFromPeg -> Ungrasping -> Retracting -> ParkingArms",
        {"basket": "basket", "hook/peg": "hook/peg", "tea": "tea"},
    ),
}


def resolve(scenario: str | Path, out: Path) -> subprocess.CompletedProcess[str]:
    command = [
        sys.executable,
        "-m",
        "cramlite",
        "resolve",
        str(scenario),
        "--out",
        str(out),
        "--no-report",
        "--json",
    ]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", sorted(GOLDEN))
def test_it_is_proven(name: str, tmp_path: Path) -> None:
    done = resolve(name, tmp_path / "run")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    plan, objects = GOLDEN[name]
    assert summary["plan"] == plan
    assert {k: v for k, v in summary["objects"].items() if k in objects} == objects
    assert all(f["passed"] for f in summary["findings"])


def test_a_shelf_that_is_too_high_is_refused(tmp_path: Path) -> None:
    shipped = Path(__file__).parents[2] / "scenarios" / "place_on_shelf.yaml"
    scenario = tmp_path / "high.yaml"
    scenario.write_text(shipped.read_text().replace("[0.45, -0.35, 0.15]", "[0.45, -0.35, 1.05]"))
    done = resolve(scenario, tmp_path / "run")
    assert done.returncode == 1, done.stderr
    assert "m reach of arm 'ur5e' with gripper" in done.stderr
