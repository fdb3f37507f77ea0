"""The plan language: what is decided while planning, what becomes a control step, and what scenarios may write."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import Any

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Budget, Engine, Trace, read_scenario, task_entry
from cramlite.model import (
    Belief,
    Compound,
    Control,
    Fallback,
    Monitor,
    Motion,
    Parallel,
    Repeat,
    RobotMount,
    Wait,
    World,
    choose,
    fallback,
    monitor,
    parallel,
    repeat,
    retry,
    sequence,
    try_all,
    walk,
)
from cramlite.planning.search.search import Search
from cramlite.planning.search.state import State
from cramlite.plugin import Context, UserError
from cramlite.plugin.entry_points import GROUP
from cramlite.plugin.registry import Registry

OWN = tuple(p.name for p in importlib.metadata.entry_points(group=GROUP))
# Motions that stand still; "go" leads to a joint position, "no" is impossible, "back" is what the language asks for.
MOTIONS = """
from msgspec.structs import replace
@hookimpl
def resolve_motion(motion, belief, context):
    if motion.kind == "no":
        raise Unresolvable(f"{motion.name} cannot be done", because=())
    joints = motion.parameters["to"].joints if motion.kind == "back" else (motion.parameters.get("at", 0.0),)
    step = Wait(abs(belief.joints[0]), origin=motion.name)
    if motion.kind == "grip":
        step = SetGripper(0.0, 0.1, 20.0, origin=motion.name)
    return [Grounding((step,), "as asked", 0.0, replace(belief, joints=joints))]
"""


def go(name: str, at: float = 0.0) -> Motion:
    return Motion(name, "go", parameters={"at": at})


def no(name: str) -> Motion:
    return Motion(name, "no")


class Trial:
    def __init__(self, file: Path) -> None:
        self.trace = Trace()
        context = Context(None, RobotMount("arm", "none"), {}, None, seed=5)  # type: ignore[arg-type]
        self.search = Search(Registry((file,), blocked=OWN), {}, {}, context, self.trace, Budget())

    def states(self, *agenda: Any) -> Any:
        return self.search.solve(State(agenda, Belief(World(()), {}, "arm", (1.0,), 0.0)))

    def steps(self, *agenda: Any) -> tuple[Any, ...] | None:
        state = next(self.states(*agenda), None)
        return state.steps if state else None

    def reasons(self) -> str:
        return "; ".join(e.reason for e in self.trace.entries)


@pytest.fixture(scope="module")
def waits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("flow") / "waits.py"
    path.write_text(f"from cramlite.model import *\nfrom cramlite.plugin import *\n\n{MOTIONS}")
    return path


@pytest.fixture
def trial(waits: Path) -> Trial:
    return Trial(waits)


def names(steps: Any) -> list[str]:
    return [s.origin for s in walk(steps) if not isinstance(s, Control)]


# Decided while planning


def test_a_sequence_is_done_in_order_and_leaves_no_trace_in_the_program(trial: Trial) -> None:
    steps = trial.steps(sequence("1.sequence", go("a"), sequence("2.sequence", go("b"), go("c"))), go("d"))
    assert names(steps) == ["a", "b", "c", "d"]
    assert all(isinstance(s, Wait) for s in steps or ())


def test_a_sequence_fails_with_any_of_its_parts(trial: Trial) -> None:
    assert trial.steps(sequence("1.sequence", go("a"), no("b"), go("c"))) is None


def test_the_first_alternative_that_can_be_done_is_the_only_one_in_the_program(trial: Trial) -> None:
    assert names(trial.steps(choose("1.try", no("a"), go("b"), go("c")))) == ["b"]
    assert "c" not in {e.designator for e in trial.trace.entries}, "it stops at the first success"


def test_what_comes_up_in_a_task_says_in_which(trial: Trial) -> None:
    trial.steps(go("z"), sequence("1.sequence", go("a"), sequence("2.sequence", go("b"))), sequence("3.sequence", go("c")), go("y"))
    asked = {e.designator: (e.kind, dict(e.numbers)) for e in trial.trace.entries if e.outcome == "asked"}
    first, second = {"task": 1, "depth": 0}, {"task": 2, "depth": 0}
    assert asked == {
        "z": ("motion", {}), "1.sequence": ("compound", first), "a": ("motion", first), "2.sequence": ("compound", first),
        "b": ("motion", first), "3.sequence": ("compound", second), "c": ("motion", second), "y": ("motion", {}),
    }  # fmt: skip


def test_if_no_alternative_can_be_done_neither_can_the_whole(trial: Trial) -> None:
    assert trial.steps(go("z"), choose("1.try", no("a"), no("b"))) is None
    assert "a cannot be done" in trial.reasons() and "b cannot be done" in trial.reasons()


def test_an_alternative_whose_program_is_not_proven_gives_way_to_the_next(trial: Trial) -> None:
    states = trial.states(choose("1.try", go("a"), go("b")))
    assert names(next(states).steps) == ["a"]
    assert names(states.send(frozenset({"a"})).steps) == ["b"]


# Decided while the program runs


def test_attempts_are_all_in_the_program_and_each_begins_where_the_first_did(trial: Trial) -> None:
    steps = trial.steps(fallback("1.attempts", go("a", 2.0), go("b", 2.0), go("c", 2.0)), go("d"))
    assert steps is not None and isinstance(steps[0], Fallback) and len(steps) == 2
    assert [names(b) for b in steps[0].branches] == [
        ["a"], ["1.attempts/back_1", "b"], ["1.attempts/back_2", "c"],
    ]  # fmt: skip
    # Each was resolved for the joint position in which the attempts begin, and what follows for the one in which they end.
    assert [b[-1].duration for b in steps[0].branches] == [1.0, 1.0, 1.0]
    assert steps[1].duration == 2.0


def test_attempts_that_end_in_different_places_are_refused(trial: Trial) -> None:
    assert trial.steps(fallback("1.attempts", go("a", 2.0), go("b", 2.5))) is None
    assert "attempts 1 and 2 of '1.attempts' end in different ways: a joint differs by 0.50 rad" in trial.reasons()


def test_an_attempt_that_cannot_be_planned_is_no_attempt(trial: Trial) -> None:
    assert trial.steps(fallback("1.attempts", go("a"), no("b"))) is None


def test_a_retry_changes_parameters_and_nothing_else() -> None:
    part = Motion("search", "spiral_search", parameters={"radius_m": 0.003, "force_n": 3.0})
    again = retry("1.retry", part, {"radius_m": 0.008}, {"radius_m": 0.01}).branches
    assert [b[0].parameters["radius_m"] for b in again] == [0.003, 0.008, 0.01]  # type: ignore[union-attr]
    assert {b[0].parameters["force_n"] for b in again} == {3.0}  # type: ignore[union-attr]
    assert len({b[0].name for b in again}) == 3


def test_what_is_repeated_comes_back_to_where_it_began(trial: Trial) -> None:
    away, closed = trial.steps(repeat("1.repeat", 3, go("a", 2.0))), trial.steps(repeat("2.repeat", 2, go("b", 1.0)))
    assert away and closed and isinstance(away[0], Repeat) and isinstance(closed[0], Repeat)
    assert (away[0].count, names(away)) == (3, ["a", "1.repeat/back"])
    assert (closed[0].count, names(closed)) == (2, ["b"])


def test_parallel_parts_become_one_step(trial: Trial) -> None:
    steps = trial.steps(parallel("1.parallel", go("a"), Motion("b", "grip")))
    assert steps and isinstance(steps[0], Parallel) and steps[0].until == "all"
    assert [names(b) for b in steps[0].branches] == [["a"], ["b"]]


def test_two_parts_that_need_the_gripper_are_refused(trial: Trial) -> None:
    assert trial.steps(parallel("1.parallel", Motion("a", "grip"), Motion("b", "grip"))) is None
    assert "more than one branch moves the gripper" in trial.reasons()


def test_after_a_try_all_the_arm_goes_back(trial: Trial) -> None:
    steps = trial.steps(try_all("1.try_all", go("a", 2.0), Motion("b", "grip")), go("c"))
    assert steps and isinstance(steps[0], Parallel) and steps[0].until == "first"
    assert names(steps[1:]) == ["1.try_all/back", "c"]
    assert steps[2].duration == 1.0


def test_a_monitor_holds_its_parts_and_what_it_watches(trial: Trial) -> None:
    steps = trial.steps(monitor("1.monitor", go("a"), repeat("2.repeat", 2, go("b", 2.0)), force_n=20.0, time_s=5.0))
    assert steps and isinstance(steps[0], Monitor)
    assert (steps[0].force, steps[0].slip, steps[0].time) == (20.0, None, 5.0)
    assert names(steps) == ["a", "b", "2.repeat/back"]


def test_nothing_to_do_and_nothing_to_watch_are_mistakes() -> None:
    with pytest.raises(ValueError, match="needs something to do"):
        sequence("1.sequence")
    with pytest.raises(ValueError, match="watches nothing"):
        monitor("1.monitor", go("a"))


def _tree(part: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    several = st.lists(part, min_size=1, max_size=3)
    return st.one_of(
        several.map(lambda p: sequence("s", *p)),
        several.map(lambda p: fallback("a", *p)),
        several.map(lambda p: repeat("r", 2, *p)),
        several.map(lambda p: monitor("m", *p, time_s=1.0)),
        several.map(lambda p: choose("t", *p)),
    )


def _named(part: Any, path: str) -> Any:
    """Unique names all over a tree."""
    if not isinstance(part, Compound):
        return replace(part, name=path)
    inner = tuple(
        tuple(_named(p, f"{path}.{k}.{j}") for j, p in enumerate(branch)) for k, branch in enumerate(part.branches)
    )
    return replace(part, name=path, branches=inner)


def _first(part: Any) -> list[str]:
    """The motions of a tree in order; of alternatives the first."""
    if not isinstance(part, Compound):
        return [part.name]
    branches = part.branches[:1] if part.kind == "choose" else part.branches
    return [n for branch in branches for p in branch for n in _first(p)]


@examples(60)
@given(st.recursive(st.just(go("x", 1.0)), _tree, max_leaves=8))
def test_any_nesting_becomes_steps_in_its_own_order(waits: Path, tree: Any) -> None:
    whole = _named(tree, "w")
    trial = Trial(waits)
    state = next(trial.states(whole))
    assert [n for n in names(state.steps) if "back" not in n] == _first(whole)
    assert state.frames == () and state.agenda == ()


# In scenarios

HEAD = "scenario: s\nrobot: {type: ur5e}\nthings:\n  - {name: tea, model: block, at: {position: [0.5, 0, 0.1]}}\ntasks:\n"


@pytest.mark.parametrize(
    ("tasks", "line", "said"),
    [
        ("  - ParkArms\n  - repeet: {times: 3}\n", 7, "did you mean 'repeat'"),
        ("  - repeat: {time: 3, do: [ParkArms]}\n", 6, "'repeat' has no 'time'; did you mean 'times'"),
        ("  - repeat: {times: 0, do: [ParkArms]}\n", 6, "greater than or equal to 1"),
        ("  - repeat:\n      times: 2\n      do:\n        - ParkArms\n        - ParkLegs\n", 10, "no task type 'ParkLegs'"),
        ("  - choose:\n    - ParkArms\n    - [ParkArms, {task: Grasp, Patient: te}]\n", 8, "did you mean 'tea'"),
        ("  - monitor: {do: [ParkArms]}\n", 6, "needs 'force', 'slip' or 'time'"),
        ("  - monitor: {force: 20 mm, do: [ParkArms]}\n", 6, "'mm' is not a unit of force"),
        ("  - retry: {do: [ParkArms, ParkArms], with: [{x: 1}]}\n", 6, "'retry' is for one task"),
        ("  - retry: {do: {task: Grasp, Patient: tea}}\n", 6, "'retry' needs 'with'"),
        ("  - retry: {do: {task: Grasp, Patient: tea}, with: [{forse_n: 3}]}\n", 6, "did you mean 'force_n'"),
        ("  - parallel: []\n", 6, "needs something to do"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path: Path, tasks: str, line: int, said: str) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(HEAD + tasks)
    with pytest.raises(UserError) as caught:
        next(Engine().resolve(read_scenario(path)))
    assert f"s.yaml:{line}:" in str(caught.value)
    assert said in str(caught.value)


def test_rules_are_data_in_python_too() -> None:
    rule = task_entry({"repeat": {"times": 3, "do": ["ParkArms", {"task": "Grasp", "Patient": "tea"}]}})
    assert task_entry(rule) is rule
    assert [t.task for t in rule.do[0]] == ["ParkArms", "Grasp"]  # type: ignore[union-attr]
