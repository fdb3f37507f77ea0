"""Steps of a proven program in an edited text: each has code, runs in its turn and covers its way; and good edits that look alike."""

from __future__ import annotations

import re

import pytest
from helpers.edited import findings, proven, run
from msgspec.structs import replace

from cramlite.model import Fallback, MoveLinear
from cramlite.plugin import Candidate
from cramlite_plugins.validators.steps import Steps


def said(good: Candidate, text: str, validator: str = "steps") -> list[str]:
    """What a validator objects to in a text, whose lines are those of the program that it was edited from."""
    return [f.reason for f in findings(run(good, text)) if f.validator == validator and not f.passed]


def lines_of(good: Candidate) -> list[str]:
    assert good.code is not None
    return good.code.text.splitlines()


def where(lines: list[str], words: str) -> int:
    """The only line with some words, from 0."""
    (found,) = (k for k, line in enumerate(lines) if words in line)
    return found


def with_height(good: Candidate, name: str, height: float) -> str:
    """The text, in which a pose of the tool has another height over the base [m]."""
    lines = lines_of(good)
    k = where(lines, f"global {name} =")
    numbers = lines[k].split("p[")[1].split(", ")
    lines[k] = f"  global {name} = p[{numbers[0]}, {numbers[1]}, {height}, {', '.join(numbers[3:])}"
    return "\n".join(lines)


def height_of(good: Candidate, name: str) -> float:
    return float(lines_of(good)[where(lines_of(good), f"global {name} =")].split(", ")[2])


def without_lines(good: Candidate, *words: str) -> str:
    """The text without the lines that have some words and are no comment."""
    return "\n".join(line for line in lines_of(good) if line.lstrip().startswith("#") or not any(w in line for w in words))


BACK, BACK_POSE = "movel(placing_3_retracting_back_pose", "placing_3_retracting_back_pose"
LOWER_POSE = "placing_3_putting_down_lower_pose"


# Left out


@pytest.mark.heavy
def test_the_last_step_of_a_drawers_closing_may_not_be_deleted() -> None:
    good = proven("closing_drawer")
    assert said(good, "\n".join(lines_of(good))) == []
    lost = "1.Closing/back has no line of code in this text, while the proven text had some"
    assert said(good, without_lines(good, "movel(closing_1_back_pose")) == [lost]


@pytest.mark.heavy
def test_a_jug_that_nobody_turns_back_was_not_poured_from_and_half_of_the_tilt_is_enough() -> None:
    good = proven("pouring")
    (gone,) = said(good, without_lines(good, "movej(pouring_3_back_joints"))
    assert gone.startswith("3.Pouring/back has no line of code")
    token = [line for line in lines_of(good) if not re.search(r"movej\(pouring_3_back_joints_\d", line)]
    little, leaning = said(good, "\n".join(token))
    assert little.startswith("3.Pouring/back was not carried out: the hand covered ")
    assert leaning.startswith("3.Pouring/back was not carried out: 'jug' leans ")
    halves = r"movej\(pouring_3_(tilt_joints_(1[1-9]|2\d)|back_joints(|_\d|_10)),"
    assert said(good, "\n".join(line for line in lines_of(good) if not re.search(halves, line))) == []


@pytest.mark.heavy
def test_a_task_without_any_code_is_told_once_and_steps_without_code_by_their_names() -> None:
    good = proven("placing")
    held = without_lines(good, "3.Placing/Releasing/open", "set_target_payload(0.925, [0.0, 0.0, 0.077875])", BACK)
    names = ["3.Placing/Releasing/open", "3.Placing/Releasing/payload", "3.Placing/Retracting/back"]
    assert [reason.split(" has no")[0] for reason in said(good, held)] == names
    (whole,) = said(good, without_lines(good, "movel(picking_up_2"))
    assert whole.startswith("2.PickingUp has no line of code")


def test_steps_of_a_branch_that_the_run_decides_about_may_have_no_code() -> None:
    good = proven("placing")
    *others, last = good.program.steps
    assert isinstance(last, MoveLinear)
    way = Fallback(branches=((last,), (replace(last, origin="3.Placing/other"),)), origin="")
    program = replace(good.program, steps=(*others, way))
    assert [f.passed for f in Steps().check(replace(good, program=program))] == [True]
    gone = without_lines(good, BACK)
    assert said(replace(good, program=program), gone)[0].startswith("3.Placing/Retracting/back has no line of code")


def test_a_backend_that_writes_one_line_for_two_steps_has_left_nothing_out() -> None:
    good = proven("placing")
    assert good.code is not None
    fewer = {line: o for line, o in good.code.origins.items() if o not in ("1.Grasping/open", "3.Placing/Retracting/back")}
    merged = replace(good, code=replace(good.code, origins=fewer))
    assert [f.passed for f in Steps().check(merged)] == [True]
    assert [f.passed for f in Steps().check(replace(merged, proven=merged.code))] == [True]
    assert [f.origin for f in Steps().check(replace(merged, proven=good.code)) if not f.passed] == [
        "1.Grasping/open", "3.Placing/Retracting/back",
    ]  # fmt: skip


# Out of turn


def test_fingers_that_open_behind_the_retreat_open_too_late() -> None:
    good = proven("placing")
    lines = lines_of(good)
    k, back = where(lines, '"3.Placing/Releasing/open"'), where(lines, BACK)
    late = [*lines[:k], "  sleep(0.5)", *lines[k + 1 : back + 1], lines[k], *lines[back + 1 :]]
    (reason,) = said(good, "\n".join(late))
    assert reason.startswith("the code of 3.Placing/Releasing/open ran at ")
    assert reason.endswith(" s, after that of 3.Placing/Retracting/back, which comes later in the program")


@pytest.mark.heavy
def test_what_only_sets_a_payload_may_change_places_with_its_neighbour() -> None:
    good = proven("placing")
    lines = lines_of(good)
    k = where(lines, '"3.Placing/Releasing/open"')
    payload = next(i for i in range(k, len(lines)) if "set_target_payload" in lines[i])
    lines[k], lines[payload] = lines[payload], lines[k]
    assert said(good, "\n".join(lines)) == []


# Not carried out


@pytest.mark.heavy
def test_a_retreat_of_7_mm_is_none_and_a_longer_or_a_shorter_one_is() -> None:
    good = proven("placing")
    low, high = height_of(good, LOWER_POSE), height_of(good, BACK_POSE)
    (token,) = said(good, with_height(good, BACK_POSE, low - 0.03 + 0.007))
    assert token.startswith("3.Placing/Retracting/back was not carried out: the hand covered ")
    for height in (high + 0.1, high - 0.04):
        assert said(good, with_height(good, BACK_POSE, height)) == []


def test_code_that_never_runs_carries_nothing_out() -> None:
    good = proven("placing")
    lines = lines_of(good)
    lines[where(lines, BACK)] = f"  if False:\n  {lines[where(lines, BACK)]}\n  end"
    (reason,) = said(good, "\n".join(lines))
    assert reason.startswith("3.Placing/Retracting/back was not carried out: the hand covered 0% of its way")


@pytest.mark.heavy
@pytest.mark.parametrize("edit", ["aside", "via", "slower", "split"])
def test_a_step_that_is_done_in_another_way_is_done(edit: str) -> None:
    good = proven("placing")
    text = "\n".join(lines_of(good))
    lift = "  movel(picking_up_2_lift_pose, a=0.5, v=0.1)"
    assert lift in text
    way = "  movel(pose_add(get_actual_tcp_pose(), p[0.0, 0.0, {height}, 0.0, 0.0, 0.0]), a=0.5, v=0.1)"
    if edit == "aside":
        for name in (LOWER_POSE, BACK_POSE):
            x = re.search(rf"{name} = p\[([-\d.]+),", text)
            assert x is not None
            text = text.replace(f"{name} = p[{x[1]},", f"{name} = p[{float(x[1]) + 0.03},")
    elif edit == "via":
        text = text.replace(lift, f"{lift}\n{way.format(height=0.02)}")
    elif edit == "slower":
        text = text.replace(lift, lift.replace("v=0.1", "v=0.05"))
    else:
        text = text.replace(lift, f"{way.format(height=0.05)}\n{lift}")
    assert text != "\n".join(lines_of(good))
    assert said(good, text) == []
