"""The search, with small plugins in files: order, backjumping, no-goods, caps, budgets, faults."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from cramlite import Budget, Trace
from cramlite.base.errors import PluginError
from cramlite.base.seeds import derive_seed
from cramlite.model import Action, Belief, Location, Object, RobotMount, World
from cramlite.planning.refutation import Later, refutation
from cramlite.planning.search.budget import BudgetSpent
from cramlite.planning.search.choice_point import CAPS
from cramlite.planning.search.search import Search
from cramlite.planning.search.state import State
from cramlite.plugin import Context, UserError
from cramlite.plugin.entry_points import GROUP
from cramlite.plugin.registry import Registry
from cramlite.plugin.task_type import task_type

Plugin = Callable[[str, str], Path]
OWN = tuple(p.name for p in importlib.metadata.entry_points(group=GROUP))

OBJECTS = """
@hookimpl
def resolve_object(designator, belief, context):
    return [Grounding(f"{designator.name}_{k}", f"number {k}", cost=k) for k in range(COUNT)]
"""
PLACES = """
ASKED = []
@hookimpl
def resolve_location(location, belief, context):
    ASKED.append(location.name)
    if location.relation == "far":
        raise Unresolvable("reach 0.91 m > 0.85 m", because=(location.of,))
    return [Grounding(Stand(Pose(), f"{location.name}_{k}"), f"number {k}", cost=k, key=f"{location.name}_{k}") for k in range(COUNT)]
"""

KIND = """
from cramlite.plugin import LocationKind

class Height(Value):
    height_m: float

def over(location, belief, context):
    yield Grounding(Stand(Pose((0, 0, location.parameters["height_m"])), "NAME"), "over", key="NAME")

@hookimpl
def location_kinds():
    return [LocationKind("over", "Over it.", over, "a thing", Height)]
"""


class Trial:
    """One search over designators, with the plugins of some files and no others."""

    def __init__(self, *files: Path, budget: Budget | None = None, preferred: tuple[str, ...] = ()) -> None:
        self.registry = Registry(files, blocked=OWN, preferred=preferred)
        self.trace = Trace()
        tasks = {t.task: t for _, t in self.registry.collect("task_types")}
        owners = {t.task: plugin for plugin, t in self.registry.collect("task_types")}
        context = Context(None, RobotMount("arm", "none"), {}, None, seed=5)  # type: ignore[arg-type]
        self.search = Search(self.registry, tasks, owners, context, self.trace, budget or Budget())

    def bindings(self, *agenda: Any) -> list[dict[str, Any]]:
        belief = Belief(World(()), {}, "arm", (), 0.0)
        return [dict(s.bindings) for s in self.search.solve(State(agenda, belief))]

    def outcomes(self, designator: str, outcome: str) -> list[str]:
        return [e.text for e in self.trace.entries if (e.designator, e.outcome) == (designator, outcome)]

    def module(self, name: str) -> Any:
        return self.registry._manager.get_plugin(name)


def _with(body: str, count: int) -> str:
    return f"COUNT = {count}\n{body}"


def _cost(costs: Sequence[float]) -> str:
    return (
        "@hookimpl\ndef resolve_object(designator, belief, context):\n"
        f"    for c in {list(costs)}:\n        yield Grounding(f'at {{c}}', 'because', cost=c)\n"
    )


def test_alternatives_of_plugins_are_merged_by_cost(plugin: Plugin) -> None:
    trial = Trial(plugin("even", _cost([0, 2, 4])), plugin("odd", _cost([1, 3])))
    assert [b["cup"] for b in trial.bindings(Object("cup"))] == [f"at {c}" for c in range(5)]


def test_answers_are_taken_one_at_a_time(plugin: Plugin) -> None:
    body = (
        "TAKEN = []\n@hookimpl\ndef resolve_object(designator, belief, context):\n"
        "    for k in range(100):\n        TAKEN.append(k)\n        yield Grounding(str(k), 'x', cost=k)\n"
    )
    trial = Trial(plugin("lazy", body))
    belief = Belief(World(()), {}, "arm", (), 0.0)
    next(trial.search.solve(State((Object("cup"),), belief)))
    assert len(trial.module("lazy").TAKEN) <= 2


def test_search_jumps_over_choices_that_do_not_matter(plugin: Plugin) -> None:
    """The k-th grasp is not tried because the basket is out of reach."""
    trial = Trial(plugin("my_objects", _with(OBJECTS, 2)), plugin("my_places", _with(PLACES, 5)))
    agenda = (Object("tea"), Object("basket"), Location("grasp", "grasp", "tea"), Location("in", "far", "basket"))
    assert trial.bindings(*agenda) == []
    assert len(trial.outcomes("in", "asked")) == 2, "once for each basket"
    assert len(trial.outcomes("grasp", "asked")) == 2, "not once more for any of its five alternatives"


def test_without_a_cause_every_choice_is_tried(plugin: Plugin) -> None:
    body = PLACES.replace(", because=(location.of,)", "")
    trial = Trial(plugin("my_objects", _with(OBJECTS, 2)), plugin("my_places", _with(body, 5)))
    agenda = (Object("tea"), Object("basket"), Location("grasp", "grasp", "tea"), Location("in", "far", "basket"))
    assert trial.bindings(*agenda) == []
    assert len(trial.outcomes("in", "asked")) > 4


def test_a_combination_that_failed_is_not_tried_again(plugin: Plugin) -> None:
    trial = Trial(plugin("my_objects", _with(OBJECTS, 2)))
    belief = Belief(World(()), {}, "arm", (), 0.0)
    states = trial.search.solve(State((Object("tea"), Object("basket")), belief))
    found = [dict(next(states).bindings)]
    try:
        while True:
            found.append(dict(states.send(frozenset({"basket"})).bindings))
    except StopIteration:
        pass
    assert found == [{"tea": "tea_0", "basket": "basket_0"}, {"tea": "tea_0", "basket": "basket_1"}]


def test_choices_for_later_are_varied_after_all_others_and_none_is_left_out(plugin: Plugin) -> None:
    """As the height of a lift after a thing slipped: first the other grasps, then the other heights with each of them."""
    trial = Trial(plugin("my_objects", _with(OBJECTS, 2)))
    belief = Belief(World(()), {}, "arm", (), 0.0)
    states = trial.search.solve(State((Object("grasp"), Object("lift")), belief))
    found = [dict(next(states).bindings)]
    try:
        while True:
            found.append(dict(states.send(frozenset({"grasp", Later("lift")})).bindings))
    except StopIteration:
        pass
    assert [(b["grasp"][-1], b["lift"][-1]) for b in found] == [("0", "0"), ("1", "0"), ("0", "1"), ("1", "1")]


def test_choice_points_are_capped(plugin: Plugin) -> None:
    trial = Trial(plugin("my_objects", _with(OBJECTS, 50)))
    assert len(trial.bindings(Object("tea"))) == CAPS[Object]
    (capped,) = [e for e in trial.trace.entries if e.outcome == "capped"]
    assert (capped.kind, capped.numbers) == ("object", {"tried": CAPS[Object]})


def test_asks_are_counted(plugin: Plugin) -> None:
    trial = Trial(plugin("my_objects", _with(OBJECTS, 5)), budget=Budget(expansions=3))
    trial.bindings(*(Object(f"cup{k}") for k in range(5)))
    last = trial.trace.entries[-1]
    assert "3 nodes were expanded" in last.reason
    assert (last.kind, last.text, last.numbers) == ("budget", "expansions = 3", {"expansions": 3})


def test_a_spent_budget_says_which_one_it_was(plugin: Plugin, monkeypatch: pytest.MonkeyPatch) -> None:
    def spent(search: Search) -> None:
        raise BudgetSpent("samples", "7 samples were drawn")

    trial = Trial(plugin("my_objects", _with(OBJECTS, 5)), budget=Budget(samples=7))
    monkeypatch.setattr(Search, "_count", spent)
    assert trial.bindings(Object("cup")) == []
    last = trial.trace.entries[-1]
    assert (last.text, last.numbers, last.reason) == ("samples = 7", {"samples": 7}, "7 samples were drawn")


def test_a_generator_without_answers_and_one_that_says_none(plugin: Plugin) -> None:
    silent = "@hookimpl\ndef resolve_object(designator, belief, context):\n    return None\n    yield\n"
    trial = Trial(plugin("silent", silent), plugin("my_objects", _with(OBJECTS, 1)))
    assert trial.bindings(Object("tea")) == [{"tea": "tea_0"}]
    assert trial.registry.faults == []


def test_nobody_answers() -> None:
    trial = Trial()
    assert trial.bindings(Object("tea")) == []
    assert any("no plugin resolves tea" in e.reason for e in trial.trace.entries)


@pytest.mark.parametrize("answer", ["['tea']", "[None]", "5"])
def test_answers_of_a_wrong_type_are_the_plugins_fault(answer: str, plugin: Plugin) -> None:
    wrong = f"@hookimpl\ndef resolve_object(designator, belief, context):\n    return {answer}\n"
    trial = Trial(plugin("wrong", wrong), plugin("my_objects", _with(OBJECTS, 1)))
    assert trial.bindings(Object("tea")) == [{"tea": "tea_0"}]
    (fault,) = trial.registry.faults
    assert (fault.plugin, fault.hook, fault.designator) == ("wrong", "resolve_object", "tea")


def test_refusals_reach_the_trace(plugin: Plugin) -> None:
    body = "@hookimpl\ndef resolve_object(designator, belief, context):\n    yield Refused('tin', 'it has no hole')\n"
    trial = Trial(plugin("my_objects", body))
    assert trial.bindings(Object("tea")) == []
    assert trial.outcomes("tea", "refused") == ["tin"]


def test_numbers_of_a_refusal_reach_the_trace(plugin: Plugin) -> None:
    body = """
@hookimpl
def resolve_object(designator, belief, context):
    yield Refused("tin", "0.91 m > 0.85 m", numbers={"gap_m": 0.91, "limit_m": 0.85})
    raise Unresolvable("9 N > 5 N", numbers={"least_N": 9.0, "limit_N": 5.0})
"""
    trial = Trial(plugin("my_objects", body))
    assert trial.bindings(Object("tea")) == []
    found = [(e.kind, e.outcome, e.numbers) for e in trial.trace.entries if e.plugin == "my_objects"]
    assert found == [
        ("object", "refused", {"gap_m": 0.91, "limit_m": 0.85}), ("object", "impossible", {"least_N": 9.0, "limit_N": 5.0}),
    ]  # fmt: skip


def test_numbers_that_are_none_are_the_plugins_fault(plugin: Plugin) -> None:
    body = "@hookimpl\ndef resolve_object(designator, belief, context):\n    yield Refused('tin', 'far', numbers={'gap_m': 'far'})\n"
    trial = Trial(plugin("wrong", body), plugin("my_objects", _with(OBJECTS, 1)))
    assert trial.bindings(Object("tea")) == [{"tea": "tea_0"}]
    (fault,) = trial.registry.faults
    assert fault.plugin == "wrong" and "numbers must each have a name" in str(fault)


TASK = """
class Task(TaskType):
    task = "x:Task"
    def decompose(self, action, belief):
        {decompose}
    def effects(self, action, belief):
        {effects}

@hookimpl
def task_types():
    return [Task()]
"""
FINE = {"decompose": "return [Decomposition((), 'nothing to do')]", "effects": "return belief"}


def test_what_a_task_asks_for_says_in_which_it_is(plugin: Plugin) -> None:
    body = TASK.format(decompose="return [Decomposition((Location('there', 'at'),), 'one place')]", effects="return belief")
    trial = Trial(plugin("my_task", body), plugin("my_places", _with(PLACES, 1)))
    assert len(trial.bindings(Location("first", "at"), Action("1.Task", "x:Task"), Action("2.Task", "x:Task"))) == 1
    asked = [(e.designator, e.kind, e.numbers) for e in trial.trace.entries if e.outcome == "asked"]
    assert asked == [
        ("first", "location", {}), ("1.Task", "action", {"task": 1, "depth": 0}), ("there", "location", {"task": 1, "depth": 1}),
        ("2.Task", "action", {"task": 2, "depth": 0}),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "solutions", "faults"),
    [
        ({}, 1, []),
        ({"decompose": "return None"}, 0, ["decompose"]),
        ({"decompose": "raise KeyError('x')"}, 0, ["decompose"]),
        ({"decompose": "raise Unresolvable('holds nothing')"}, 0, []),
        ({"effects": "raise KeyError('x')"}, 0, ["effects"]),
    ],
)
def test_task_types_that_break(change: dict[str, str], solutions: int, faults: list[str], plugin: Plugin) -> None:
    trial = Trial(plugin("task", TASK.format(**{**FINE, **change})))
    assert len(trial.bindings(Action("1.Task", "x:Task"))) == solutions
    assert [f.hook for f in trial.registry.faults] == faults


def test_an_override_comes_before_the_tasks_own_way(plugin: Plugin) -> None:
    override = (
        "@hookimpl\ndef resolve_action(action, belief, context):\n"
        "    return [Grounding(Decomposition((), 'mine'), 'mine', key='mine')]\n"
    )
    trial = Trial(plugin("task", TASK.format(**FINE)), plugin("override", override))
    trial.bindings(Action("1.Task", "x:Task"))
    assert trial.outcomes("1.Task", "chosen") == ["mine", "nothing to do"]


def test_hooks_are_asked_in_the_order_of_the_agenda(plugin: Plugin) -> None:
    body = "ASKED = []\n" + "".join(
        f"@hookimpl\ndef resolve_{kind}({argument}, belief, context):\n"
        f"    ASKED.append({argument}.name)\n    return [Grounding({value}, 'x')]\n"
        for kind, argument, value in (("object", "designator", "'x'"), ("location", "location", "Stand(Pose())"))
    )
    trial = Trial(plugin("order", body))
    agenda = (Object("tea"), Location("grasp", "grasp", "tea"), Object("basket"), Location("grasp", "grasp", "tea"))
    trial.bindings(*agenda)
    assert trial.module("order").ASKED == ["tea", "grasp", "basket"], "what is bound is not asked again"


def test_seeds_follow_the_choice_path() -> None:
    path = (("tea", "tea_0"),)
    assert derive_seed(1, path, "grasp") == derive_seed(1, path, "grasp")
    others = [derive_seed(2, path, "grasp"), derive_seed(1, (), "grasp"), derive_seed(1, path, "place")]
    assert derive_seed(1, path, "grasp") not in others


def test_task_names(plugin: Plugin) -> None:
    tasks = Trial(plugin("task", TASK.format(**FINE))).search.tasks
    assert task_type(tasks, "Task") is task_type(tasks, "x:Task")
    with pytest.raises(UserError, match="did you mean 'Task'"):
        task_type(tasks, "Tasc")


NESTED = """
class Part(TaskType):
    aliases = ()
    def __init__(self, task, ways):
        self.task, self.ways = task, ways
    def decompose(self, action, belief):
        for k, parts in enumerate(self.ways):
            steps = tuple(Action(action.inside(f"{{k}}{{p[2:]}}"), p, action.roles) for p in parts)
            yield Decomposition(steps, f"way {{k}}", cost=k)

@hookimpl
def task_types():
    return [Part(task, ways) for task, ways in {ways}.items()]
"""


@pytest.mark.parametrize(
    ("ways", "solutions", "says"),
    [
        ({"x:A": [["x:A"]]}, 0, "a cyclic decomposition: x:A > x:A"),
        ({"x:A": [["x:B"]], "x:B": [["x:A"]]}, 0, "a cyclic decomposition: x:A > x:B > x:A, with the same objects"),
        ({"x:A": [["x:B"], []], "x:B": [["x:A"]]}, 1, "a cyclic decomposition"),  # another way that ends
        ({"x:A": [["x:B", "x:B"]], "x:B": [[]]}, 1, ""),  # twice is no cycle
        ({"x:A": [["x:Bcd"]], "x:Bce": [[]]}, 0, "no task 'x:Bcd', which the decomposition of 'x:A' names; did you mean 'x:Bce'"),
    ],
)
def test_what_tasks_are_made_of(
    ways: dict[str, list[list[str]]], solutions: int, says: str, plugin: Plugin
) -> None:
    trial = Trial(plugin("parts", NESTED.format(ways=ways)))
    assert len(trial.bindings(Action("1.A", "x:A"))) == solutions
    said = [e.reason for e in trial.trace.entries if e.outcome == "impossible"]
    assert any(says in s for s in said) if says else not said
    assert not trial.registry.faults
    assert len(trial.trace.entries) < 40  # it is seen at once, not when the budget is spent


TAKEN = """
@hookimpl
def resolve_object(designator, belief, context):
    for entity in (("basket", "table") if designator.name == "under" else ("basket",)):
        by = next((k for k, v in context.bindings.items() if v == entity), None)
        yield Refused(entity, "taken", because=BECAUSE and (by,) or ()) if by else Grounding(entity, "fits")
"""


@pytest.mark.parametrize("because", [True, False])
def test_a_refusal_names_the_choice_that_is_to_blame(plugin: Plugin, because: bool) -> None:
    trial = Trial(plugin("taken", f"BECAUSE = {because}\n{TAKEN}"))
    found = trial.bindings(Object("under"), Object("into"))
    assert found == ([{"under": "table", "into": "basket"}] if because else [])  # not named, not gone back to


ODD_MOTIONS = """
from cramlite.plugin import Decomposition, TaskType
class Slide(TaskType):
    task = "cram:Sliding"
    summary = "a motion of a kind that nobody knows"
    def decompose(self, action, belief):
        yield Decomposition((Location("place", "there"), Motion(action.inside("go"), "slyde", Location("place", "there"))), "odd")
@hookimpl
def task_types():
    return [Slide()]
"""


def test_a_motion_that_nobody_resolves_is_not_cured_by_another_place(plugin: Plugin) -> None:
    trial = Trial(plugin("my_places", _with(PLACES, 5)), plugin("odd", ODD_MOTIONS))
    assert trial.bindings(Action("1.Sliding", "cram:Sliding")) == []
    assert len(trial.outcomes("place", "chosen")) == 1
    assert [e.reason for e in trial.trace.entries if "no plugin resolves" in e.reason]


TWO_WAYS = """
from cramlite.plugin import Decomposition, TaskType
class Task(TaskType):
    task = "x:Task"
    def decompose(self, action, belief):
        yield Decomposition((Location(action.inside("away"), "retreat"),), "back first")
        yield Decomposition((), "as it is", 1.0)
@hookimpl
def task_types():
    return [Task()]
@hookimpl
def resolve_location(location, belief, context):
    yield Refused("120 mm back", "out of reach", blocking=BLOCKING)
"""


@pytest.mark.parametrize("blocking", [(), ("tea",), None])
def test_where_a_place_within_a_task_is_refused_the_task_is_tried_in_another_way(plugin: Plugin, blocking: tuple[str, ...] | None) -> None:
    """That nothing, or a thing, is in the way does not say that the place has to be asked for."""
    trial = Trial(plugin("two_ways", f"BLOCKING = {blocking!r}\n{TWO_WAYS}"))
    assert len(trial.bindings(Action("1.Task", "x:Task"))) == 1
    assert trial.outcomes("1.Task", "chosen") == ["back first", "as it is"]


NO_ROOM = """
from cramlite.plugin import Decomposition, TaskType
class Task(TaskType):
    task = "x:Task"
    def decompose(self, action, belief):
        yield Decomposition((Location(action.inside("spot"), "at"),), "there")
@hookimpl
def task_types():
    return [Task()]
@hookimpl
def resolve_location(location, belief, context):
    if location.name.startswith("1.") or context.bindings["1.Task/spot"].thing == ROOM_AFTER:
        yield from (Grounding(Stand(Pose(), str(k)), f"spot {k}", key=str(k)) for k in range(9))
    else:
        yield Refused("a spot", "no room", blocking=("tea",))
"""


@pytest.mark.parametrize(
    ("room_after", "expansions", "solved", "says"),
    [
        ("never", 6, 0, ((2,), (("tea",),))),
        ("never", 3, 0, None),  # the second task did not fail yet
        ("2", 9, 9, None),  # what comes behind a grounded state says nothing of the tasks
    ],
)
def test_a_spent_budget_still_says_in_which_task_it_failed_and_for_which_things(
    room_after: str, expansions: int, solved: int, says: tuple[Any, Any] | None, plugin: Plugin
) -> None:
    body = f"ROOM_AFTER = {room_after!r}\n{NO_ROOM}"
    trial = Trial(plugin("no_room", body), budget=Budget(expansions=expansions))
    assert len(trial.bindings(Action("1.Task", "x:Task"), Action("2.Task", "x:Task"))) == solved
    found = refutation(trial.search.refuted) if trial.search.refuted is not None else None
    assert (found and (found.tasks, found.things)) == says



NO_WAY = """
from cramlite.plugin import Decomposition, TaskType
class Task(TaskType):
    task = "x:Task"
    def decompose(self, action, belief):
        yield Decomposition((Location(action.inside("spot"), "at"), Location(action.inside("way"), "at")), "there")
@hookimpl
def task_types():
    return [Task()]
@hookimpl
def resolve_location(location, belief, context):
    if location.name.endswith("spot"):
        yield from (Grounding(Stand(Pose(), str(k)), f"spot {k}", key=str(k)) for k in range(9))
    else:
        yield Refused("a way", "no room", blocking=("tea",), because=("1.Task/spot",))
"""


@pytest.mark.parametrize(("expansions", "says"), [(6, ((1,), (("tea",),))), (2, None)])
def test_a_budget_spent_within_a_task_says_what_failed_in_it(expansions: int, says: tuple[Any, Any] | None, plugin: Plugin) -> None:
    """So the next plan moves what was in the way; where nothing failed yet, nothing is said."""
    trial = Trial(plugin("no_way", NO_WAY), budget=Budget(expansions=expansions))
    assert trial.bindings(Action("1.Task", "x:Task")) == []
    found = refutation(trial.search.refuted) if trial.search.refuted is not None else None
    assert (found and (found.tasks, found.things)) == says


# Declared relations


def test_a_declared_relation_is_grounded_by_its_function(plugin: Plugin) -> None:
    trial = Trial(plugin("one", KIND))
    (found,) = trial.bindings(Location("l", "over", None, {"height_m": 0.2}))
    assert found["l"].pose.position == (0, 0, 0.2)


@pytest.mark.parametrize(
    ("location", "says"),
    [
        (Location("l", "ovr"), "no plugin resolves ovr: no relation 'ovr'; did you mean 'over'? valid are: over"),
        (Location("l", "over", None, {"height": 0.2}), "the relation 'over' has no parameter 'height'; did you mean 'height_m'"),
        (Location("l", "over", None, {"height_m": "high"}), "the parameter 'height_m' of the relation 'over': expected `float`, got `str`"),
        (Location("l", "over"), "the relation 'over' needs the parameter 'height_m'"),
    ],
    ids=["relation", "parameter", "type", "needed"],
)
def test_what_a_location_says_wrongly_is_refused_with_what_there_is(plugin: Plugin, location: Location, says: str) -> None:
    trial = Trial(plugin("one", KIND))
    assert trial.bindings(location) == []
    (entry,) = [e for e in trial.trace.entries if e.outcome == "impossible"]
    assert says in entry.reason


def test_two_of_one_relation_are_an_error_unless_one_is_preferred(plugin: Plugin) -> None:
    files = [plugin(name, KIND.replace("NAME", name)) for name in ("one", "two")]
    with pytest.raises(PluginError, match="Plugins 'one' and 'two' both declare location_kind 'over'"):
        Trial(*files)
    (found,) = Trial(*files, preferred=("two",)).bindings(Location("l", "over", None, {"height_m": 0.2}))
    assert found["l"].thing == "two"
