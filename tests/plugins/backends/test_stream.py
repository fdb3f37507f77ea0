"""Programs streamed to a robot process: what succeeds there, what fails there, and what is no answer."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, Run

from cramlite.model import (
    Deviation,
    Drive,
    MoveJoints,
    MoveUntilContact,
    Notice,
    Program,
    Readings,
    Rollout,
    SetGripper,
    replace,
    typed_code,
)
from cramlite.plugin import UserError
from cramlite_plugins.backends.stream.backend import Stream
from cramlite_plugins.backends.stream.messages import Action, Hello, State
from cramlite_plugins.backends.stream.run import drive, stream
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.typed_program.machine import load_program

HELPERS = ROOT / "tests" / "helpers"
AWAY = (*UR5E.home[:5], UR5E.home[5] + 0.3)
HALF = SetGripper(opening=0.04, speed=0.1, force=30.0, expect="none", origin="1.Opening/half")
GUARDED = MoveUntilContact(direction=(0, 0, -1), speed=0.02, force=3, distance=0.02, timeout=10, origin="2.Placing/lower")
PROGRAM = Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (MoveJoints((AWAY,), 1.0, 2.0, origin="1.Moving/away"), HALF), ())


def arm(*options: object, home: tuple[float, ...] = UR5E.home, robot: str = "ur5e") -> list[str]:
    return [sys.executable, str(HELPERS / "perfect_arm.py"), robot, json.dumps(home), "0.085", *map(str, options)]


def streamed(*options: object, program: Program = PROGRAM, patience: float = 10.0) -> Rollout:
    return drive(typed_code(program).text, UR5E, arm(*options), patience)


# In a world of its own


@pytest.fixture(scope="module")
def placed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run directory with a proven program: pick a block up and place it on a shelf."""
    from cramlite.cli.main import main

    out = tmp_path_factory.mktemp("placed") / "run"
    scenario = ROOT / "scenarios" / "tasks" / "placing.yaml"
    assert main(["resolve", str(scenario), "--backend", "stream", "--no-report", "--out", str(out)]) == 0
    return out


def on(placed: Path, result: Path, *options: str) -> str:
    return " ".join([sys.executable, str(HELPERS / "robot_process.py"), str(placed), "--result", str(result), *options])


@pytest.mark.heavy
@pytest.mark.parametrize("actions", ["joints", "deltas"])
def test_a_proven_pick_and_place_succeeds_on_a_robot_process(placed: Path, tmp_path: Path, run: Run, actions: str) -> None:
    done = run("execute", placed / "program.json", "--on", on(placed, tmp_path / "result", "--actions", actions), "--out", tmp_path / "out")
    assert done.code == 0, done.err
    assert "PuttingDown/lower: contact" in done.out  # it felt the shelf
    x, y, z = json.loads((tmp_path / "result").read_text())["block"]
    assert abs(x - 0.45) < 0.12 and abs(y + 0.35) < 0.12 and z == pytest.approx(0.2, abs=0.003)  # it stands on the shelf
    assert json.loads((tmp_path / "out" / "execution.json").read_text())["outcome"] == "finished"


@pytest.mark.heavy
def test_a_thing_that_was_taken_away_is_missed(placed: Path, tmp_path: Path, run: Run) -> None:
    done = run("execute", placed / "program.json", "--on", on(placed, tmp_path / "result", "--take", "block", "--at", "5"))
    assert done.code == 1 and "no object between the fingers" in done.err


@pytest.mark.heavy
def test_a_robot_that_feels_nothing_is_refused_before_it_moves(placed: Path, tmp_path: Path, run: Run) -> None:
    done = run("execute", placed / "program.json", "--on", on(placed, tmp_path / "result", "--numb"))
    assert done.code == 2 and "reports none" in done.err and "lower" in done.err


# What is sent


def test_a_robot_goes_where_the_program_says_and_its_hand_stays_half_open() -> None:
    ran = streamed()
    assert ran.outcome == "finished", ran.reason
    assert np.allclose(ran.joints[-1], AWAY, atol=1e-9) and ran.opening[-1] == pytest.approx(0.04, abs=0.002)
    assert np.allclose(np.diff(ran.times), 0.05)
    assert np.abs(np.diff(ran.joints, axis=0)).max() <= 0.05 * 1.0 + 1e-9  # 1 rad/s


def test_a_motion_out_of_a_joints_range_is_not_sent() -> None:
    far = (*UR5E.home[:5], UR5E.limits[5][1] + 0.1)
    ran = streamed(program=Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (MoveJoints((far,), 3.0, 9.0),), ()))
    assert ran.outcome == "protective stop" and "outside" in ran.reason
    assert ran.joints[:, 5].max() <= UR5E.limits[5][1]


def test_an_arm_that_does_not_follow_is_stopped() -> None:
    turn = MoveJoints(((UR5E.home[0] + 1.0, *UR5E.home[1:]),), 1.0, 2.0)
    ran = streamed("stuck", 1, program=Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (turn,), ()))
    assert ran.outcome == "protective stop" and "does not follow" in ran.reason


def test_a_robot_that_stops_says_why() -> None:
    ran = streamed("stop", 3)
    assert ran.outcome == "protective stop" and "the emergency stop is pressed" in ran.reason


def test_a_robot_elsewhere_does_not_start() -> None:
    ran = drive(typed_code(PROGRAM).text, UR5E, arm(home=AWAY))
    assert ran.outcome == "halted" and "the program starts from" in ran.reason


def test_a_platform_and_another_robot_are_refused() -> None:
    legs = Drive(legs=((1.0, 0.0, 0.0),), speed=0.1, acceleration=0.1, turn_speed=0.1, turn_acceleration=0.1)
    with pytest.raises(UserError, match="drives a platform"):
        Stream().emit(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (legs,), ()), UR5E)
    with pytest.raises(UserError, match="is not one for 'fr3'"):
        Stream().emit(PROGRAM, FR3)


# What follows as a spring does


class Spring:
    """An arm whose joints are critically damped springs: they hold an action for its period, as an operational space controller does.

    Args:
        told: whether it says what its inertia does.
    """

    name = "spring"
    frequency, rate, parts = 12.0, 20.0, 50  # of the springs [rad/s], of actions [Hz], physics steps of one

    def __init__(self, told: bool) -> None:
        self.told, self.q, self.speed, self.seen = told, np.array(UR5E.home), np.zeros(6), []

    def hello(self) -> Hello:
        w = self.frequency
        return Hello(
            protocol=1, robot="ur5e", actions="joints", rate=self.rate, lag=2 / w - 0.5 / self.rate, inertia=self.told / w**2,
            joints=UR5E.home, opening=0.085, wrench=(0.0,) * 6,
        )  # fmt: skip

    def step(self, action: Action) -> State:
        assert action.joints is not None
        for _ in range(self.parts):
            pull = self.frequency**2 * (np.array(action.joints) - self.q) - 2 * self.frequency * self.speed
            self.speed = self.speed + pull / self.rate / self.parts
            self.q = self.q + self.speed / self.rate / self.parts
            self.seen.append(float(self.q[0]))
        return State(joints=tuple(self.q.tolist()), opening=action.opening, wrench=(0.0,) * 6)


@pytest.mark.parametrize(("told", "least", "most"), [(True, -0.005, 0.002), (False, 0.02, 0.1)])
def test_a_spring_that_says_its_inertia_does_not_overshoot(told: bool, least: float, most: float) -> None:
    end = UR5E.home[0] + 1.0
    turn = MoveJoints(((end, *UR5E.home[1:]),), 1.0, 4.0)
    arm = Spring(told)
    loaded = load_program(typed_code(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (turn,), ())).text, UR5E)
    ran = stream(loaded, UR5E, arm)
    assert ran.outcome == "finished", ran.reason
    assert least <= max(arm.seen) - end <= most
    there, goal = (forward(UR5E, np.array(q)) for q in (ran.joints[-1], turn.path[-1]))
    assert there.distance(goal)[0] <= arm.hello().tolerance[0], "the last motion of a program is awaited to its tolerance"


class Falling(Spring):
    """A spring beside a thing that falls by 5 mm a period, until it lies after so many of them."""

    def __init__(self, lies: int) -> None:
        super().__init__(True)
        self.lies, self.steps = lies, 0

    def step(self, action: Action) -> State:
        self.steps += 1
        height = 0.005 * max(0, self.lies - self.steps)
        return replace(super().step(action), poses={"cup": (0.5, 0.0, height, 1.0, 0.0, 0.0, 0.0)})


class Alarm:
    """A watcher that notices something at its third reading."""

    period, seen, last = 0.05, 0, None

    def see(self, readings: Readings) -> Notice | None:
        self.seen += 1
        return Notice(Deviation.ADDED, readings.time, "it is there") if self.seen == 3 else None

    def rest(self, readings: Readings) -> None:
        self.last = readings


@pytest.mark.parametrize(("lies", "least", "most"), [(0, 2, 10), (16, 16, 20), (1000, 20, 24)], ids=["rests", "falls", "falls on"])
def test_an_arm_that_brakes_waits_until_what_is_read_rests(lies: int, least: int, most: int) -> None:
    turn = MoveJoints(((UR5E.home[0] + 1.0, *UR5E.home[1:]),), 1.0, 4.0)
    loaded = load_program(typed_code(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (turn,), ())).text, UR5E)
    arm, alarm = Falling(lies), Alarm()
    ran = stream(loaded, UR5E, arm, alarm)
    assert ran.outcome == "noticed" and least <= arm.steps <= most
    assert np.abs(arm.speed).max() < 0.2, "it stands still"
    assert alarm.last is not None and (alarm.last.poses or {})["cup"].position[2] == pytest.approx(0.005 * max(0, lies - arm.steps))


class Cancelling(Alarm):
    """A watcher that hears at a reading amid the motion that nothing is asked for any more, or sees that something is there."""

    def __init__(self, kind: Deviation) -> None:
        self.kind, self.before = kind, list[Readings]()

    def see(self, readings: Readings) -> Notice | None:
        self.before.append(readings)
        return Notice(self.kind, readings.time, "") if len(self.before) == 12 else None


@pytest.mark.parametrize(("kind", "at_once"), [(Deviation.CANCELLED, True), (Deviation.MOVED, False)])
def test_an_arm_whose_task_is_cancelled_stops_at_once(kind: Deviation, at_once: bool) -> None:
    """It moves at up to 1 rad/s and is a spring: after ten actions it is within 20 mrad; one that brakes goes on by 0.2 rad and more."""
    turn = MoveJoints(((UR5E.home[0] + 1.0, *UR5E.home[1:]),), 1.0, 4.0)
    loaded = load_program(typed_code(Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (turn,), ())).text, UR5E)
    arm, watch = Spring(True), Cancelling(kind)
    ran = stream(loaded, UR5E, arm, watch)
    when = watch.before[-1]
    after = np.array(arm.seen[round(when.time * arm.rate) * arm.parts :][: 10 * arm.parts]) - when.joints[0]
    assert ran.outcome == "noticed" and arm.speed[0] < 0.2
    assert bool(abs(after[-1]) < 0.02 and after.max() < 0.05) is at_once


# What is no answer


@pytest.mark.parametrize(
    ("what", "when", "said"),
    [
        ("dies", 0, "ended with exit code 1: the fieldbus is gone"), ("dies", 4, "ended with exit code 1: the fieldbus is gone"),
        ("hangs", 4, "has not answered for 0.5 s"), ("garbage", 0, "'MOTOR OK', which is no hello message"),
        ("garbage", 4, "'MOTOR OK', which is no state message"), ("bytes", 4, "which is no state message"),
        ("nan", 4, "which is no state message"), ("huge", 4, "no state message"), ("few", 4, "with 1 joints; the robot has 6"),
        ("list", 4, "no state message"), ("long", 4, "no state message"), ("old", 0, "speaks protocol 0, cramlite speaks 1"),
        ("loose", 0, "says a tolerance of 0, which is too small"),
        ("other", 0, "drives a 'another', and the program is for a 'ur5e'"), ("slow", 0, "says a rate of 0 Hz, outside 1 .. 1000"),
    ],
)  # fmt: skip
def test_what_is_no_answer_is_explained(what: str, when: int, said: str) -> None:
    with pytest.raises(UserError) as caught:
        streamed(what, when, patience=0.5)
    assert said in str(caught.value) and "drive_a_robot.md" in str(caught.value) and "\n" not in str(caught.value)


def test_a_robot_that_feels_nothing_cannot_be_guarded() -> None:
    with pytest.raises(UserError, match=r"'2\.Placing/lower' needs the force at the hand"):
        streamed("numb", 0, program=Program("test", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (GUARDED,), ()))


@pytest.mark.parametrize(
    ("text", "command", "said"),
    [
        (typed_code(PROGRAM).text, "no_such_program", "cannot be started"), (typed_code(PROGRAM).text, "", "say the command"),
        (typed_code(PROGRAM).text, "'half", "No closing quotation"), ("def p():\nend\n", "true", "typed program"),
        (typed_code(PROGRAM).text.replace("ur5e", "ur55"), "true", "there is no robot 'ur55'"),
    ],
)  # fmt: skip
def test_what_cannot_be_driven_is_explained(tmp_path: Path, run: Run, text: str, command: str, said: str) -> None:
    (tmp_path / "program.json").write_text(text)
    done = run("execute", tmp_path / "program.json", "--on", command)
    assert done.code == 2 and said.lower() in done.err.lower()
    assert "Traceback" not in done.err


def test_a_program_runs_in_a_world_or_on_a_robot(tmp_path: Path, run: Run) -> None:
    (tmp_path / "program.json").write_text(typed_code(PROGRAM).text)
    both = run("execute", tmp_path / "program.json", "--on", "true", "--world", "grasp_one_thing")
    assert both.code == 2 and "is unknown here" in both.err
    neither = run("execute", tmp_path / "program.json")
    assert neither.code == 2 and "--on" in neither.err
