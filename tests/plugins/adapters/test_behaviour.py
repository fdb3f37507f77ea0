"""py_trees: a tree resolves and runs designators one after another, fails with the reason, and can be interrupted."""

from __future__ import annotations

import threading
import time

import pytest
from msgspec.structs import replace

from cramlite import Engine, Goal, TaskSpec, find_scenario, read_scenario
from cramlite.scenario.faults import faulty, read_fault_text

py_trees = pytest.importorskip("py_trees")

from cramlite_plugins.adapters.behaviour import NOTICE, Place, Resolve, WatchedPlace  # noqa: E402

STATUS = py_trees.common.Status
ENGINE = Engine()


def _place(name: str) -> Place:
    return Place(ENGINE, ENGINE.setting(read_scenario(find_scenario(name))))


def _tick(tree: object, seconds: float = 300.0) -> object:
    """Tick until the root has an answer."""
    root, ends = tree, time.monotonic() + seconds
    root.tick_once()  # type: ignore[attr-defined]
    while root.status == STATUS.RUNNING and time.monotonic() < ends:  # type: ignore[attr-defined]
        time.sleep(0.02)
        root.tick_once()  # type: ignore[attr-defined]
    return root.status  # type: ignore[attr-defined]


@pytest.mark.heavy
def test_a_sequence_goes_on_where_the_run_before_ended() -> None:
    place = _place("place_on_shelf")
    before = place.now().world.thing("block").pose
    there = Resolve("shelve", ENGINE, Goal(("block on shelf",)), place.now, place.run)
    back = Resolve("unshelve", ENGINE, Goal(("block on floor",)), place.now, place.run)
    root = py_trees.composites.Sequence("there and back", memory=True, children=[there, back])
    assert _tick(root) == STATUS.SUCCESS
    assert "done" in back.feedback_message
    assert there.solution is not None and back.solution is not None
    assert ("on", "block", "floor") in place.now().relations
    assert place.now().world.thing("block").pose.distance(before)[0] > 0.01


def test_failure_says_why_and_a_selector_goes_on() -> None:
    place = _place("place_on_shelf")
    wrong = Resolve("lift", ENGINE, TaskSpec(task="PickingUp", roles={"Locatum": "block"}), place.now, place.run)
    unknown = Resolve("fly", ENGINE, TaskSpec(task="Flying"), place.now, place.run)
    grasp = Resolve("grasp", ENGINE, TaskSpec(task="Grasping", roles={"Patient": "block"}), place.now, lambda solution: False)
    root = py_trees.composites.Selector("one of them", memory=True, children=[wrong, unknown, grasp])
    assert _tick(root) == STATUS.FAILURE
    assert "must be grasped before" in wrong.feedback_message
    assert "There is no task type 'Flying'" in unknown.feedback_message
    assert "its run failed" in grasp.feedback_message


def test_no_tick_waits_for_a_search_or_a_run() -> None:
    """``run`` fails unless a tick returned while it ran; the message says what is being done."""
    place, go_on, said = _place("place_on_shelf"), threading.Event(), set[str]()
    node = Resolve("grasp", ENGINE, TaskSpec(task="Grasping", roles={"Patient": "block"}), place.now, lambda _: go_on.wait(60))
    ends = time.monotonic() + 300
    while node.status not in (STATUS.SUCCESS, STATUS.FAILURE) and time.monotonic() < ends:
        node.tick_once()
        said.add(node.feedback_message.split()[0].rstrip(":"))
        if "running" in said:
            go_on.set()
        time.sleep(0.01)
    assert node.status == STATUS.SUCCESS
    assert {"resolving", "running"} <= said


def test_an_interrupted_behaviour_stops_its_search() -> None:
    place = _place("place_on_shelf")
    node = Resolve("shelve", ENGINE, Goal(("block on shelf",)), place.now, place.run)
    node.tick_once()
    assert node.status == STATUS.RUNNING
    node.stop(STATUS.INVALID)
    assert node.solution is None


def test_an_interrupted_run_is_cancelled_and_the_next_one_waits_for_its_end() -> None:
    place, cancelled, began = _place("place_on_shelf"), threading.Event(), list[int]()

    def run(_: object) -> bool:
        began.append(1)
        return not cancelled.wait(300) if len(began) == 1 else True

    node = Resolve("grasp", ENGINE, TaskSpec(task="Grasping", roles={"Patient": "block"}), place.now, run, cancelled.set)
    while not began:
        node.tick_once()
        assert node.status == STATUS.RUNNING
        time.sleep(0.02)
    node.stop(STATUS.INVALID)
    assert cancelled.is_set()
    assert _tick(node) == STATUS.SUCCESS
    assert len(began) == 2


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("fault", "kind", "succeeds"),
    [("", None, True), ("moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m", "cram:ObjectMoved", True),
     ("missing: block, line: Grasping/transfer", "cram:ObjectMissing", False)],
)  # fmt: skip
def test_notices_of_a_watched_run_are_on_the_blackboard(fault: str, kind: str | None, succeeds: bool) -> None:
    scenario = read_scenario(find_scenario("place_on_shelf"))
    place = WatchedPlace(ENGINE, scenario)
    if fault:
        setting = place.now()
        place._setting = replace(setting, real=faulty(setting.real or setting.world, [read_fault_text(fault)]))
    shelve = Resolve("shelve", ENGINE, Goal(("block on shelf",)), place.now, place.run)
    assert _tick(shelve) == (STATUS.SUCCESS if succeeds else STATUS.FAILURE), shelve.feedback_message
    board = py_trees.blackboard.Client(name="reader")
    board.register_key(key=NOTICE, access=py_trees.common.Access.READ)
    told = board.get(NOTICE)
    assert (told and told["type"]) == kind and [f"cram:{n.kind}" for n in place.notices][-1:] == ([kind] if kind else [])
    if kind is not None:
        assert told["thing"] == "block" and told["reason"] and told["decision"] and told["to_do"]
    if succeeds:
        assert place.now().world.thing("block").pose.position[2] > 0.1
