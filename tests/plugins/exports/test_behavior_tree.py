"""BehaviorTree.CPP reads the trees, knows every node from the manifest, and does things in the order of the program."""

from __future__ import annotations

import re
from collections.abc import Iterable, Set
from typing import Any
from xml.etree import ElementTree

import pytest
from conftest import Proven
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import AnyStep, Fallback, Monitor, Parallel, Pose, Program, Repeat, SetGripper, Wait
from cramlite_plugins.exports.behavior_tree import FORCE, SLIP, safe_name, tree_xml

bt = pytest.importorskip("behaviortreepy", reason="the foreign reader of trees")
SUCCESS, FAILURE = bt.NodeStatus.SUCCESS, bt.NodeStatus.FAILURE


def ticked(text: str, failing: Set[str] = frozenset()) -> tuple[bool, list[str]]:
    """Run a tree in BehaviorTree.CPP: whether it succeeded, and the names of its action nodes in the order in which they were done."""
    factory, done, failing_names = bt.BehaviorTreeFactory(), [], set(map(safe_name, failing))

    def tick(node: Any) -> Any:
        done.append(node.name())
        return FAILURE if done[-1] in failing_names else SUCCESS

    for entry in ElementTree.fromstring(text).iterfind("TreeNodesModel/*"):
        if entry.tag == "Condition":
            factory.register_simple_condition(entry.attrib["ID"], lambda node: SUCCESS)
        else:
            factory.register_simple_action(entry.attrib["ID"], tick)
    factory.register_behavior_tree_from_text(without_ports(text))
    main = ElementTree.fromstring(text).attrib["main_tree_to_execute"]
    return factory.create_tree(main).tick_while_running() == SUCCESS, done


def without_ports(text: str) -> str:
    """The same tree for nodes made by behaviortreepy, which declare no ports; each port must be in the manifest."""
    root = ElementTree.fromstring(text)
    ports = {e.attrib["ID"]: {p.attrib["name"] for p in e} for e in root.iterfind("TreeNodesModel/*")}
    for node in root.iter():
        if node.tag in ports:
            assert set(node.attrib) - {"name"} <= ports[node.tag]
            node.attrib = {k: v for k, v in node.attrib.items() if k == "name"}
    root.remove(next(root.iter("TreeNodesModel")))
    return ElementTree.tostring(root, encoding="unicode")


def done_by(steps: Iterable[AnyStep], failing: Set[str]) -> tuple[bool, list[str]]:
    """What the plan language says of the same steps: whether they succeed, and what is done."""
    done: list[str] = []
    for step in steps:
        passed, inner = _done(step, failing)
        done += inner
        if not passed:
            return False, done
    return True, done


def _done(step: AnyStep, failing: Set[str]) -> tuple[bool, list[str]]:
    if isinstance(step, Fallback):
        done: list[str] = []
        for branch in step.branches:
            passed, inner = done_by(branch, failing)
            done += inner
            if passed:
                return True, done
        return False, done
    if isinstance(step, Repeat):
        return done_by(step.steps * step.count, failing)
    if isinstance(step, Monitor):
        return done_by(step.steps, failing)
    return step.origin not in failing, [safe_name(step.origin)]


def program(steps: Iterable[AnyStep]) -> Program:
    return Program("made", "arm", "ur5e", Pose(), (0.0,) * 6, tuple(steps), ())


LEAVES = st.integers(1, 9).map(lambda n: Wait(duration=0.1, origin=f"1.Waiting/{n}"))


def _controls(inner: st.SearchStrategy[AnyStep]) -> st.SearchStrategy[AnyStep]:
    some = st.lists(inner, min_size=1, max_size=3).map(tuple)
    return (
        st.lists(some, min_size=1, max_size=3).map(lambda b: Fallback(branches=tuple(b), origin="1.Waiting/fallback"))
        | st.tuples(some, st.integers(1, 3)).map(lambda p: Repeat(steps=p[0], count=p[1], origin="1.Waiting/repeat"))
        | some.map(lambda steps: Monitor(steps=steps, force=20.0, slip=0.01, time=5.0, origin="1.Waiting/monitor"))
    )


@given(st.lists(st.recursive(LEAVES, _controls, max_leaves=6), min_size=1, max_size=4), st.sets(st.integers(1, 9), max_size=4))
def test_order_fallbacks_and_loops_are_those_of_the_program(steps: list[AnyStep], failing: set[int]) -> None:
    fails = {f"1.Waiting/{n}" for n in failing}
    assert ticked(tree_xml(program(steps)), fails) == done_by(steps, fails)


@pytest.mark.parametrize(
    ("until", "failing", "passes"), [("all", "1.A/b", False), ("first", "1.A/b", True), ("first", "1.A/a 1.A/b", False)]
)
def test_parallel_branches_need_all_or_one(until: Any, failing: str, passes: bool) -> None:
    branches = ((Wait(duration=0.1, origin="1.A/a"),), (SetGripper(opening=0.0, speed=0.1, force=20.0, origin="1.A/b"),))
    text = tree_xml(program([Parallel(branches=branches, until=until, origin="1.A/both")]))
    assert ticked(text, set(failing.split()))[0] is passes


def test_monitors_watch_what_they_were_told_to() -> None:
    text = tree_xml(program([Monitor(steps=(Wait(duration=0.1, origin="1.A/w"),), force=12.5, time=2.0, origin="1.A/watch")]))
    root = ElementTree.fromstring(text)
    assert [e.attrib["limit"] for e in root.iter(FORCE) if "limit" in e.attrib] == ["60.0", "12.5"]
    assert next(root.iter("Timeout")).attrib["msec"] == "2000"
    assert not list(root.iter(SLIP))


@pytest.mark.heavy
def test_a_proven_program_runs_as_a_tree(proven: Proven) -> None:
    made = proven("retry_on_hanger").program
    text = tree_xml(made)
    assert ticked(text) == done_by(made.steps, set())
    assert ticked(text, {made.steps[0].origin}) == (False, [safe_name(made.steps[0].origin)])


def test_a_node_that_nobody_implements_is_refused_by_name() -> None:
    text = tree_xml(program([Wait(duration=0.1, origin="1.A/w")]))
    factory = bt.BehaviorTreeFactory()
    factory.register_simple_condition(FORCE, lambda node: SUCCESS)
    with pytest.raises(RuntimeError, match="Wait"):
        factory.create_tree_from_text(text)


def test_names_have_no_character_that_is_refused() -> None:
    text = tree_xml(program([Wait(duration=0.1, origin="12.A/b/c")]))
    names = re.findall(r' (?:ID|name|main_tree_to_execute)="([^"]*)"', text)
    assert names and all(re.fullmatch(r"\w+", n) for n in names)


def test_every_action_says_on_the_blackboard_why_it_failed() -> None:
    watched = Monitor(steps=(Wait(duration=0.1, origin="1.A/v"),), force=5.0, origin="1.A/m")
    text = tree_xml(program([Wait(duration=0.1, origin="1.A/w"), watched]))
    root = ElementTree.fromstring(text)
    assert {e.attrib["notice"] for e in root.iter("Wait")} == {"{notice}"}
    (port,) = root.iterfind("TreeNodesModel/Action[@ID='Wait']/output_port")
    assert port.attrib == {"name": "notice", "type": "std::string"} and "kind" in (port.text or "")
    assert not list(root.iterfind("TreeNodesModel/Condition/output_port"))
