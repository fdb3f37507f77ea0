"""Both scenarios on every robot, by changing the scenario's line ``robot:``, and what no change of robot can do.

The UR5e is in test_fetch_from_hanger and test_hang_onto_hanger; tests/benchmarks/robots.py has more seeds.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

SCENARIOS = Path(__file__).parents[1] / "scenarios"
LINE = "robot: {type: ur5e}"
ONCE = "\nbudget: {proofs: 1, sequences: 1}"


def variant(folder: Path, scenario: str, robot: str, *changes: tuple[str, str]) -> Path:
    """A shipped scenario with another robot, and perhaps more replaced; each replacement must change something."""
    text = (SCENARIOS / f"{scenario}.yaml").read_text()
    demonstration = ("demonstration: ", f"demonstration: {SCENARIOS}/")
    for old, new in ((LINE, LINE.replace("ur5e", robot)), demonstration, *changes):
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "variant.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("robot", ["ur5", "fr3"])
@pytest.mark.parametrize(
    ("scenario", "end"),
    [("fetch_from_hanger", "'coffee' rests in 'basket'"), ("hang_onto_hanger", "'coffee' hangs on 'hook'")],
)
def test_the_scenario_runs_on_another_robot(
    scenario: str, end: str, robot: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    done = run("resolve", variant(tmp_path, scenario, robot), "--out", tmp_path / "run", "--no-report", "--json")
    assert done.code == 0, done.err
    findings = json.loads(done.out)["findings"]
    assert end in [f["reason"] for f in findings]
    assert all(f["passed"] for f in findings)
    suffix = {"ur5": ".script", "fr3": ".json"}[robot]
    assert (tmp_path / "run" / f"program{suffix}").is_file()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ((("size: [60 mm, 50 mm, 100 mm]", "size: [82 mm, 81 mm, 100 mm]"),), r"\(81 mm, 82 mm|81 mm\) fits the gripper's 7\d mm"),
        (
            (("at: {position: [0.87, 0, 0.45], yaw: 180 deg}", "at: {position: [1.30, 0, 0.45], yaw: 180 deg}"),),
            r"nearest point at 1\.20 m > 0\.96 m reach of arm 'fr3' with gripper",
        ),
    ],
)  # fmt: skip
def test_what_the_seven_axis_arm_cannot_do_is_refused_with_numbers(
    changes: tuple[tuple[str, str], ...], said: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    once = (LINE.replace("ur5e", "fr3"), LINE.replace("ur5e", "fr3") + ONCE)
    scenario = variant(tmp_path, "fetch_from_hanger", "fr3", *changes, once)
    done = run("resolve", scenario, "--out", tmp_path / "run", "--no-report")
    assert done.code == 1, done.err
    assert re.search(said, done.err), done.err
