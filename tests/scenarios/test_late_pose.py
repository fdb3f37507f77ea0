"""Parametric programs: the block moves between planning and execution."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT
from msgspec.structs import replace

from cramlite import Engine, Solution, read_scenario
from cramlite.engine.late_poses import parametric
from cramlite.engine.proof.proof import prove
from cramlite.model import MoveJoints, MoveLinear, Pose, Rollout
from cramlite.plugin import UserError
from cramlite_plugins.backends import typed_json
from cramlite_plugins.backends.rapid import emit as rapid
from cramlite_plugins.backends.ur_rtde import emit as ur_rtde

SCENARIO = ROOT / "scenarios" / "late_pose.yaml"


class Planned:
    """The scenario, resolved once."""

    def __init__(self) -> None:
        self.engine = Engine()
        self.solution: Solution = next(self.engine.resolve(read_scenario(SCENARIO)))

    def run(self, dx: float = 0.0, dy: float = 0.0, yaw: float = 0.0, name: str = "block") -> Rollout:
        """Its text in a world in which the block was moved since [m, rad]."""
        knowledge, world = self.engine.knowledge, self.solution.setting.world
        pose = world.thing("block").pose
        x, y, z = pose.position
        moved = Pose((x + dx, y + dy, z), (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)))
        text = self.solution.code.replace('ask_pose("block"', f'ask_pose("{name}"')
        return knowledge.simulator.execute(text, world.moved({"block": moved}), knowledge.robots, mount="arm", seed=1)


@pytest.fixture(scope="module")
def planned() -> Planned:
    return Planned()


@pytest.mark.heavy
def test_it_was_tried_at_the_edge_of_what_is_declared(planned: Planned) -> None:
    found = [f for f in planned.solution.verdict.findings if f.validator == "late_pose"]
    assert len(found) == 4 and all(f.passed for f in found)
    assert "'block' +15, +0 mm and +8 deg from its planned pose" in found[0].reason


@pytest.mark.heavy
def test_what_does_not_work_at_the_edge_of_what_is_declared_is_refused(planned: Planned) -> None:
    """400 mm off the block is out of reach."""
    made, setting = planned.solution.candidate, planned.solution.setting
    late = tuple(replace(one, tolerance=(0.4, 0.0)) for one in made.program.late)
    wide = replace(made, program=replace(made.program, late=late), code=None, rollout=None, episode=None)
    _, verdict = prove(wide, planned.engine.knowledge, setting.backend, 0)
    assert not verdict.passed and [f.validator for f in verdict.objections] == ["late_pose"]
    assert "with 'block' +400, +0 mm and +0 deg from its planned pose: " in verdict.reason


@pytest.mark.heavy
@pytest.mark.parametrize(("dx", "dy", "yaw"), [(0.012, 0.0, 0.1), (-0.008, -0.008, -0.1)])
def test_inside_the_tolerance_it_succeeds(planned: Planned, dx: float, dy: float, yaw: float) -> None:
    done = planned.run(dx, dy, yaw)
    assert done.outcome == "finished", done.reason
    end = done.poses["block"][-1]
    assert end[1] < -0.2 and end[2] > 0.15  # on the shelf


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"dx": 0.03}, r"block is 0\.0(29|30|31)\d* m from where it was planned, more than 0\.016 m"),
        ({"yaw": 0.3}, r"block is turned by 0\.\d+ rad, more than 0\.149\d* rad"),
        ({"name": "brick"}, "the perception server does not see brick"),
    ],
)
def test_outside_of_it_the_program_stops_before_it_moves_and_says_why(planned: Planned, how: dict[str, Any], said: str) -> None:
    done = planned.run(**how)
    assert done.outcome == "halted"
    assert re.search(said, done.reason), done.reason
    assert done.joints.max(axis=0) == pytest.approx(done.joints.min(axis=0), abs=5e-3)  # it sags


def test_motions_to_the_block_follow_it_and_others_do_not(planned: Planned) -> None:
    steps = planned.solution.program.steps
    relative = [s for s in steps if s.relative]
    assert {s.origin.split("/")[0] for s in relative} == {"1.Grasping", "2.PickingUp"}
    assert all(isinstance(s, MoveLinear) for s in relative)
    first = next(k for k, s in enumerate(steps) if isinstance(s, MoveJoints))
    assert steps[first + 1].relative == "block" and steps[first + 1].origin == steps[first].origin


def test_what_is_never_grasped_or_unknown_cannot_be_late(planned: Planned) -> None:
    candidate = planned.solution.candidate
    with pytest.raises(UserError, match="'shelf' is never grasped"):
        parametric(candidate, {"shelf": (0.01, 0.0)})
    with pytest.raises(UserError, match="no task of the program is about this thing"):
        parametric(candidate, {"moon": (0.01, 0.0)})


def test_a_scenario_may_only_name_what_can_be_moved(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(SCENARIO.read_text().replace("thing: block, position", "thing: tabel, position"))
    with pytest.raises(UserError, match=r"s.yaml:\d+: no thing 'tabel' that can be moved"):
        Engine().setting(read_scenario(path))


def test_other_languages_refuse_late_poses(planned: Planned) -> None:
    program = planned.solution.program
    robot = planned.solution.candidate.robot
    with pytest.raises(UserError, match="take the backend urscript"):
        ur_rtde.emit(program, robot)
    with pytest.raises(UserError, match="RAPID"):
        rapid.emit(program, robot, forces=False)
    text = typed_json.TypedJson().emit(program, robot).text
    knowledge = planned.engine.knowledge
    with pytest.raises(UserError, match="asks for poses when it runs"):
        knowledge.simulator.execute(text, planned.solution.setting.world, knowledge.robots, mount="arm", seed=0)
