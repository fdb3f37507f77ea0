"""The printed trace: choices of the program stand at the margin, rejected ones have their reasons, nothing is said twice."""

from __future__ import annotations

import re

import pytest

from cramlite import Trace, trace_text
from cramlite.cli.trace_text import rounded

JOINTS = "0:(2.8298859542073376, -1.2396636140368194)"


def _choose(trace: Trace, parent: int, name: str, key: str, reason: str = "", cost: float = 0.0) -> tuple[int, int]:
    """Numbers of a question and of its first answer."""
    asked = trace.add(parent, name, name, "asked", "engine", "", kind="location")
    return asked, trace.add(asked, name, key, "chosen", "plug", reason or f"{key}: it fits", cost, kind="location")


def _search(*, proven: bool) -> Trace:
    """Two grasps: with the first one the motion is impossible, with the second a program runs."""
    trace = Trace()
    _, cup = _choose(trace, 0, "cup", "cup")
    grasp, first = _choose(trace, cup, "grasp", "from above", cost=1.0)
    _, opened = _choose(trace, first, "open", "wide")
    move = trace.add(opened, "move", "transfer", "asked", "engine", "", kind="motion")
    trace.add(move, "move", "transfer", "impossible", "plug", "0.91 m > 0.85 m", kind="motion")
    trace.add(move, "move", "transfer", "failed", "engine", "0 alternatives failed; it depends on grasp", kind="motion")
    second = trace.add(grasp, "grasp", "from the side", "chosen", "plug", "from the side: it fits", 2.0, kind="location")
    _choose(trace, second, "move", JOINTS, "one line")
    outcome, reason = ("proven", "passed") if proven else ("failed", "force 70 N > 60 N")
    trace.add(0, "proof", "plan", outcome, "urscript", reason, kind="proof")  # type: ignore[arg-type]
    if not proven:
        trace.add(grasp, "grasp", "grasp", "failed", "engine", "2 alternatives failed; it depends on cup", kind="location")
    return trace


def test_the_way_to_the_program_is_at_the_margin() -> None:
    assert trace_text(_search(proven=True)).splitlines() == [
        "?  cup",
        "  +  cup cup: it fits  [plug]",
        "?  grasp",
        "  ~  grasp from above: it fits (cost 1)  [plug]",
        "     given up: move: 0.91 m > 0.85 m",
        "    ?  open",
        "      ~  open wide: it fits  [plug]",
        "    ?  move transfer",
        "      x  move 0.91 m > 0.85 m  [plug]",
        "      x  move 0 alternatives failed; it depends on grasp",
        "  +  grasp from the side: it fits (cost 2)  [plug]",
        "?  move",
        "  +  move (2.83, -1.24): one line  [plug]",
        "OK proof passed  [urscript]",
    ]


def test_without_a_program_nothing_is_in_it() -> None:
    lines = trace_text(_search(proven=False)).splitlines()
    assert [line.strip()[:1] for line in lines if " grasp from" in line] == ["~", "~"]
    assert [line.strip() for line in lines if "given up" in line] == [
        "given up: move: 0.91 m > 0.85 m", "given up: proof: force 70 N > 60 N",
    ]  # fmt: skip


def test_a_search_that_was_interrupted_gave_its_last_choice_not_up() -> None:
    trace = Trace(_search(proven=True).entries[:-1])
    assert [line.strip()[:1] for line in trace_text(trace).splitlines() if " grasp from" in line] == ["~", "+"]


def test_one_designator_says_which_answer_is_in_the_program() -> None:
    text = trace_text(_search(proven=True), "grasp")
    assert text.splitlines()[1:] == [
        "~  grasp from above: it fits (cost 1)  [plug]",
        "   given up: move: 0.91 m > 0.85 m",
        "+  grasp from the side: it fits (cost 2)  [plug]",
    ]


@pytest.mark.parametrize(
    ("name", "key", "reason", "line"),
    [
        ("lift", "straight up", "straight up", "lift straight up"),
        ("in(basket)", "+0 deg", "'basket', +0 deg", "in(basket) 'basket', +0 deg"),
        ("open", "open", "open to 70 mm", "open open to 70 mm"),
        ("close", "close", "closest to it", "close closest to it"),
        ("pay", "1.225", "1.23 kg on the flange", "pay 1.23 kg on the flange"),
        ("object_1", "tin", "cram:Tin is no cram:Cup, nor is sitting one", "object_1 tin: cram:Tin is no cram:Cup, nor is sitting one"),
        ("touch", "until", "untilted", "touch until: untilted"),
    ],
)
def test_nothing_is_said_twice(name: str, key: str, reason: str, line: str) -> None:
    trace = Trace()
    _choose(trace, 0, name, key, reason)
    assert trace_text(trace).splitlines()[1] == f"  +  {line}  [plug]"


def test_long_searches_stay_readable() -> None:
    """Neither the margin nor the stack grows with the length of the way."""
    trace, parent = Trace(), 0
    for k in range(3000):
        _, parent = _choose(trace, parent, f"step {k}", "way")
    assert max(len(line) - len(line.lstrip()) for line in trace_text(trace).splitlines()) == 2


def test_every_branch_that_was_given_up_stands_further_in() -> None:
    trace, parent, siblings = Trace(), 0, []
    for k in range(30):
        asked, parent = _choose(trace, parent, f"step {k}", "way")
        siblings.append(asked)
    for asked in reversed(siblings):
        trace.add(asked, "step", "other", "chosen", "plug", "another", kind="location")
    lines = trace_text(trace).splitlines()
    depth = [len(line) - len(line.lstrip()) for line in lines if re.search(r"\? +step", line)]
    assert depth == [4 * k for k in range(30)]


def test_numbers() -> None:
    assert rounded("(2.8298859542073376, -4.1421e-10, 12.5, 0.0001234)") == "(2.83, 0, 12.5, 0)"


def test_of_one_designator_a_repeated_answer_is_said_once() -> None:
    trace = Trace()
    for reason in ("too narrow", "too narrow", "too low"):
        trace.add(0, "in(tray)", "", "impossible", "plug", reason, kind="location")
    assert trace_text(trace, "in(tray)").splitlines() == [
        "x  in(tray) too narrow  [plug] (2 times)", "x  in(tray) too low  [plug]"
    ]  # fmt: skip
