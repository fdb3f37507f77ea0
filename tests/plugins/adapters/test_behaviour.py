"""py_trees: a tree resolves and runs designators one after another, fails with the reason, and can be interrupted."""

from __future__ import annotations

import time

import pytest

from cramlite import Engine, Goal, TaskSpec, find_scenario, read_scenario

py_trees = pytest.importorskip("py_trees")

from cramlite_plugins.adapters.behaviour import Place, Resolve  # noqa: E402

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


def test_an_interrupted_behaviour_stops_its_search() -> None:
    place = _place("place_on_shelf")
    node = Resolve("shelve", ENGINE, Goal(("block on shelf",)), place.now, place.run)
    node.tick_once()
    assert node.status == STATUS.RUNNING
    node.stop(STATUS.INVALID)
    assert node.solution is None
