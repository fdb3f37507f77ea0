"""Drawers, a knob and an oven's door that somebody else made: which end is closed, and programs that are proven on them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, NoSolution, Trace, read_scenario
from cramlite.model import ImportedScene
from cramlite.planning.diagnosis import failure_text
from cramlite_plugins.simulation.scenes.reader import read_scene

SCENE = Path(__file__).parents[1] / "plugins" / "simulation" / "scenes_data" / "joints.xml"


def _read(keyframe: str) -> ImportedScene:
    scene = read_scene(SCENE, {}, keyframe)
    assert scene is not None
    return scene


@pytest.mark.parametrize("keyframe", ["closed", "open"])
def test_the_closed_end_is_found_wherever_a_joint_starts(keyframe: str) -> None:
    things = {t.name: t for t in _read(keyframe).things}
    ranges = {n: (t.joint.lower, t.joint.upper) for n, t in things.items() if t.joint is not None}
    assert ranges == {
        "cabinet_top": (-0.01, 0.16), "cabinet_middle": (-0.01, 0.16), "cabinet_bottom": (-0.01, 0.16), "stove_button": (-0.005, 2.1),
        "oven_door": (0.0, 2.09),
    }  # fmt: skip
    assert all(t.feature("cram:Handle") for t in things.values() if t.joint)
    assert any("'top_level' is closed at its upper end" in n and "least room" in n for n in things["cabinet_top"].notes)
    assert any("'button' is closed at its lower end: its zero is there" in n for n in things["stove_button"].notes)


def _attempt(goal: str, keyframe: str, scene: Path = SCENE, proofs: int = 3) -> str:
    """Resolve a goal: "proven", or why not."""
    spec = {
        "scenario": "joints", "robot": {"type": "ur5e"}, "world": {"file": str(scene), "keyframe": keyframe}, "goal": [goal],
        "budget": {"sequences": 2, "proofs": proofs},
    }  # fmt: skip
    scenario, engine, trace = read_scenario(spec), Engine(), Trace()
    try:
        solution = next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0), trace=trace), None)
    except NoSolution as refused:
        return str(refused)
    return "proven" if solution else failure_text(trace, engine.registry.faults)


def _stuck(folder: Path, joint: str) -> Path:
    """The scene with a joint that nobody moves."""
    path = folder / "joints.xml"
    path.write_text(SCENE.read_text().replace(f'name="{joint}"', f'name="{joint}" frictionloss="300"'))
    return path


GOALS = {
    "cabinet_top closed": ("open", "top_level"), "cabinet_bottom open": ("closed", "bottom_level"),
    "stove_button turned on": ("closed", "button"), "stove_button turned off": ("open", "button"),
    "oven_door closed": ("open", "door"),
}  # fmt: skip


@pytest.mark.heavy
@pytest.mark.parametrize("goal", GOALS)
def test_a_goal_about_a_joint_is_proven(goal: str) -> None:
    assert _attempt(goal, GOALS[goal][0]) == "proven"


@pytest.mark.heavy
@pytest.mark.parametrize("goal", ["cabinet_top closed", "cabinet_bottom open", "stove_button turned on"])
def test_a_goal_about_a_joint_that_is_stuck_is_not(goal: str, tmp_path: Path) -> None:
    keyframe, joint = GOALS[goal]
    said = _attempt(goal, keyframe, _stuck(tmp_path, joint), proofs=1)
    assert said != "proven" and ("force" in said or "does not hold" in said), said
