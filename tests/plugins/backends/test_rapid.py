"""RAPID: a small reader walks the moves of the text and compares them with the typed program. No controller runs it here."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Fallback,
    ForceExtract,
    ForceInsert,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Pose,
    Program,
    Repeat,
    Section,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
    walk,
)
from cramlite.model.program.program import Snapshot
from cramlite.plugin import UserError
from cramlite_plugins.backends.rapid.backend import Rapid
from cramlite_plugins.backends.rapid.emit import emit
from cramlite_plugins.backends.rapid.literals import ZONES, zone
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.robots.irb1200 import AXIS_ZEROS, IRB1200, LIMITS
from cramlite_plugins.robots.ur5e import UR5E

RAPID = {True: Rapid("rapid_fc", forces=True), False: Rapid("rapid", forces=False)}
NEAR = tuple(q + 0.2 for q in IRB1200.home)
PLACE = forward(IRB1200, IRB1200.home)
TILTED = PLACE * Pose.from_rotvec((0.03, 0.0, -0.05), (0.1, 0.2, 0.3))
DOWN = Pose((0, 0, 0), PLACE.quaternion)
STEPS: tuple[AnyStep, ...] = (
    MoveJoints((NEAR, IRB1200.home, NEAR), 1.0, 1.4, (0.012, 0.0), origin="1.Reaching/transfer", comment='above "it"'),
    MoveLinear(TILTED, 0.05, 0.5, IRB1200.home, origin="1.Reaching/approach"),
    MoveUntilContact((0, 0, -1), 0.01, 3.0, 0.05, 10, origin="1.Reaching/touch"),
    SetGripper(0.0, 0.1, 50.0, "object", origin="2.Grasping/close"),
    SetPayload(IRB1200.gripper.mass + 0.3, (0, 0, 0.12), origin="2.Grasping/payload"),
    ZeroSensor(),
    Repeat((MoveLinear(PLACE, 0.1, 0.5, origin="2.Grasping/lift"), Wait(0.5)), 2),
)
FORCES: tuple[AnyStep, ...] = (
    SpiralSearch(DOWN, 3.0, 0.001, 0.006, 0.01, 0.002, 25.0, 20.0, origin="3.Insert/search"),
    ForceInsert(DOWN, 8.0, 0.07, 0.02, 25.0, 11.0, origin="3.Insert/push"),
    ForceExtract(DOWN, 8.0, (0.0, 1.0), 0.07, 0.02, 25.0, 11.0, origin="3.Insert/pull"),
    Fallback(((Wait(1.0),), (Wait(2.0),), (Wait(3.0),)), origin="3.Insert/again"),
)


def program(*steps: AnyStep) -> Program:
    return Program(
        "fetch", "arm", "irb1200", IRB1200.gripper.tcp, IRB1200.home, steps, (Section("1.Reaching", "reach", 0, len(steps)),),
        (Snapshot("box", PLACE, "known from the scenario", 1.5),), mass=IRB1200.gripper.mass, center=(0, 0, 0.09),
    )  # fmt: skip


class Reader:
    """Declared data, and the moves of the tasks in the order of the text."""

    def __init__(self, text: str) -> None:
        found = re.findall(r"(?:CONST|PERS) (\w+) (\w+) := (.*);", text)
        self.kinds = {name: kind for kind, name, _ in found}
        assert len(self.kinds) == len(found), "a name is declared twice"
        self.values = {n: v for _, n, v in found}
        tasks = text.split("! ---- tasks ----")[1]
        self.moves = re.findall(r"(MoveAbsJ|MoveL) (\w+), (\S+)(?: \\T:=([\d.]+))?, (\w+), tGripper", tasks)

    def value(self, name: str) -> Any:
        return eval(self.values[name].replace("TRUE", "True").replace("FALSE", "False"))

    def joints(self, name: str) -> tuple[float, ...]:
        assert self.kinds[name] == "jointtarget"
        return tuple(math.radians(a) + z for a, z in zip(self.value(name)[0], AXIS_ZEROS, strict=True))

    def pose(self, name: str) -> Pose:
        assert self.kinds[name] == "robtarget"
        place, turn, *_ = self.value(name)
        return Pose(tuple(v / 1000 for v in place), tuple(turn))


def test_every_move_of_the_text_goes_where_the_typed_program_goes() -> None:
    text = emit(program(*STEPS), IRB1200, forces=False).text
    read, moves = Reader(text), iter(Reader(text).moves)
    for step in walk(STEPS):
        if isinstance(step, MoveJoints):
            for q, radius in zip(step.path, (*step.radii, 0.0), strict=True):
                kind, name, _, _, corner = next(moves)
                assert kind == "MoveAbsJ" and corner == zone(radius)
                assert read.joints(name) == pytest.approx(q, abs=2e-6)
        elif isinstance(step, MoveLinear):
            kind, name, speed, _, corner = next(moves)
            assert kind == "MoveL" and corner == "fine"
            assert read.pose(name).distance(step.target) == pytest.approx((0, 0), abs=2e-6)
            assert read.value(speed)[0] == pytest.approx(1000 * step.speed)
    assert next(moves, None) is None
    assert read.joints("jStart") == pytest.approx(IRB1200.home, abs=2e-6)


def test_the_reader_would_notice_a_wrong_target() -> None:
    text = emit(program(*STEPS), IRB1200, forces=False).text
    name = next(n for kind, n, *_ in Reader(text).moves if kind == "MoveL")
    good = Reader(text).pose(name)
    moved = re.sub(rf"({name} := \[\[)([-\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 1}", text)
    assert Reader(moved).pose(name).distance(good)[0] == pytest.approx(1e-3, rel=1e-3)


def test_tool_and_loads_are_those_of_the_program() -> None:
    read = Reader(RAPID[False].emit(program(*STEPS), IRB1200).text)
    _, frame, load = read.value("tGripper")
    assert frame[0] == pytest.approx([1000 * v for v in IRB1200.gripper.tcp.position])
    assert load[0] == pytest.approx(IRB1200.gripper.mass)
    held = read.value(next(n for n, k in read.kinds.items() if k == "loaddata"))
    assert held[0] == pytest.approx(0.3)
    # the load's centre in the tool frame, with the gripper's own, gives the whole payload's centre
    own = IRB1200.gripper.mass * IRB1200.gripper.tcp.position[2] / 2
    whole = (own + 0.3 * (held[1][2] / 1000 + IRB1200.gripper.tcp.position[2])) / (IRB1200.gripper.mass + 0.3)
    assert whole == pytest.approx(0.12, abs=1e-4)


@given(st.floats(0, 0.3))
def test_a_zone_is_never_larger_than_the_checked_radius(radius: float) -> None:
    found = zone(radius)
    size = {name: size for size, name in ZONES.items()} | {"fine": 0.0}
    assert size[found] <= 1000 * radius
    assert (found == "fine") == (1000 * radius < 0.3)


def test_text_and_result_say_that_nothing_ran() -> None:
    for backend in RAPID.values():
        assert "UNVERIFIED" in backend.emit(program(*STEPS), IRB1200).text
        assert not backend.executable and "cannot be run here" in backend.remark


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        (FORCES[:1], "SpiralSearch needs ABB's option Force Control; .* rapid_fc"),
        ((Monitor((Wait(1.0),), time=2.0, origin="watch"),), "'watch': RAPID has no Monitor here"),
    ],
)
def test_what_rapid_cannot_do_is_refused(steps: tuple[AnyStep, ...], said: str) -> None:
    with pytest.raises(UserError, match=said):
        RAPID[False].emit(program(*steps), IRB1200)


def test_other_makes_are_refused() -> None:
    with pytest.raises(UserError, match=r"ABB arms .* not for 'ur5e'"):
        RAPID[True].emit(replace(program(*STEPS), robot_type="ur5e"), UR5E)


def test_routines_that_are_called_are_there_and_force_control_only_where_it_is_licensed() -> None:
    text = RAPID[True].emit(program(*STEPS, *FORCES), IRB1200).text
    defined = set(re.findall(r"(?:PROC|FUNC \w+) (\w+)\(", text))
    tasks = text.split("! ---- tasks ----")[1]
    called = set(re.findall(r"^\s+(\w+)(?: [^:=\n]*)?;$", tasks, re.M)) - {"ENDPROC"}
    built_in = {"MoveL", "MoveAbsJ", "WaitTime", "GripLoad", "TPWrite", "TRYNEXT", "RAISE", "StopMove", "ClearPath",
                "StartMove", "EXIT", "BookErrNo"}  # fmt: skip
    assert {c for c in called if not c.startswith(("ConfL", "Move"))} <= defined | built_in
    assert "FCAct" in text
    plain = RAPID[False].emit(program(*STEPS), IRB1200).text
    assert not re.search(r"^\s+FC", plain, re.M)
    assert max(map(len, re.findall(r"\b[A-Za-z]\w*\b", re.sub(r'!.*|".*?"', "", text)))) <= 32


@examples(20)
@given(st.lists(st.sampled_from([*STEPS, *FORCES]), max_size=8))
def test_origins_lead_from_lines_to_steps(steps: list[AnyStep]) -> None:
    code = RAPID[True].emit(program(*steps), IRB1200)
    lines = code.text.split("\n")
    for number, origin in code.origins.items():
        assert lines[number - 1].strip() and not lines[number - 1].strip().startswith("!"), origin
    assert {s.origin for s in steps if s.origin} <= set(code.origins.values())


def test_the_arm_is_abbs() -> None:
    """At ABB's zero the arm is an upright L: the flange at 451 + 82 mm in front, at 399 + 448 + 42 mm height."""
    flange = forward(IRB1200, AXIS_ZEROS) * IRB1200.gripper.tcp.inverse()
    assert flange.position == pytest.approx((0.533, 0.0, 0.8891), abs=1e-9)
    assert flange.rotate((0.0, 0.0, 1.0)) == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)
    assert all(lo < q < hi for q, (lo, hi) in zip(IRB1200.home, LIMITS, strict=True))


def write_samples(folder: Path) -> None:
    """Modules with every kind of step, for a checker of syntax that runs elsewhere."""
    (folder / "plain.mod").write_text(RAPID[False].emit(program(*STEPS), IRB1200).text)
    (folder / "forces.mod").write_text(RAPID[True].emit(program(*STEPS, *FORCES), IRB1200).text)


if __name__ == "__main__":
    write_samples(Path(sys.argv[1]))
