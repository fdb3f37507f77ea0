"""The URScript backend: its text says what the program says, and nothing else."""

from __future__ import annotations

import re

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Fallback,
    ForceMove,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Repeat,
    Section,
    SetGripper,
    SetPayload,
    Wait,
    ZeroSensor,
)
from cramlite.model.program.program import Snapshot
from cramlite.plugin import UserError
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.backends.urscript.literals import number
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.simulator import MujocoSimulator
from cramlite_plugins.ur_controller.urscript.parser import parse

DOWN = Pose.from_axes((0.5, 0.1, 0.3), (0, 0, -1), (1, 0, 0))
STEPS: tuple[AnyStep, ...] = (
    MoveJoints(path=(UR5E.home,), speed=1.0, acceleration=2.0, origin="1.Reaching/transfer", comment="above the box"),
    MoveLinear(target=DOWN, speed=0.1, acceleration=0.5, origin="1.Reaching/approach"),
    MoveUntilContact(direction=(0, 0, -1), speed=0.01, force=3, distance=0.05, timeout=10, origin="1.Reaching/touch"),
    ZeroSensor(),
    SetGripper(opening=0.0, speed=0.05, force=50, expect="object", origin="2.Grasping/close"),
    SetPayload(mass=1.2, center=(0, 0, 0.1)),
    ForceMove(
        waypoints=(DOWN, DOWN), frame=Pose(), compliant=(True, False, False, False, False, False), wrench=(0,) * 6,
        limits=(0.02,) * 6, speed=0.02, force_limit=30, timeout=20, origin="2.Grasping/pull",
    ),
    Wait(duration=0.5),
)  # fmt: skip


def program(*steps: AnyStep) -> Program:
    return Program(
        name="fetch", robot="arm", robot_type="ur5e", tcp=UR5E.gripper.tcp, start=UR5E.home, steps=steps,
        sections=(Section("1.Reaching", "reach for 'box'", 0, 4), Section("2.Grasping", "grasp 'box'", 4, len(steps))),
        snapshots=(Snapshot("box", DOWN, "known from the scenario", 1.5),), mass=0.925, center=(0, 0, 0.055),
    )  # fmt: skip


def test_the_text_is_one_program_and_always_the_same() -> None:
    one, two = emit(program(*STEPS), UR5E), emit(program(*STEPS), UR5E)
    assert one == two
    assert one.text.startswith("def fetch():\n")
    assert one.text.endswith("\nend\n")
    assert parse(one.text).name == "fetch"
    assert one.text != emit(program(*STEPS[:-1]), UR5E).text


def test_the_header_states_the_preconditions() -> None:
    header = emit(program(*STEPS), UR5E).text.split("# ---- functions")[0]
    snapshot = ("box: p[0.5", "known from the scenario, 1.5 s old")
    for fact in ("ur5e", "robotiq_2f85", "63352", "0.925 kg", "60 N", "3.14", *snapshot):
        assert fact in header


def test_origins_lead_from_lines_to_steps() -> None:
    code = emit(program(*STEPS), UR5E)
    lines = code.text.split("\n")
    found = {origin: lines[line - 1].strip() for line, origin in code.origins.items()}
    assert found["1.Reaching/transfer"].startswith("movej(reaching_1_transfer_joints, ")
    assert found["1.Reaching/touch"].startswith("move_until_contact(")
    assert found["2.Grasping/close"].startswith("move_gripper(255, ")
    assert code.task_of(next(i for i, line in enumerate(lines, 1) if "sleep(0.5" in line)) == "2.Grasping"
    assert code.task_of(1) == ""


def test_motions_lead_to_named_poses() -> None:
    text = emit(program(*STEPS), UR5E).text
    assert "  movel(reaching_1_approach_pose, a=0.5, v=0.1)\n" in text
    assert re.search(r"\n  global reaching_1_approach_pose = p\[0\.5, 0\.1, 0\.3, ", text)
    assert not re.search(r"move[jl]\(p?\[", text), "numbers belong to the names"
    twice = emit(program(STEPS[1], replace(STEPS[1], target=Pose((0.4, 0, 0.3))), STEPS[1]), UR5E).text
    assert [m[1] for m in re.finditer(r"movel\((\w+), ", twice)] == [f"reaching_1_approach_pose{k}" for k in ("", "_2", "")]


def test_sections_name_task_and_objects_once() -> None:
    sections = (Section("1.Reaching", "Reaching: Patient box", 0, 7), Section("2.Waiting", "Waiting", 7, 8))
    text = emit(replace(program(*STEPS), sections=sections), UR5E).text
    assert "\n  # ---- 1.Reaching: Patient box (steps 1 to 7) ----\n" in text
    assert "\n  # ---- 2.Waiting (step 8) ----\n" in text


def test_a_program_carries_the_functions_that_it_calls_and_no_others() -> None:
    def defined(*steps: AnyStep) -> set[str]:
        return set(re.findall(r"^  (?:def|thread) (\w+)", emit(program(*steps), UR5E).text, re.MULTILINE))

    bare = {"abort", "watchdog", "check_start", "set_gripper", "connect_gripper"}
    assert defined(STEPS[1]) == bare
    assert defined(STEPS[4]) == bare | {"fail", "move_gripper"}
    assert defined(STEPS[2]) == bare | {"fail", "contact_move", "move_until_contact"}


def test_every_wait_has_a_time_out() -> None:
    text = emit(program(*STEPS), UR5E).text
    loops = re.findall(r"while (.*):\n((?:.*\n)*?)", text)
    assert loops
    assert text.count("waited > timeout") + text.count("waited < timeout") == 3
    assert "abort(" in text
    assert text.count("halt") >= 2


def test_our_own_text_raises_no_doubt() -> None:
    """The checker that judges everybody's programs: also with control steps, whose functions wait."""
    steps = (*STEPS, Fallback(((Repeat((STEPS[1],), 2),), (Parallel(((STEPS[1],), (STEPS[4],))),))), Monitor((STEPS[1],), time=9.0))
    text = emit(program(*steps), UR5E).text
    assert list(MujocoSimulator().inspect(text)) == []
    endless = text.replace(" and waited < 120.0", "").replace("waited = waited + get_steptime()", "sync()")
    assert any("without a time-out" in said for _, said in MujocoSimulator().inspect(endless))


def test_names_and_robots_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UserError, match="URScript needs a letter"):
        emit(replace(program(), name="fetch from"), UR5E)
    with pytest.raises(UserError, match="'other'"):
        emit(program(), replace(UR5E, type="other"))


def test_text_of_designators_cannot_break_out_of_a_string_or_comment() -> None:
    step = replace(STEPS[2], origin='a"b\nhalt', comment="x\nhalt")
    parse(emit(program(step), UR5E).text)
    assert "\nhalt" not in emit(program(step), UR5E).text


@given(st.floats(-100, 100))
def test_numbers_have_at_most_six_digits_and_no_negative_zero(value: float) -> None:
    text = number(value)
    assert re.fullmatch(r"-?\d+\.(\d|\d{2,6}(?<!0))", text)
    assert text != "-0.0"
    assert abs(float(text) - value) <= 1e-6


@examples(30)
@given(st.lists(st.sampled_from(STEPS), max_size=12))
def test_any_sequence_of_steps_parses(steps: list[AnyStep]) -> None:
    assert parse(emit(program(*steps), UR5E).text).name == "fetch"
