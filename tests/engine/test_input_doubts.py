"""What no search can cure is refused at once, or once; each refusal has a sibling that is just inside the limit."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run

from cramlite import Engine, Trace, read_scenario

SCENARIO = """
scenario: lift
tasks:
  - {{task: Grasping, Patient: block, parameters: {{force_n: {force}}}}}
  - {{task: {second}}}
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: block, model: block, at: {{position: [{x}, 0.2, {z}]}}, with: {{size: {size}, mass: {mass}}}}}
"""
PICK = "PickingUp, Locatum: block, Relatum: floor"
SLIDE = "SlideObject, Locatum: block, Relatum: floor, parameters: {{force_limit_n: {limit}}}"


def lift(
    folder: Path, *, force: float = 50, x: str = "0.5", z: str = "51 mm", mass: str = "300 g", second: str = PICK,
    size: str = "[50 mm, 50 mm, 100 mm]",
) -> Path:
    path = folder / "lift.yaml"
    path.write_text(SCENARIO.format(force=force, x=x, z=z, mass=mass, second=second, size=size))
    return path


def searched(path: Path) -> tuple[bool, Trace]:
    """Whether there is a proven program, and the trace."""
    trace = Trace()
    return next(Engine().resolve(read_scenario(path), trace=trace), None) is not None, trace


def said(trace: Trace, outcome: str, text: str) -> int:
    """How many entries of the trace with that outcome say so."""
    return sum(e.outcome == outcome and text in e.reason for e in trace.entries)


def test_a_position_beyond_reason_is_refused_at_once(tmp_path: Path, run: Run) -> None:
    begin = time.monotonic()
    done = run("resolve", lift(tmp_path, x="1e12"), "--out", tmp_path / "run")
    assert done.code == 2 and time.monotonic() - begin < 5
    assert "lift.yaml:9" in done.err and "'1000000000000.0' is beyond reason: a length here is at most 1000 m" in done.err
    assert run("check", lift(tmp_path, x="1000")).code == 0, "far away, which is a doubt, and no more"


@pytest.mark.parametrize(("z", "code"), [("39 mm", 2), ("41 mm", 0)])
def test_things_deeper_than_5_mm_in_each_other_are_an_error(z: str, code: int, tmp_path: Path, run: Run) -> None:
    """The floor's top is at -5 mm, the block's bottom 50 mm below its middle: 6 and 4 mm."""
    done = run("check", lift(tmp_path, z=z))
    assert done.code == code, done.err
    where = "'block' and 'floor' overlap by 6 mm at the start, more than the 5 mm" if code else "overlap by 4 mm at the start"
    assert where in (done.err if code else done.out)


def test_a_size_without_its_unit_is_named_and_not_the_overlap_that_follows(tmp_path: Path, run: Run) -> None:
    done = run("check", lift(tmp_path, size="[50, 50, 100]"))
    assert done.code == 2 and "lift.yaml:9: 'block' is 100 m long; write '100 mm' if millimetres are meant." in done.err


@pytest.mark.parametrize(
    ("mass", "says"),
    [("650", "carries 5 kg; write '650 g' if grams are meant"), ("51", "write '51 g'"), ("49", "")],
)
def test_a_mass_far_beyond_the_payload_is_a_doubt(mass: str, says: str, tmp_path: Path, run: Run) -> None:
    done = run("check", lift(tmp_path, mass=mass))
    said = f"lift.yaml:9: 'block' weighs {mass} kg, and 'ur5e' "
    assert done.code == 0 and (said in done.out) == bool(says) and says in done.out


@pytest.mark.parametrize("force", [19.9, 235.1])
def test_a_force_that_the_gripper_does_not_have_is_refused_with_its_range(force: float, tmp_path: Path) -> None:
    found, trace = searched(lift(tmp_path, force=force))
    assert not found
    assert said(trace, "impossible", f"a grip force of {force:g} N is outside 20 .. 235 N of gripper 'robotiq_2f85'") == 1


def test_without_a_force_the_gripper_presses_as_the_weight_needs(tmp_path: Path) -> None:
    _, trace = searched(lift(tmp_path, force=0))
    assert said(trace, "chosen", "grip 50 N for 0.3 kg (2.9 N) on friction 0.72 (pads 0.9, 'block' 0.6)") >= 1


@pytest.mark.heavy
@pytest.mark.parametrize("force", [20, 235])
def test_a_force_at_the_end_of_its_range_is_used(force: float, tmp_path: Path) -> None:
    _, trace = searched(lift(tmp_path, force=force))
    assert said(trace, "chosen", f"close on 50 mm with {force} N") >= 1


def test_a_load_that_is_too_heavy_is_recognised_once(tmp_path: Path) -> None:
    found, trace = searched(lift(tmp_path, mass="50 kg"))
    assert not found
    assert said(trace, "impossible", "50.92 kg on the flange, gripper included, > 5 kg that 'ur5e' carries") == 1
    assert not any(e.kind == "proof" for e in trace.entries)


def test_a_load_just_below_it_is_not_refused_for_it(tmp_path: Path) -> None:
    _, trace = searched(lift(tmp_path, mass="4.05 kg"))
    assert said(trace, "chosen", "4.97 kg on the flange") >= 1


@pytest.mark.heavy
@pytest.mark.parametrize(("limit", "proofs"), [(1.5, 1), (25, 1)])
def test_a_limit_that_no_other_place_changes_is_tried_once(limit: float, proofs: int, tmp_path: Path) -> None:
    found, trace = searched(lift(tmp_path, second=SLIDE.format(limit=limit).replace("{{", "{").replace("}}", "}")))
    assert found == (limit == 25)
    assert sum(e.kind == "proof" for e in trace.entries) == proofs
    assert said(trace, "failed", "it presses with 12 N, which is not below its force limit of 1.5 N") == (limit == 1.5)


GROUNDING = """
@hookimpl
def resolve_{kind}({argument}, belief, context):
    return [Grounding({value}, "as it comes", {cost})] if {argument}.name == "{name}" else None
"""


def grounding(kind: str, name: str, value: str, cost: object) -> str:
    """A plugin with one answer."""
    argument = "designator" if kind == "object" else kind
    return GROUNDING.format(kind=kind, argument=argument, name=name, value=value, cost=cost)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("kind", "name", "value", "cost", "says"),
    [
        ("object", "block", "42", -1.0, "the Grounding of an Object has a str, not 42"),
        ("location", "grasp(block)", "'there'", -1.0, "the Grounding of a Location has a Place or a Stand, not 'there'"),
        ("motion", "1.Grasping/open", "['open']", -1.0, "the Grounding of a Motion has a tuple of steps, not ['open']"),
        ("motion", "1.Grasping/open", "('open',)", -1.0, "the Grounding of a Motion has a tuple of steps, not 'open'"),
        ("action", "1.Grasping", "()", -1.0, "the Grounding of an Action has a Decomposition, not ()"),
        ("object", "block", "'block'", "float('nan')", "the cost of a Grounding is a finite number, not nan"),
        ("object", "block", "'block'", "-1.0, 'belief'", "the belief of a Grounding is a Belief or None, not 'belief'"),
    ],
)
def test_a_wrong_answer_is_blamed_on_who_gave_it(
    kind: str, name: str, value: str, cost: object, says: str, tmp_path: Path, plugin: Callable[[str, str], Path]
) -> None:
    """And the others are asked: the program is found all the same."""
    engine = Engine(files=[plugin("wrong", grounding(kind, name, value, cost))])
    assert next(engine.resolve(read_scenario(lift(tmp_path))), None) is not None
    assert [(f.plugin, f.designator) for f in engine.registry.faults] == [("wrong", name)]
    assert says in engine.registry.faults[0].error


def test_a_right_answer_is_blamed_on_nobody(tmp_path: Path, plugin: Callable[[str, str], Path]) -> None:
    engine = Engine(files=[plugin("right", grounding("object", "block", "'block'", -1.0))])
    assert next(engine.resolve(read_scenario(lift(tmp_path))), None) is not None
    assert engine.registry.faults == []


def test_a_text_that_is_no_code_is_blamed_on_its_backend(tmp_path: Path, plugin: Callable[[str, str], Path]) -> None:
    body = """
class Prose:
    name, executable = "prose", True

    def emit(self, program, robot):
        return "go there and take it"

@hookimpl
def backends():
    return [Prose()]
"""
    path = lift(tmp_path)
    path.write_text(path.read_text() + "backend: prose\n")
    engine, trace = Engine(files=[plugin("prose", body)]), Trace()
    assert next(engine.resolve(read_scenario(path), trace=trace), None) is None
    assert {f.plugin for f in engine.registry.faults} == {"prose"}
    assert "emit gives Code, not 'go there and take it'" in engine.registry.faults[0].error
