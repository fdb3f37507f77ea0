"""Faults as they are written, the worlds that they make, and those of the next run."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.short_runs import FLOOR, SHELF, lying
from msgspec.structs import replace

from cramlite import UserError
from cramlite.model import Joint, Pose, RobotMount, World
from cramlite.model.fault import Fault, FaultKind, Trigger
from cramlite.scenario.faults import LASTING, faulty, foreseen, left_over, read_fault, read_fault_text

DRAWER = replace(lying("drawer", (0.2, 0.6, 0.3)), joint=Joint("slide", Pose(), 0.0, 0.3))
WORLD = World((FLOOR, SHELF, lying("block", (0.5, 0.2, 0.03)), DRAWER), (RobotMount("arm", "ur5e"),))


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("missing: block", Fault(FaultKind.MISSING, "block")),
        ("moved: block, by: [0, 60 mm, 0]", Fault(FaultKind.MOVED, "block", (0.0, 0.06, 0.0))),
        ("added: block", Fault(FaultKind.ADDED, "block", (0.0, 0.0, 0.0))),
        ("added: block, by: [10 mm, 0, 0]", Fault(FaultKind.ADDED, "block", (0.01, 0.0, 0.0))),
        ("fallen: block", Fault(FaultKind.FALLEN, "block")),
        ("sticking: drawer, takes: 0.5 N", Fault(FaultKind.STICKING, "drawer", most=0.5)),
        ("payload: 0.3 kg", Fault(FaultKind.PAYLOAD, mass=0.3)),
        ("tool: [0, 0, 5 mm]", Fault(FaultKind.TOOL, by=(0.0, 0.0, 0.005))),
        ("sensor: [1 N, 0, 2 N]", Fault(FaultKind.SENSOR, by=(1.0, 0.0, 2.0))),
        ("grip_lost: 0.5 s", Fault(FaultKind.GRIP_LOST, lasts=0.5)),
        ("slip: 0, lasts: 0.5 s", Fault(FaultKind.SLIP, share=0.0, lasts=0.5)),
        ("slip: 0.9, lasts: 2 s", Fault(FaultKind.SLIP, share=0.9, lasts=2.0)),
        ("closes_short: 40 mm", Fault(FaultKind.CLOSES_SHORT, most=0.04)),
        ("friction: 0", Fault(FaultKind.FRICTION, share=0.0)),
        ("friction: 3", Fault(FaultKind.FRICTION, share=3.0)),
        ("readings: frozen, lasts: 1 s", Fault(FaultKind.FROZEN, lasts=1.0)),
        ("readings: lost, lasts: 1 s", Fault(FaultKind.LOST, lasts=1.0)),
        ("protective_stop: 0 s", Fault(FaultKind.STOP, after=0.0)),
        ("protective_stop: 0.5 s", Fault(FaultKind.STOP, after=0.5)),
        ("connection: 0 s, lasts: 2 s", Fault(FaultKind.CONNECTION, after=0.0, lasts=2.0)),
        ("killed: true", Fault(FaultKind.KILLED)),
        ("cancelled: true, after: 0.5 s", Fault(FaultKind.CANCELLED, after=0.5)),
        ("goal: [block on shelf]", Fault(FaultKind.GOAL, goal=("block on shelf",))),
        ("killed: true, line: lift", Fault(FaultKind.KILLED, trigger=Trigger("lift"))),
        ("killed: true, force: 0.5 N", Fault(FaultKind.KILLED, trigger=Trigger(force=0.5))),
        ("killed: true, near: block, within: 0.18 m, after: 1 s",
         Fault(FaultKind.KILLED, after=1.0, trigger=Trigger(near="block", within=0.18))),
        ("killed: true, line: lift, force: 4 N", Fault(FaultKind.KILLED, trigger=Trigger("lift", 4.0))),
    ],
)  # fmt: skip
def test_a_fault_is_read(text: str, fault: Fault) -> None:
    assert read_fault_text(text) == fault


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("line: lift", "the fault has none of the keys missing"),
        ("missing: block, fallen: block", "the fault has missing, fallen of the keys missing"),
        ("missing: block, fallen: block, killed: true", "the fault has missing, fallen, killed of"),
        ("moved: block", "'moved' needs 'by': how far"),
        ("missing: block, by: [1 mm, 0, 0]", "'by' may stand beside 'moved', 'added', not beside 'missing'"),
        ("sticking: drawer", "'sticking' needs 'takes'"),
        ("slip: 0.5", "'slip' needs 'lasts'"),
        ("readings: lost", "'readings' needs 'lasts'"),
        ("connection: 1 s", "'connection' needs 'lasts'"),
        ("killed: true, lasts: 1 s", "'lasts' may stand beside 'connection', 'slip', 'readings', not beside 'killed'"),
        ("fallen: block, near: block", "'near' needs 'within'"),
        ("fallen: block, within: 0.1 m", "'near' needs 'within'"),
        ("sensor: [1 N, 0, 0], line: x", "'sensor' takes neither a trigger nor 'after': the fault begins at the start"),
        ("tool: [1 mm, 0, 0], after: 1 s", "'tool' takes neither a trigger nor 'after': the fault begins at the start"),
        ("protective_stop: 1 s, force: 5 N", "'protective_stop' takes neither a trigger nor 'after': the fault begins at its time"),
        ("connection: 1 s, lasts: 1 s, after: 1 s", "'connection' takes neither a trigger nor 'after': the fault begins at its time"),
        ("missing: [", "no list of 'key: value'"),
        ("killed: false", "killed"),
        ("readings: old, lasts: 1 s", "readings"),
        ("goal: []", "goal"),
        ("grip_lost: 0 s", "grip_lost"),
        ("slip: -0.1, lasts: 1 s", "slip"),
        ("slip: 1, lasts: 1 s", "slip"),
        ("slip: 0.5, lasts: 0 s", "lasts"),
        ("closes_short: 0 m", "closes_short"),
        ("friction: -0.1", "friction"),
        ("friction: 3.1", "friction"),
        ("protective_stop: -1 s", "protective_stop"),
        ("connection: -1 s, lasts: 1 s", "connection"),
        ("sticking: drawer, takes: 0 N", "takes"),
        ("killed: true, after: -1 s", "after"),
        ("killed: true, force: -1 N", "force"),
        ("killed: true, near: block, within: 0 m", "within"),
    ],
)
def test_what_makes_no_sense_is_refused(text: str, said: str) -> None:
    with pytest.raises(UserError, match=said.replace("[", r"\[")):
        read_fault_text(text)


def test_of_many_things_that_are_wrong_two_are_told() -> None:
    with pytest.raises(UserError) as wrong:
        read_fault({"killed": False, "after": -1, "force": -1}, "faults.yaml")
    said = str(wrong.value)
    assert (
        said.startswith("faults.yaml: this cannot be read as a fault: killed: ")
        and "after: " in said
        and "force: " not in said
    )
    with pytest.raises(UserError, match=r"cannot be read as a fault: the fault has none of .* A fault has exactly one of missing, moved"):
        read_fault({}, "faults.yaml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("missing: bloc", "'bloc', which is no thing of this world; did you mean 'block'"),
        ("killed: true, near: bloc, within: 0.1 m", "'bloc', which is no thing of this world"),
        ("sticking: block, takes: 60 N", "'block' sticks, but it is on no joint"),
        ("fallen: shelf", "moves 'shelf' while the program runs; only loose things"),
        ("fallen: drawer", "moves 'drawer' while the program runs"),
        ("added: drawer", "moves 'drawer'"),
        ("missing: drawer, line: lift", "moves 'drawer'"),
        ("moved: drawer, by: [1 mm, 0, 0], after: 1 s", "moves 'drawer'"),
    ],
)
def test_faults_of_things_that_cannot_have_them_are_refused(text: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        faulty(WORLD, [read_fault_text(text)])


@pytest.mark.parametrize(
    "text",
    [
        "sticking: drawer, takes: 60 N",
        "fallen: block",
        "added: block",
        "missing: block, line: x",
        "friction: 0.5",
    ],
)
def test_faults_while_the_program_runs_are_kept_for_it(text: str) -> None:
    fault = read_fault_text(text)
    found = faulty(replace(WORLD, faults=(Fault(FaultKind.KILLED),)), [fault, fault])
    assert found == replace(WORLD, faults=(Fault(FaultKind.KILLED), fault, fault))


def test_faults_from_the_start_make_another_world() -> None:
    """Also of furniture and of what is on a joint."""
    for name in ("block", "drawer", "shelf"):
        found = faulty(WORLD, [read_fault_text(f"missing: {name}")])
        assert [t.name for t in found.things] == [t.name for t in WORLD.things if t.name != name]
        assert found.faults == ()
        moved = faulty(WORLD, [read_fault_text(f"moved: {name}, by: [10 mm, -20 mm, 30 mm]")])
        for before, after in zip(WORLD.things, moved.things, strict=True):
            off = (0.01, -0.02, 0.03) if before.name == name else (0.0, 0.0, 0.0)
            assert after.pose.position == pytest.approx(
                [a + b for a, b in zip(before.pose.position, off, strict=True)]
            )


def test_what_is_wrong_with_the_arm_adds_up() -> None:
    texts = ("payload: 0.3 kg", "payload: 0.2 kg", "tool: [0, 0, 5 mm]", "sensor: [1 N, 0, 2 N]")
    off = faulty(WORLD, map(read_fault_text, texts)).disturbance
    assert (
        off.flange_mass == pytest.approx(0.5)
        and off.tool == (0.0, 0.0, 0.005)
        and off.force_bias == (1.0, 0.0, 2.0)
    )


def test_what_a_fault_adds_is_not_believed_before() -> None:
    faults = list(map(read_fault_text, ("added: block, line: lift", "missing: drawer", "killed: true")))
    assert [t.name for t in foreseen(faults, WORLD).things] == ["floor", "shelf", "drawer"]
    assert foreseen([], WORLD) == WORLD


@pytest.mark.parametrize(("after", "left"), [(5.0, 2.0), (3.0, 0.0), (1.0, 0.0)])
def test_what_has_not_happened_is_still_to_come(after: float, left: float) -> None:
    timed = Fault(FaultKind.STOP, after=after)
    line = Fault(FaultKind.KILLED, after=after, trigger=Trigger("lift"))
    later = replace(line, trigger=Trigger("lift", carried_over=True))
    assert left_over([timed, line], [], 3.0) == (replace(timed, after=left), later)


@pytest.mark.parametrize("kind", FaultKind)
def test_of_what_happened_the_lasting_goes_on_from_the_start(kind: FaultKind) -> None:
    fault: Any = Fault(kind, "drawer", after=1.0, most=60.0, trigger=Trigger("lift"))
    goes_on = kind in (FaultKind.STICKING, FaultKind.FRICTION, FaultKind.CLOSES_SHORT)
    assert left_over([fault], [str(fault)], 3.0) == (
        (replace(fault, after=0.0, trigger=None),) if goes_on else ()
    )
    assert (kind in LASTING) is goes_on
