"""A typed program as text: read back equal, always the same, and clear about what is wrong in it."""

from __future__ import annotations

import json
import types
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import fields, replace

from cramlite.model import (
    AnyStep,
    Control,
    Fallback,
    MoveJoints,
    MoveLinear,
    Parallel,
    Pose,
    Program,
    Repeat,
    Section,
    SetGripper,
    Step,
    Value,
    Wait,
    is_program_text,
    read_program,
    typed_code,
    walk,
    write_program,
)
from cramlite.model.program.program import Snapshot
from cramlite.model.program.program_json import laid_out
from cramlite.plugin import UserError

NUMBER = st.floats(-1e6, 1e6)
POSES = st.builds(lambda p, q: Pose(p, (1.0 + abs(q[0]), *q[1:])), st.tuples(*[NUMBER] * 3), st.tuples(*[NUMBER] * 4))
TEXT = st.text(max_size=12)


def values(hint: Any) -> st.SearchStrategy[Any]:
    """Values of a field's type: steps that are added later are covered as they come."""
    if hint is Pose:
        return POSES
    if get_origin(hint) is Literal:
        return st.sampled_from(get_args(hint))
    if get_origin(hint) is tuple and get_args(hint)[-1] is Ellipsis:
        return st.lists(values(get_args(hint)[0]), max_size=3).map(tuple)
    if get_origin(hint) is tuple:
        return st.tuples(*map(values, get_args(hint)))
    if get_origin(hint) in (Union, types.UnionType):
        plain = [k for k in get_args(hint) if k not in get_args(Control)]  # one level of steps in steps is enough
        return st.one_of(*(steps(k) if isinstance(k, type) and issubclass(k, Step) else values(k) for k in plain))
    if isinstance(hint, type) and issubclass(hint, Value):
        return steps(hint)
    kinds = {float: NUMBER, str: TEXT, int: st.integers(-9, 9), bool: st.booleans(), type(None): st.none()}
    return kinds[hint]


@cache
def steps(kind: type) -> st.SearchStrategy[Any]:
    hints = get_type_hints(kind)
    return st.builds(kind, **{f.name: values(hints[f.name]) for f in fields(kind)})


STEPS = st.lists(st.one_of(*map(steps, get_args(AnyStep))), max_size=6).map(tuple)
SAMPLE = Program(
    name="sample", robot="arm", robot_type="fr3", tcp=Pose((0, 0, 0.1)), start=(0.1,) * 7,
    steps=(
        MoveJoints(((0.2,) * 7, (0.3,) * 7), 1.0, 1.4, origin="1.Reaching/transfer", comment="über den Kasten"),
        MoveLinear(Pose((0.5, 0.1, 0.3)), 0.1, 0.5, origin="1.Reaching/approach"),
        SetGripper(0.0, 0.1, 50.0, "object"),
    ),
    sections=(Section("1.Reaching", "reach for 'box'", 0, 3),),
    snapshots=(Snapshot("box", Pose((0.5, 0, 0)), "known from the scenario", 1.5),),
)  # fmt: skip


@given(STEPS, TEXT, POSES)
@examples(25)
def test_what_is_written_is_read_back_equal(own: tuple[AnyStep, ...], name: str, tcp: Pose) -> None:
    program = replace(SAMPLE, steps=own, name=name, tcp=tcp)
    text = write_program(program)
    assert read_program(text).program == program
    assert write_program(read_program(text).program) == text


def test_each_step_has_its_line_whatever_the_layout() -> None:
    text = write_program(SAMPLE)
    found = read_program(text)
    lines = text.split("\n")
    for step in found.program.steps:
        assert f'"step": "{type(step).__name__}"' in lines[found.lines[id(step)] - 1]
    assert laid_out(text) == text
    flat = json.dumps(json.loads(text))
    assert laid_out(flat) == text and laid_out(json.dumps(json.loads(text), indent=2)) != text
    other = read_program(json.dumps(json.loads(text), indent=2))
    assert other.program == SAMPLE
    assert other.lines[id(other.program.steps[1])] > found.lines[id(found.program.steps[1])]


def test_steps_in_control_steps_have_lines_of_their_own() -> None:
    inner = Wait(duration=1.0, origin="1.A/wait"), SetGripper(0.08, 0.1, 20.0, origin="1.A/open")
    both = Parallel(branches=(inner[:1], inner[1:]), origin="1.A/both")
    twice = Repeat(steps=(both, replace(inner[0], origin="1.A/last")), count=2, origin="1.A/twice")
    program = replace(SAMPLE, steps=(twice, Fallback(branches=((both,), inner))))
    found = read_program(write_program(program))
    own = [found.lines[id(s)] for s in walk(found.program.steps)]
    assert found.program == program and len(set(own)) == len(own) == 11
    assert typed_code(program).origins.keys() == set(own) - {found.lines[id(found.program.steps[1])]}


def changed(change: Callable[[dict[str, Any]], object]) -> str:
    data = json.loads(write_program(SAMPLE))
    change(data)
    return json.dumps(data, indent=1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (write_program(SAMPLE).replace('"steps": [', '"steps": [,'), r"no JSON: line 8, column \d+"),
        (write_program(SAMPLE)[:-30], "no JSON: line"),
        ("{" * 100_000, "JSON"),
        ('{"format": "cramlite program 9"}', 'does not say "format": "cramlite program 1"'),
        ("[1]", "format"),
        (write_program(SAMPLE).replace("60.0", "NaN"), "NaN is no number"),
        (write_program(SAMPLE).replace('"name"', '"robot"'), '"robot" appears twice'),
        (changed(lambda d: d["steps"][1].pop("target")), r"steps\[1\] \(MoveLinear\) does not say its 'target'"),
        (changed(lambda d: d["steps"][1].update(sped=1)), "has no 'sped'; did you mean 'speed'"),
        (changed(lambda d: d["steps"][1].update(step="MoveLiner")), "did you mean 'MoveLinear'"),
        (changed(lambda d: d["steps"][1].update(step=["MoveLinear"])), r'step is \["MoveLinear"\]; it should be the class of a step'),
        (changed(lambda d: d["steps"][1].update(speed="fast")), r'speed is "fast"; it should be a number'),
        (changed(lambda d: d["steps"][0]["path"][0].append(True)), r"path\[0\]\[7\] is true; it should be a number"),
        (changed(lambda d: d["steps"][1]["target"]["position"].pop()), "should be a list of 3"),
        (changed(lambda d: d["steps"][1]["target"].update(quaternion=[0, 0, 0, 0])), "not a pose"),
        (changed(lambda d: d["steps"][2].update(expect="thing")), "one of 'object', 'none', 'any'"),
        (changed(lambda d: d.update(steps=7)), "the program.steps is 7; it should be a list"),
    ],
)
def test_a_broken_text_gets_one_paragraph(text: str, said: str) -> None:
    with pytest.raises(UserError, match=said) as error:
        read_program(text)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 500


@given(st.recursive(st.none() | st.booleans() | NUMBER | TEXT, lambda v: st.lists(v) | st.dictionaries(TEXT, v)))
@examples(25)
def test_any_json_is_a_program_or_a_user_error(value: Any) -> None:
    with pytest.raises(UserError):
        read_program(json.dumps(value))
    with pytest.raises(UserError):
        read_program(json.dumps({"format": "cramlite program 1", "steps": [value]}))


def test_urscript_is_not_taken_for_it() -> None:
    assert is_program_text(write_program(replace(SAMPLE, steps=(Wait(1.0),))))
    assert not is_program_text("def p():\n  sleep(1)\nend\n")
