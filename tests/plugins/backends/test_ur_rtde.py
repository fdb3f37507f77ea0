"""Python programs for ur_rtde: the text says what the typed program says, and the unmodified client carries it out."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator

import pytest
from msgspec.structs import replace
from test_urscript import STEPS, program

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    Fallback,
    ForceMove,
    Geom,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Repeat,
    RobotMount,
    Rollout,
    SetGripper,
    SpiralSearch,
    Thing,
    Wait,
    World,
    ZeroSensor,
)
from cramlite.plugin import Code, UserError
from cramlite_plugins.backends.ur_rtde.emit import emit
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.ur_controller.client_program import execute_client

CLIENT = pytest.mark.skipif(sys.version_info >= (3, 13), reason="ur_rtde has wheels for 3.11 and 3.12")
BLOCK = Thing("block", "cram:Block", Pose((0.42, 0.0, 0.15)), (Geom("box", (0.1, 0.1, 0.15)),))
HOME = forward(UR5E, UR5E.home)
LOW = Pose((*HOME.position[:2], 0.319), HOME.quaternion)
DOWN = Pose((0, 0, 0), HOME.quaternion)
WRONG = SetGripper(0.0, 0.1, 40.0, "object", origin="wrong")
SHUT = SetGripper(0.0, 0.15, 40.0, "none", origin="shut")
OPEN = SetGripper(0.08, 0.15, 40.0, "none", origin="open")
AWAY = MoveJoints(((UR5E.home[0] + 0.2, *UR5E.home[1:]), UR5E.home), 1.0, 1.4, origin="away")
SLIDE = CompliantSlide((LOW, replace(LOW, position=(LOW.position[0] + 0.02, *LOW.position[1:]))), DOWN, 4.0, 0.02, 1.0, 25.0, 20.0)


def typed(*steps: AnyStep) -> Program:
    return replace(program(*steps), sections=())


def calls(code: Code) -> Iterator[ast.Call]:
    """The calls of the tasks' functions, in the order of the text."""
    tree = ast.parse(code.text)
    begin = code.text.split("\n").index("# ---- tasks ----")
    for function in tree.body:
        if isinstance(function, ast.FunctionDef) and function.lineno > begin:
            yield from (n for n in ast.walk(function) if isinstance(n, ast.Call))


def constants(code: Code) -> dict[str, list[float]]:
    """The named poses of a program."""
    named = [n for n in ast.parse(code.text).body if isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name)]
    values = {n.targets[0].id: n.value for n in named}  # type: ignore[attr-defined]
    return {k: ast.literal_eval(v) for k, v in values.items() if isinstance(v, ast.List)}


def test_the_text_is_one_python_file_and_always_the_same() -> None:
    one, two = emit(program(*STEPS), UR5E), emit(program(*STEPS), UR5E)
    assert one == two
    compile(one.text, "program.py", "exec")
    assert one.language == "python" and one.suffix == ".py"
    assert one.text != emit(program(*STEPS[:-1]), UR5E).text
    head = ast.get_docstring(ast.parse(one.text)) or ""
    for fact in ("PRECONDITIONS", "ur5e", "robotiq_2f85", "0.925 kg", "60 N", "box: p[0.5", "1.5 s old", "ROBOT_ADDRESS"):
        assert fact in head


def test_targets_in_the_text_are_those_of_the_typed_program() -> None:
    code = emit(program(*STEPS), UR5E)
    values, found = constants(code), list(calls(code))
    linear = next(c for c in found if isinstance(c.func, ast.Attribute) and c.func.attr == "move_linear")
    assert isinstance(linear.args[1], ast.Name)
    target = STEPS[1].target  # type: ignore[union-attr]
    assert values[linear.args[1].id] == pytest.approx([*target.position, *target.rotvec], abs=1e-6)
    joints = next(c for c in found if isinstance(c.func, ast.Attribute) and c.func.attr == "move_joints")
    assert isinstance(joints.args[1], ast.List) and isinstance(joints.args[1].elts[0], ast.Name)
    assert values[joints.args[1].elts[0].id] == pytest.approx(UR5E.home, abs=1e-6)


def test_origins_lead_from_lines_to_steps() -> None:
    code = emit(program(*STEPS), UR5E)
    lines = code.text.split("\n")
    for number, origin in code.origins.items():
        assert f'"{origin}"' in lines[number - 1]
    assert {"1.Reaching/touch", "2.Grasping/pull"} <= set(code.origins.values())


def test_every_wait_has_a_time_out_and_every_path_ends_at_rest() -> None:
    """No loop and no blocking motion outside of the one place that watches; the main function rests in 'finally'."""
    tree = ast.parse(emit(typed(*STEPS, Fallback(((WRONG,), (SHUT,)))), UR5E).text)
    loops = [f.name for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f) if isinstance(n, ast.While)]
    assert set(loops) == {"wait", "listen", "at", "spiral"}  # a thread listens; the last two count: frames of the stack, points of a curve
    run = next(f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == "run_program")
    guard = next(n for n in ast.walk(run) if isinstance(n, ast.Try))
    assert any(isinstance(n, ast.Attribute) and n.attr == "rest" for final in guard.finalbody for n in ast.walk(final))


def test_only_what_is_needed_is_carried_along() -> None:
    text = emit(typed(AWAY), UR5E).text
    assert "def spiral_search" not in text and "def monitored" not in text
    assert "def spiral_search" in emit(typed(SLIDE), UR5E).text
    assert "def monitored" in emit(typed(Monitor((AWAY,), time=9.0)), UR5E).text


def test_names_and_robots_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UserError, match="Python needs a letter"):
        emit(replace(program(), name="fetch from"), UR5E)
    with pytest.raises(UserError, match="'fr3'"):
        emit(replace(program(), robot_type="fr3"), FR3)
    with pytest.raises(UserError, match="more than one branch needs the arm"):
        emit(typed(Parallel(((AWAY,), (AWAY,)))), UR5E)


def test_text_of_designators_cannot_break_out_of_a_string_or_comment() -> None:
    step = replace(STEPS[2], origin='a"b\nimport pickle', comment="x\nimport pickle")
    text = emit(replace(program(step), sections=()), UR5E).text
    ast.parse(text)
    assert "\nimport pickle" not in text


def run(*steps: AnyStep, things: tuple[Thing, ...] = (), **changes: object) -> Rollout:
    code = emit(replace(typed(*steps), **changes), UR5E)  # type: ignore[arg-type]
    return execute_client(code.text, World(things, (RobotMount("arm", "ur5e"),)), {"ur5e": UR5E}, mount="arm")


@pytest.mark.heavy
@CLIENT
def test_the_unmodified_client_carries_out_every_kind_of_step() -> None:
    """On a flat block the small search finds nothing; the attempt after it goes on, and all comes to its end."""
    search = SpiralSearch(DOWN, 3.0, 0.001, 0.001, 0.02, 0.002, 25.0, 20.0, origin="search")
    lift = ForceMove((HOME,), DOWN, (True, True, False, False, False, False), (0,) * 6, (0.02,) * 6, 0.1, 25, 20, origin="lift")
    done = run(
        Parallel(((AWAY,), (SHUT,))),
        Repeat((OPEN, SHUT), 1),
        Monitor((MoveLinear(Pose((*HOME.position[:2], 0.33), HOME.quaternion), 0.2, 0.5),), time=30.0, force=50.0),
        ZeroSensor(),
        MoveUntilContact((0.0, 0.0, -1.0), 0.01, 3.0, 0.1, 20.0, origin="touch"),
        Fallback(((search,), (SLIDE,)), origin="feel"),
        lift,
        Wait(0.1),
        things=(BLOCK,),
    )  # fmt: skip
    said = [m.text.split(",")[0] for m in done.messages]
    assert done.outcome == "finished", (done.reason, said)
    assert said[0] == "touch: contact" and said[-1] == "cramlite: finished"
    assert "cramlite failed: feel" in said[1]
    assert done.joints[-1] == pytest.approx(UR5E.home, abs=0.01)
    assert max(done.wrench[:, 2] ** 2) ** 0.5 < 25


@pytest.mark.heavy
@CLIENT
@pytest.mark.parametrize(
    ("steps", "changes", "said"),
    [
        ((WRONG, AWAY), {}, "wrong: no object between the fingers"),
        ((AWAY,), {"start": (0.1, *UR5E.home[1:])}, "joint 0 is at"),
        ((MoveLinear(Pose((*HOME.position[:2], 0.28), HOME.quaternion), 0.05, 0.5),), {"force_limit": 20.0}, "N > 20 N"),
    ],
)
def test_what_goes_wrong_ends_at_rest_and_says_why(
    steps: tuple[AnyStep, ...], changes: dict[str, object], said: str
) -> None:
    done = run(*steps, things=(BLOCK,), **changes)
    assert done.outcome == "halted"
    assert said in done.reason
    assert done.joints[-1] == pytest.approx(done.joints[-10], abs=2e-3)


@pytest.mark.heavy
@CLIENT
def test_a_program_that_breaks_is_an_error_and_the_robot_is_left_at_rest() -> None:
    code = emit(typed(AWAY), UR5E)
    broken = code.text.replace("arm.move_joints(", "arm.no_such_motion(")
    done = execute_client(broken, World((), (RobotMount("arm", "ur5e"),)), {"ur5e": UR5E}, mount="arm")
    assert done.outcome == "error"
    assert "no_such_motion" in done.reason
