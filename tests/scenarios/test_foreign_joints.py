"""Drawers, a knob and an oven's door that somebody else made: which end is closed, and programs that are proven on them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, NoSolution, Solution, Trace, read_scenario
from cramlite.cli.main import main
from cramlite.model import ImportedScene, StatedJoint, Thing
from cramlite.planning.failure import failure_text
from cramlite_plugins.imports.scenes.reader import read_scene

SCENE = Path(__file__).parents[1] / "plugins" / "imports" / "scenes_data" / "joints.xml"


def _read(keyframe: str) -> ImportedScene:
    scene = read_scene(SCENE, {}, keyframe, {})
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


def _stated(joints: dict[str, StatedJoint], keyframe: str = "closed") -> dict[str, Thing]:
    scene = read_scene(SCENE, {}, keyframe, joints)
    assert scene is not None
    return {t.name: t for t in scene.things}


def test_the_scenario_says_which_end_is_closed_and_what_the_range_is() -> None:
    found = {t.name: t for t in _read("closed").things}
    things = _stated({"cabinet_top": StatedJoint("lower"), "stove*": StatedJoint("upper", "hinge", (0.0, 1.5))})
    drawer, knob, own = (things["cabinet_top"].joint, things["stove_button"].joint, found["cabinet_top"].joint)
    assert drawer is not None and knob is not None and own is not None
    assert (drawer.lower, drawer.upper, drawer.value) == (-own.upper, -own.lower, -own.value)
    assert drawer.pose.rotate((0, 0, 1)) == pytest.approx(-own.pose.rotate((0, 0, 1)))
    assert (knob.lower, knob.upper) == (-1.5, 0.0)
    assert "joint 'top_level' is closed at its lower end: the scenario says so" in things["cabinet_top"].notes
    assert "joint 'button' goes from 0 to 1.5 rad: the scenario says so, the file -0.005 to 2.1" in things["stove_button"].notes
    assert things["cabinet_bottom"].joint == found["cabinet_bottom"].joint


WRONG = {
    "drawer*: {closed: upper}": "no jointed thing of 'joints.xml' is called 'drawer*'",
    "cabinet_top: {closed: shut}": "'lower' or 'upper'",
    "cabinet_top: {turns: [0, 1]}": "'top_level' slides, and 'slides' says its range in m",
    "cabinet_top: {slides: [200 mm, 100 mm]}": "the lower one first",
    "cabinet_top: {slides: [0, 90 deg]}": "'deg' is not a unit of length",
    "cabinet_top: {slides: [-100 mm, -50 mm]}": "it starts at",
    "cabinet_top: {}": "the joint's entry is empty",
    "cabinet_top: {slides: [0, 1], turns: [0, 1]}": "one of the two",
    "cabinet_top: {open: upper}": "unknown key 'open'",
}


@pytest.mark.parametrize("joint", WRONG)
def test_what_is_wrong_in_a_stated_joint_is_said_where_it_stands(
    joint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "wrong.yaml"
    world = f"world:\n  file: {SCENE}\n  keyframe: closed\n  joints:\n    {joint}\n"
    path.write_text(f"scenario: wrong\nrobot: {{type: ur5e}}\ntasks: [ParkingArms]\n{world}")
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert WRONG[joint] in said and "Traceback" not in said, said
    assert "wrong.yaml:" in said or "joints.xml:1" in said, said


def _resolve(goal: str, keyframe: str, trace: Trace, scene: Path = SCENE, proofs: int = 3) -> Solution | None:
    """Resolve a goal."""
    spec = {
        "scenario": "joints", "robot": {"type": "ur5e"}, "world": {"file": str(scene), "keyframe": keyframe}, "goal": [goal],
        "budget": {"sequences": 2, "proofs": proofs},
    }  # fmt: skip
    scenario, engine = read_scenario(spec), Engine()
    return next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0), trace=trace), None)


def _attempt(goal: str, keyframe: str, scene: Path = SCENE, proofs: int = 3) -> str:
    """Resolve a goal: "proven", or why not."""
    trace = Trace()
    try:
        return "proven" if _resolve(goal, keyframe, trace, scene, proofs) else failure_text(trace, ())
    except NoSolution as refused:
        return str(refused)


def _stuck(folder: Path, joint: str) -> Path:
    """The scene with a joint that nobody moves."""
    path = folder / "joints.xml"
    path.write_text(SCENE.read_text().replace(f'name="{joint}"', f'name="{joint}" frictionloss="300"'))
    return path


GOALS = {
    "cabinet_top closed": ("open", "top_level"), "cabinet_bottom open": ("closed", "bottom_level"),
    "stove_button turned on": ("closed", "button"),
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


@pytest.mark.heavy
def test_a_knob_that_is_turned_off_stays_at_its_stop() -> None:
    """It has 1 kg m2 and little damping: let go while it turned, or before its stop, it glided on by 8 mrad; others count 5 mrad as on."""
    solution = _resolve("stove_button turned off", "open", Trace())
    assert solution is not None and solution.candidate.rollout is not None
    assert solution.candidate.rollout.values["stove_button"][-50:] == pytest.approx(-0.005, abs=0.0005)
