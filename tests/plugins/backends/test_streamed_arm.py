"""The arm of a robot process: how fast it goes where the process takes small deltas only, and when it has arrived."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Robot,
    SetGripper,
    SetPayload,
    ZeroSensor,
    typed_code,
)
from cramlite_plugins.backends.stream.arm import StreamedArm
from cramlite_plugins.backends.stream.messages import Action, Hello, State
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.controller.nominal_arm import NominalArm
from cramlite_plugins.simulation.typed_program.machine import ProgramMachine, load_program

MOST = 0.01, 0.1
HELLO = Hello(protocol=1, robot="ur5e", actions="deltas", rate=20.0, joints=UR5E.home, opening=0.08, most=MOST)
WAY = 0.15


SPRING = replace(HELLO, lag=0.14, inertia=1 / 12.0**2)
"""One that follows as robosuite's OSC_POSE does: 2 / w is 3.3 periods."""


def led(
    swing: Callable[[int], float] = lambda _: 0.0, hello: Hello = HELLO, robot: Robot = UR5E, way: float = WAY
) -> tuple[list[float], StreamedArm]:
    """Lengths of the deltas on a way along x, planned with 1 m/s; the tool is off by ``swing`` [m] along y."""
    nominal, sent = NominalArm(UR5E), list[float]()
    q = np.array(hello.joints)

    def step(action: Action) -> State:
        nonlocal q
        assert action.delta is not None
        sent.append(float(np.linalg.norm(action.delta[:3])))
        x, y, z = np.add(arm.kinematics.forward(arm.q).position, (0.0, swing(len(sent)), 0.0)).tolist()
        found = nominal.follow(Pose((x, y, z), arm.kinematics.forward(arm.q).quaternion), q)
        assert found is not None
        q = found
        return State(joints=tuple(q.tolist()), opening=0.08)

    arm = StreamedArm(robot, hello, step)
    here = arm.kinematics.forward(arm.q)
    x, y, z = here.position
    motion = arm.move_linear(Pose((x + way, y, z), here.quaternion), 1.0, 5.0)
    while arm.motion is motion:
        arm.cycle()
    return sent, arm


def test_a_motion_is_as_fast_as_the_process_takes_it_and_not_faster() -> None:
    sent, _ = led()
    assert max(sent) <= MOST[0] * (1 + 1e-6)
    assert len(sent) <= 1.15 * WAY / MOST[0] + 1  # 15 periods of the largest delta, and what 32 parts of the speed leave
    assert np.mean(sent[1:-1]) > 0.9 * MOST[0]


def test_an_arm_comes_slowly_near_a_singularity_and_leaves_it_at_full_speed() -> None:
    """On a way of 200 mm its smallest singular value falls from .25 to .13; then most of it back again."""
    careful, free = replace(UR5E, conditioning=0.2), replace(HELLO, most=None)
    slowly, arm = led(hello=free, robot=careful, way=-0.2)
    back = replace(free, joints=tuple(arm.q.tolist()))
    assert len(slowly) >= 1.3 * len(led(hello=free, way=-0.2)[0])
    assert len(led(hello=back, robot=careful, way=0.15)[0]) == len(led(hello=back, way=0.15)[0])


@pytest.mark.parametrize(("before", "more"), [(0.001, 0), (0.0005, 0), (-0.0021, 1)])
def test_a_tool_that_only_passes_its_target_has_not_arrived(before: float, more: int) -> None:
    """It is 1 mm off when the motion ends, which would do, and was ``before`` [m] a period ago: 2 mm are left if it goes on like that."""
    count = len(led()[0])
    assert len(led(lambda period: before if period == count - 1 else 0.001 * (period >= count))[0]) == count + more


@pytest.mark.parametrize(("before", "more"), [(0.0004, 1), (0.0009, 0), (0.001, 0), (0.0015, 0), (0.0021, 1)])
def test_a_spring_that_glides_on_has_not_arrived_and_one_that_falls_back_has(before: float, more: int) -> None:
    """It is 1 mm off when the motion ends, and goes on for 3.3 periods as it did in the last one; 2 mm would do."""
    count = len(led(hello=SPRING)[0])
    swing = led(lambda period: before if period == count - 1 else 0.001 * (period >= count), SPRING)
    assert len(swing[0]) == count + more


@pytest.mark.parametrize(
    ("straight", "leads_on", "off", "awaited"),
    [
        (False, False, 0.0, (1, 1)), (False, False, 0.004, (1, 5)), (False, False, 0.006, (5, 5)),
        (True, False, 0.004, (5, 5)), (True, True, 0.004, (1, 5)), (True, True, 0.006, (5, 5)),
    ],
)  # fmt: skip
def test_a_motion_ends_where_the_next_one_leads_on_and_a_program_does_not(
    straight: bool, leads_on: bool, off: float, awaited: tuple[int, int]
) -> None:
    """The tool is ``off`` [m] until the fourth period after the motion's time; 5 mm do in the open, 2 mm at the end."""
    nominal, over = NominalArm(UR5E), [0]
    q = np.array(UR5E.home)

    def step(action: Action) -> State:
        nonlocal q
        over[0] += arm.motion is None
        x, y, z = np.add((here := arm.kinematics.forward(arm.q)).position, (0.0, off * (over[0] < 4), 0.0)).tolist()
        found = nominal.follow(Pose((x, y, z), here.quaternion), q)
        assert found is not None
        q = found
        return State(joints=tuple(q.tolist()), opening=0.08)

    arm = StreamedArm(UR5E, replace(HELLO, most=None), step)
    arm.leads_on, (x, y, z) = leads_on, (here := arm.kinematics.forward(arm.q)).position
    goal = Pose((x + 0.05, y, z), here.quaternion)
    motion = arm.move_linear(goal, 0.5, 1.0) if straight else arm.move_joints(np.array(UR5E.home) + 0.05, 1.0, 2.0)
    while arm.motion is motion:
        arm.cycle()
    in_the_open = over[0]
    while not arm.settled():
        arm.cycle()
    assert (in_the_open, over[0]) == awaited


def test_lines_lead_on_to_transfers_and_guarded_motions_and_a_payload_takes_no_time() -> None:
    """What each step of a program finds of what follows it, and how many actions the whole takes."""
    arm = StreamedArm(UR5E, replace(HELLO, most=None), lambda _: State(joints=tuple(arm.q.tolist()), opening=0.08))
    here = arm.kinematics.forward(arm.q)
    up, go = MoveLinear(here, 0.1, 0.5, UR5E.home), MoveJoints((UR5E.home,), 1.0, 2.0)
    feel = MoveUntilContact((0.0, 0.0, -1.0), 0.02, 3.0, 0.002, 5.0, "any", UR5E.home)
    both, payload = Parallel(((SetGripper(0.08, 0.1, 30.0),), (go,))), SetPayload(1.0, (0.0, 0.0, 0.0))

    def played(*steps: AnyStep) -> tuple[list[bool], int]:
        text = typed_code(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, steps, ())).text
        machine, seen, count = ProgramMachine(load_program(text, UR5E), arm, lambda _: None), list[bool](), 0
        while not machine.finished:
            line = machine.main_line
            machine.cycle()
            if machine.main_line != line:
                seen.append(arm.leads_on)
            arm.cycle()
            count += 1
        return seen, count

    assert played(up, go, up, up)[0] == [True, False, False, False]
    assert played(up, both)[0][0]
    assert played(up, up, feel, up)[0] == [False, True, False, False]
    assert played(up, payload, up)[1] == played(up, up)[1]


@pytest.mark.parametrize(("hello", "periods"), [(HELLO, 6), (replace(HELLO, settling=0.05), 1), (replace(HELLO, settling=0.0), 1)])
def test_before_a_tare_the_arm_stands_still_for_as_long_as_its_force_takes_to_settle(hello: Hello, periods: int) -> None:
    arm, count = StreamedArm(UR5E, hello, lambda _: State(joints=UR5E.home, opening=0.08, wrench=(0.0, 0.0, 7.0, 0.0, 0.0, 0.0))), 0
    text = typed_code(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (ZeroSensor(),), ())).text
    machine = ProgramMachine(load_program(text, UR5E), arm, lambda _: None)
    machine.cycle()  # the start
    arm.cycle()
    while not machine.finished:
        machine.cycle()
        arm.cycle()
        count += 1
    assert (count - 1, arm.force()) == (periods, 0.0)
