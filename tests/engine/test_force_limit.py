"""The force limit of a program: the scenario's where it sets one, else the robot's; said with its source, and refused where low."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from cramlite import Budget, Engine, Solution, Trace, find_scenario, read_scenario
from cramlite.engine.real_arm.preflight import Flight, checks
from cramlite.model import Program, read_program, write_program
from cramlite.plugin import UserError
from cramlite_plugins.robots.ur5e import UR5E

CAREFUL = """
from cramlite.plugin import hookimpl
from cramlite.model import replace
from cramlite_plugins.robots.ur5e import UR5E

@hookimpl
def robots():
    return [replace(UR5E, type="careful", force_limit=45.0)]
"""
PROGRAM = Program("p", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (), ())


def resolved(folder: Path, name: str, line: str, robot: str = "ur5e") -> tuple[Solution | None, Trace]:
    """A shipped scenario with one more line, and perhaps another robot: the first program within one proof, and the trace."""
    path, trace, plugin = folder / "limited.yaml", Trace(), folder / "careful_arm.py"
    plugin.write_text(CAREFUL)
    path.write_text(find_scenario(name).read_text().replace("robot: {type: ur5e}", f"{line}\nrobot: {{type: {robot}}}", 1))
    engine = Engine(files=[plugin])
    return next(engine.resolve(read_scenario(path), trace=trace, budget=Budget(proofs=1)), None), trace


def limit_of(solution: Solution) -> tuple[float, str]:
    """What preflight holds the highest force against, and whose that is."""
    candidate = solution.candidate
    assert candidate.rollout is not None and candidate.code is not None
    shown = checks(Flight(candidate.robot, candidate.code, candidate.rollout, candidate.program), {})
    return next((c.limit, c.source) for c in shown if c.name == "tool force")


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("line", "robot", "limit", "source"),
    [
        ("", "ur5e", 60.0, "of robot 'ur5e'"),
        ("", "careful", 45.0, "of robot 'careful'"),
        ("force_limit: 40 N", "careful", 40.0, "of the scenario"),
        ("force_limit: 70.5", "ur5e", 70.5, "of the scenario"),
    ],
)
def test_the_scenarios_limit_else_the_robots(line: str, robot: str, limit: float, source: str, tmp_path: Path) -> None:
    solution, _ = resolved(tmp_path, "grasp_one_thing", line, robot)
    assert solution is not None
    program = solution.candidate.program
    assert (program.force_limit, program.force_limit_source) == (limit, source)
    assert f"global force_limit = {limit} " in solution.code
    assert limit_of(solution) == (limit, source)


@pytest.mark.heavy
def test_who_set_a_limit_changes_no_text(tmp_path: Path) -> None:
    own, _ = resolved(tmp_path, "grasp_one_thing", "")
    same, _ = resolved(tmp_path, "grasp_one_thing", "force_limit: 60 N")
    assert own is not None and same is not None
    assert own.code == same.code
    assert limit_of(own) == (60.0, "of robot 'ur5e'") and limit_of(same) == (60.0, "of the scenario")


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("name", "low", "said", "enough"),
    [
        ("grasp_one_thing", "0.7 N", r"force 0\.7\d* N > 0\.7 N; .*limit 0\.7 N of the scenario", "3 N"),
        ("sliding_gripper", "24 N", r"force limit of 25 N is not in 0 \.\. 24 N, the program's \(of the scenario\)", "25 N"),
    ],
)
def test_a_low_limit_is_why_a_program_is_refused(name: str, low: str, said: str, enough: str, tmp_path: Path) -> None:
    solution, trace = resolved(tmp_path, name, f"force_limit: {low}")
    assert solution is None
    assert any(re.search(said, e.reason) for e in trace.entries if e.outcome == "failed")
    solution, _ = resolved(tmp_path, name, f"force_limit: {enough}")
    assert solution is not None


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("0 N", "greater than 0"),
        ("-5 N", "greater than 0"),
        ("151 N", "less than or equal to 150"),
        ("3 kg", "'kg' is not a unit of force"),
        ("low", "'low' is not a force"),
        (".nan", "'nan' is not a force"),
    ],
)
def test_wrong_limits_are_refused_with_their_line(written: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=rf"limited\.yaml:\d+: 'force_limit'.*{said}"):
        resolved(tmp_path, "grasp_one_thing", f"force_limit: {written}")


def test_a_typed_programs_text_says_a_limit_that_is_not_the_robots() -> None:
    scenarios = replace(PROGRAM, force_limit=40.0, force_limit_of="scenario")
    assert "force_limit_of" not in write_program(PROGRAM)
    assert '"force_limit_of": "scenario"' in write_program(scenarios)
    for program in (PROGRAM, scenarios):
        assert read_program(write_program(program)).program == program
    with pytest.raises(UserError, match="force_limit_of is \"moon\"; it should be one of 'robot', 'scenario'"):
        read_program(write_program(scenarios).replace('"scenario"', '"moon"'))
