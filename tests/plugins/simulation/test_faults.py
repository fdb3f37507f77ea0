"""Faults happen when their triggers hold, and do what they say; without them the same program comes to its end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

from cramlite import UserError
from cramlite.model import Fault, FaultKind, Rollout, Trigger, World
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.scenario.faults import faulty, foreseen, left_over, read_fault_text
from cramlite.scenario.worlds import read_world
from cramlite_plugins.simulation.faults import _lines_with

PROGRAM = """def p():
  movej([3.272, -1.4026, 1.8656, -2.0337, -1.5708, 1.7012], a=1.4, v=1.05)
  # waiting for what may come
  sleep(1.0)
  textmsg("done")
end
"""


@pytest.fixture(scope="module")
def knowledge() -> Knowledge:
    return Knowledge(Registry())


@pytest.fixture(scope="module")
def place(knowledge: Knowledge) -> World:
    return read_world(str(ROOT / "scenarios" / "compound" / "pick_and_place.yaml"), knowledge, 0)


def run(knowledge: Knowledge, place: World, *faults: str) -> Rollout:
    world = faulty(place, map(read_fault_text, faults))
    return knowledge.simulator.execute(PROGRAM, world, knowledge.robots_of(world), mount="arm", seed=0)


def at(rollout: Rollout, name: str) -> list[float]:
    return [round(float(v), 2) for v in rollout.poses[name][-1][:3]]


@pytest.mark.heavy
def test_things_move_when_the_tool_comes_near(knowledge: Knowledge, place: World) -> None:
    quiet = run(knowledge, place)
    moved = run(knowledge, place, "moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m")
    assert quiet.outcome == moved.outcome == "finished" and not quiet.faults
    (happened,) = moved.faults
    assert 0.5 < happened.time < moved.times[-1] and happened.text == "'block' is moved by +0, +0.06, +0 m 0.18 m from 'block'"
    assert at(quiet, "block")[1] == 0.20 and at(moved, "block")[1] == 0.26


@pytest.mark.heavy
def test_what_falls_over_lies_and_what_is_taken_is_gone(knowledge: Knowledge, place: World) -> None:
    fallen = run(knowledge, place, "fallen: block, line: waiting")
    assert fallen.outcome == "finished" and fallen.faults[0].line >= 4 and at(fallen, "block")[2] == 0.02
    gone = run(knowledge, place, "missing: block, line: waiting, after: 0.5 s")
    assert at(gone, "block")[2] < -40 and gone.poses["block"][0][2] > 0


@pytest.mark.heavy
def test_what_would_get_into_a_finger_waits_until_that_is_gone(knowledge: Knowledge, place: World) -> None:
    away = PROGRAM.replace('textmsg("done")', "movej([2.6, -1.4026, 1.4, -2.0337, -1.5708, 1.7012], a=1.4, v=1.05)\n  sleep(0.5)")
    world = faulty(place, [read_fault_text("moved: block, by: [0, 40 mm, 60 mm], line: waiting")])
    rollout = knowledge.simulator.execute(away, world, knowledge.robots_of(world), mount="arm", seed=0)
    (happened,) = rollout.faults
    assert happened.line > 4 and rollout.contact_force().max() < 25.0
    stays = knowledge.simulator.execute(PROGRAM, world, knowledge.robots_of(world), mount="arm", seed=0)
    assert stays.outcome == "finished" and not stays.faults and at(stays, "block") == at(run(knowledge, place), "block")
    between = run(knowledge, place, "moved: block, by: [0, 0, 60 mm], line: waiting")
    assert between.faults[0].line == 4, "there is room between the open fingers"


@pytest.mark.heavy
def test_what_is_added_waits_and_is_no_part_of_what_is_believed(knowledge: Knowledge, place: World) -> None:
    world = faulty(place, [read_fault_text("added: block, by: [0, 50 mm, 0], line: waiting")])
    assert [t.name for t in foreseen(world.faults, world).things] == ["floor", "shelf"]
    rollout = run(knowledge, place, "added: block, by: [0, 50 mm, 0], line: waiting")
    assert rollout.poses["block"][5][2] < -40 and at(rollout, "block")[1:] in ([0.25, 0.04], [0.25, 0.05])


@pytest.mark.heavy
def test_programs_are_stopped_and_killed(knowledge: Knowledge, place: World) -> None:
    killed = run(knowledge, place, "killed: true, line: waiting")
    assert killed.outcome == "killed" and not killed.messages
    stopped = run(knowledge, place, "protective_stop: 1 s")
    assert stopped.outcome == "protective stop" and abs(stopped.faults[0].time - 1.0) < 0.02


@pytest.mark.parametrize("kind", [FaultKind.TOOL, FaultKind.SENSOR])
@pytest.mark.parametrize("when", [{"trigger": Trigger("waiting")}, {"after": 1.0}])
def test_a_tool_and_a_sensor_are_off_from_the_start_or_not_at_all(place: World, kind: FaultKind, when: dict[str, Any]) -> None:
    assert faulty(place, [Fault(kind, by=(0.001, 0.0, 0.0))]).disturbance != place.disturbance
    with pytest.raises(UserError, match="is present from the start, and has neither trigger nor time"):
        faulty(place, [Fault(kind, by=(0.001, 0.0, 0.0), **when)])


def test_a_line_that_is_not_there_is_no_trigger(knowledge: Knowledge, place: World, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no line of the program has that text"):
        run(knowledge, place, "killed: true, line: Grasping")
    world = faulty(place, left_over([read_fault_text("killed: true, line: Grasping")], [], 1.0))
    later = knowledge.simulator.execute(PROGRAM, world, knowledge.robots_of(world), mount="arm", seed=0)
    assert later.outcome == "finished" and not later.faults, "a program after the first one need not have the line"


def test_a_trigger_is_reached_at_any_line_of_the_block_below_a_comment() -> None:
    text = "# P lifts\ndef p():\n  global a = 1\n  # 1.A/transfer: there\n  go(a)\n  go(b)\n  if c:\n    d()\n\n  e()\n"
    assert _lines_with("1.A/transfer", text) == {4, 5, 6, 7}
    assert _lines_with("lifts", text) == {1, 2}, "the lines of a definition are deeper than its heading"
