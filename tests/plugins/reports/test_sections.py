"""The pieces that sections are made of: decisions, code blocks, frames, curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Trace
from cramlite.model import Action, Collision, Object, Pose
from cramlite.model.control_flow import compound
from cramlite.plugin import Code, Finding
from cramlite_plugins.reports.collisions import pairs
from cramlite_plugins.reports.decisions import attempts, path
from cramlite_plugins.reports.filmstrip import spread
from cramlite_plugins.reports.links import lines_of, target
from cramlite_plugins.reports.plan import diagram
from cramlite_plugins.reports.plots import plot
from cramlite_plugins.reports.program_text import blocks
from cramlite_plugins.reports.search_tree import bars, reasons, stages
from cramlite_plugins.reports.shared import Span, anchor, colour, words
from cramlite_plugins.reports.validators import measured


def searched() -> Trace:
    """One candidate: the first grasp failed further down, the second one was proven."""
    trace = Trace()
    grasp = trace.add(0, "grasp", "grasp of cup", "asked", "engine", "", kind="location")
    trace.add(grasp, "grasp", "from below", "refused", "grasps", "the table is there", kind="location")
    first = trace.add(grasp, "grasp", "from the side", "chosen", "grasps", "20 mm wide", 0.1, kind="location")
    move = trace.add(first, "move", "transfer", "asked", "engine", "", kind="motion")
    trace.add(move, "move", "transfer", "impossible", "motions", "no path within 400 samples", kind="motion")
    trace.add(move, "move", "transfer", "failed", "engine", "0 alternatives failed; it depends on grasp", kind="motion")
    second = trace.add(grasp, "grasp", "from above", "chosen", "grasps", "30 mm wide", 0.4, kind="location")
    move = trace.add(second, "move", "transfer", "asked", "engine", "", kind="motion")
    trace.add(move, "move", "line", "chosen", "motions", "straight", 0.0, kind="motion")
    trace.add(0, "proof", "Grasping", "proven", "urscript", "passed", kind="proof")
    return trace


def test_the_chosen_path_is_told_from_what_was_tried_before() -> None:
    (attempt,) = attempts(searched())
    grasp, move = attempt.decisions
    assert attempt.proven
    assert {k: e.text for k, e in path(attempt).items()} == {"grasp": "from above", "move": "line"}
    assert [b.entry.text for b in grasp.tried] == ["from the side"]
    assert grasp.tried[0].decisions[0].refused[0].reason == "no path within 400 samples"
    assert [e.reason for e in grasp.refused] == ["the table is there"]
    assert move.failed is None


def test_a_candidate_without_proof_is_not_proven() -> None:
    trace = Trace()
    node = trace.add(0, "cup", "cup: a cup", "asked", "engine", "", kind="object")
    trace.add(node, "cup", "floor", "refused", "objects", "no cup", kind="object")
    (attempt,) = attempts(trace)
    assert not attempt.proven
    assert path(attempt) == {}
    assert attempt.refusals == 1


def test_long_paths_need_no_recursion() -> None:
    trace, parent = Trace(), 0
    for k in range(3000):
        node = trace.add(parent, f"d{k}", "", "asked", "engine", "", kind="motion")
        parent = trace.add(node, f"d{k}", "", "chosen", "x", "", 0.0, kind="motion")
    assert len(attempts(trace)[0].decisions) == 3000


def test_every_line_of_code_is_in_one_block() -> None:
    text = "def p():\n  # open\n  a()\n\n  # close\n  b()\nend\n"
    found = list(blocks(Code("urscript", text, {3: "1.Grasping/open", 6: "2.Placing/close"}, ".script")))
    assert [(b.task, [n.number for n in b.lines]) for b in found] == [("", [1]), ("1.Grasping", [2, 3]), ("2.Placing", [4, 5, 6, 7])]
    assert [n.origin for n in found[1].lines] == ["", "1.Grasping/open"]


@given(st.integers(0, 40), st.integers(2, 12))
def test_a_strip_is_short_and_ends_with_the_last_task(count: int, most: int) -> None:
    tasks = [Span(f"{k}.Task", k, k + 1.0) for k in range(count)]
    found = spread(tasks, most)
    assert found == sorted(found, key=lambda s: s.start)
    assert len(found) == min(count, most)
    assert not tasks or found[-1] is tasks[-1]


def test_lines_of_a_task_are_those_of_its_steps() -> None:
    found = lines_of(["", "1.A/x", "1.A/x", "1.A/y", "2.B/x", "1.A/x"])
    assert found["1.A"] == [(2, 4), (6, 6)]
    assert found["1.A/x"] == [(2, 3), (6, 6)]
    assert "" not in found


def test_links_lead_to_the_nearest_whole_that_is_there() -> None:
    assert target("1.A/x/fast", {"1.A/x", "1.A"}) == "1.A/x"
    assert target("1.A/y", {"1.A"}) == "1.A"
    assert target("2.B/y", {"1.A"}) == ""


def test_how_far_a_candidate_came() -> None:
    entries = [e for e in searched().entries if e.kind != "proof"]
    entries += [replace(entries[0], numbers={"task": 2, "depth": 1})]
    assert [s.state for s in stages(["Grasping", "Holding", "Placing"], entries, ran=False)] == ["reached", "stopped", "unreached"]
    assert {s.state for s in stages(["Grasping", "Holding"], entries, ran=True)} == {"reached"}


def test_the_map_shows_where_it_was_dear_and_what_was_refused() -> None:
    (attempt,) = attempts(searched())
    grasp, move = bars(attempt.decisions)
    assert (grasp.cost, grasp.refused) == (1.0, 1.0)
    assert (move.cost, move.refused) == (0.0, 0.0)
    assert "2 not taken" in grasp.text


def test_lanes_begin_are_met_and_end() -> None:
    cup, rack, hook = Object("cup"), Object("rack"), Object("hook", part_of="rack")
    tasks = [Action("1.Grasping", "soma:Grasping", {"Patient": cup}), Action("2.Hanging", "cram:Hanging", {"What": cup, "Where": hook})]
    rows = diagram([cup, rack, hook], [*tasks, Action("3.Home", "soma:Home")], ())
    assert [r.lanes for r in rows] == [
        ("begin", "", ""),
        ("through", "begin", ""),
        ("through", "through", "begin"),
        ("use", "through", "through"),
        ("end", "", "end"),
        ("", "", ""),
    ]


def test_rules_are_drawn_around_their_tasks() -> None:
    a, b = Action("1.A", "x:A"), Action("2.B", "x:B")
    rows = diagram([], [compound("choose", "1.try", ((a,), (b,)))], ())
    assert [(r.action.name, r.depth, r.rule) for r in rows if r.action] == [("1.try", 0, ""), ("1.A", 1, "1 of 2"), ("2.B", 1, "2 of 2")]


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=50))
def test_curves_stay_inside_their_axes(values: list[float]) -> None:
    times, y = np.arange(len(values), dtype=float), np.array(values)
    found = plot("x", "N", times, {"x": y}, np.array([0]))
    assert found.low <= y.min()
    assert y.max() <= found.high
    heights = [float(p.split()[1]) for p in found.curves[0].path[1:].split("L")]
    assert all(-0.1 <= h <= 100.1 for h in heights)


@given(st.text(min_size=1), st.text(min_size=1))
def test_anchors_are_safe_and_distinct(a: str, b: str) -> None:
    assert all(c.isascii() and (c.isalnum() or c in "-_") for c in anchor(a))
    assert (anchor(a) == anchor(b)) == (a == b)


@pytest.mark.parametrize(("name", "expected"), [("1.Grasping/open", "t1"), ("9.Placing", "t1"), ("home", "t0")])
def test_tasks_have_colours(name: str, expected: str) -> None:
    assert colour(name) == expected


def test_numbers_are_in_units_that_people_read() -> None:
    slip = measured(Finding("slip", True, "", 0.00075, 0.012, "m"))
    assert (slip.value, slip.limit) == ("0.75 mm", "12 mm")
    assert slip.share == pytest.approx(0.0625)
    still = measured(Finding("bystanders", True, "", 2.62e-13, 0.005, "m"))
    assert (still.value, measured(Finding("bystanders", True, "", 0.0, 0.005, "m")).value) == ("< 0.001 mm", "0 mm")
    assert measured(Finding("limits", True, "", 0.7, 0.0, "rad")).share is None


@given(st.text())
def test_words_lose_nothing(name: str) -> None:
    assert "".join(words("x:" + name)) == name.split(":")[-1]


def test_words_of_a_class() -> None:
    assert words("artm:ExtractHoleFromPeg") == ["Extract", "Hole", "From", "Peg"]


def collided(trace: Trace, one: str, other: str, depth: float) -> None:
    state = Collision(one, other, depth, "arm", Pose(), (0.0,), 0.05)
    trace.add(0, "grasp", "", "refused", "grasps", f"at the grasp: {state}", kind="location", collision=state)


def test_pairs_that_collided_are_counted_whoever_is_named_first_and_the_least_is_drawn() -> None:
    trace = searched()
    assert pairs(trace.entries) == []
    for depth in (0.03, 0.012):
        collided(trace, "cup", "effector/left", depth)
    collided(trace, "floor", "arm/wrist", -0.002)
    collided(trace, "effector/left", "cup", 0.02)
    often, once = pairs(trace.entries)
    assert (often.between, often.depths) == (("cup", "effector/left"), "12.0 to 30.0 mm inside each other")
    assert (once.between, once.depths, len(once.entries)) == (("floor", "arm/wrist"), "2.0 mm apart", 1)
    collided(trace, "floor", "arm/wrist", 0.004)
    assert pairs(trace.entries)[1].depths == "from 2.0 mm apart to 4.0 mm inside each other"


def test_a_trace_with_collisions_is_read_back() -> None:
    trace = Trace()
    collided(trace, "cup", "effector/left", 0.03)
    assert Trace.from_json(trace.to_json()).entries == trace.entries


def test_reasons_are_alike_whatever_their_numbers_are() -> None:
    trace = searched()
    for depth in (0.03, 0.012):
        collided(trace, "cup", "effector/left", depth)
    first, *others = reasons(trace.entries)
    assert (first.count, first.first.reason) == (2, "at the grasp: 'cup' is 30.0 mm inside 'effector/left'")
    assert [r.count for r in others] == [1, 1]
