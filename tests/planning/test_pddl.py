"""Exported PDDL means what the task rules mean, bad plans are told apart, and the command line hands both on."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run
from helpers.properties import examples
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from cramlite import Engine, Goal, PddlText, PlanningProblem, PlanStep, find_scenario, planning_problem, read_scenario
from cramlite.planning.symbolic.symbolic_planner import fast_downward

ENGINE = Engine()
HANG = "hang_up_a_product"


def _problem(scenario: str, *says: str) -> PlanningProblem:
    setting = ENGINE.setting(read_scenario(find_scenario(scenario)))
    return planning_problem(Goal(says), setting.symbolic(ENGINE.knowledge.taxonomy), ENGINE.knowledge)


PROBLEMS = [
    _problem("hang_onto_hanger", "coffee on hook", "tin on counter near hook"),
    _problem("take_off_hanger_tasks", "tea in basket"),
    _problem("tasks/pouring", "jug poured into bowl"),
]
TEXTS = [problem.pddl() for problem in PROBLEMS]


@pytest.mark.heavy
@examples(15, suppress_health_check=list(HealthCheck))
@given(st.integers(0, len(PROBLEMS) - 1), st.lists(st.integers(0, 10**6), min_size=1, max_size=6))
def test_what_an_action_does_is_what_its_task_does(which: int, picks: list[int]) -> None:
    """A walk: after each step unified-planning's simulator and the operators agree on what may come next."""
    up = pytest.importorskip("unified_planning.shortcuts")
    from cramlite_plugins.adapters.planning import to_unified_planning

    problem, text = PROBLEMS[which], TEXTS[which]
    model = to_unified_planning(text)
    facts = problem.facts
    with up.SequentialSimulator(model) as simulator:
        state = simulator.get_initial_state()
        for pick in picks:
            there = sorted(_names(simulator.get_applicable_actions(state)))
            here = {name: o for name, step in _steps(text) if (o := problem.operator(step)) and o.applies(facts)}
            assert there == sorted(here)
            if not there:
                return
            chosen = there[pick % len(there)]
            action = next(a for a in simulator.get_applicable_actions(state) if _name(a) == chosen)
            state, facts = simulator.apply(state, *action), here[chosen].apply(facts)


def _name(action: tuple[object, tuple[object, ...]]) -> str:
    return " ".join([action[0].name, *map(str, action[1])])  # type: ignore[attr-defined]


def _names(actions: object) -> list[str]:
    return [_name(a) for a in actions]  # type: ignore[attr-defined]


def _steps(text: PddlText) -> list[tuple[str, PlanStep]]:
    """Every action with every object that its tables allow, under its name in PDDL."""
    from itertools import product

    objects = {e: n for n, e in text.entities.items()}
    found: list[tuple[str, PlanStep]] = []
    for name, schema in text.actions.items():
        fillers = [[r[0] for t in schema.tables if t.terms == (schema.terms[v],) for r in t.rows] for v in schema.parameters]
        for row in product(*fillers):
            step = PlanStep(schema, dict(zip(schema.parameters, row, strict=True)))
            wholes = [step.binding[v].partition("/")[0] for v in schema.wholes]
            found.append((" ".join([name, *(objects[e] for e in (*row, *wholes))]), step))
    return found


def test_the_same_problem_has_the_same_text() -> None:
    again = _problem("take_off_hanger_tasks", "tea in basket").pddl()
    assert (again.domain, again.problem) == (TEXTS[1].domain, TEXTS[1].problem)


def test_many_plans_that_were_tried_are_ruled_out_without_multiplying_their_steps() -> None:
    """Ways to leave one of twelve steps out of each of eight plans are 430 million."""
    text = TEXTS[0]
    names = dict(_steps(text))
    first = [names[line.strip("()")] for line in (fast_downward(text).plan or "").splitlines() if line.startswith("(")]
    others = [[*names.values()][k : k + 12] for k in range(8)]
    again = fast_downward(PROBLEMS[0].pddl(earlier=[first, *others])).plan
    assert again is not None and not {n for n, s in names.items() if s in first} <= {line.strip("()") for line in again.splitlines()}


PLAN = """; of another planner
(grasping coffee)
(extractholefrompeg_with_part_relatum coffee other_peg other)
(insertholeontopeg_with_part_relatum coffee hook_peg hook)
(releasing coffee hook)
(retracting coffee)
"""


def test_a_problem_is_written_and_a_plan_is_handed_back(tmp_path: Path, run: Run) -> None:
    ran = run("goal", HANG, "--pddl", tmp_path / "pddl")
    assert ran.code == 0, ran.err
    domain, problem = ((tmp_path / "pddl" / f"{n}.pddl").read_text() for n in ("domain", "problem"))
    assert "(:action grasping" in domain and "(:goal (and" in problem
    (tmp_path / "plan").write_text(PLAN)
    ran = run("goal", HANG, "--plan", tmp_path / "plan")
    assert ran.code == 0 and "5. Retracting(Relatum=coffee)" in ran.out, ran.err


@pytest.mark.heavy
def test_a_plan_that_is_handed_back_becomes_a_program(tmp_path: Path, run: Run) -> None:
    (tmp_path / "plan").write_text(PLAN)
    ran = run("resolve", HANG, "--plan", tmp_path / "plan", "--no-report", "--out", tmp_path / "run")
    assert ran.code == 0, ran.err
    assert "ExtractHoleFromPeg" in ran.out


@pytest.mark.parametrize(
    ("plan", "says"),
    [
        ("(graspin coffee)", "plan:1: the domain has no action 'graspin'; did you mean 'grasping'?"),
        ("; x\n(grasping coffe)", "plan:2: the problem has no object 'coffe'; did you mean 'coffee'?"),
        ("(grasping)", "'grasping' has 1 parameters (Patient), not 0"),
        ("grasp it", "'grasp it' is no step of a plan; write '(action object object)'"),
        ("(grasping floor)", "is no action of the problem: these things do not allow it"),
        ("(retracting coffee)", "step 1 of the plan, needs touches"),
        ("(grasping coffee)", "the plan ends without touches(coffee, hook/peg), which the goal asks for"),
        ("", "the plan ends without"),
    ],
)
def test_plans_that_are_none(plan: str, says: str, tmp_path: Path, run: Run) -> None:
    (tmp_path / "plan").write_text(plan)
    ran = run("goal", HANG, "--plan", tmp_path / "plan")
    assert ran.code == 2 and says in ran.err and "Traceback" not in ran.err


def test_a_scenario_without_a_goal_and_a_plan_that_is_missing(tmp_path: Path, run: Run) -> None:
    assert "has no goal" in run("goal", "place_on_shelf").err
    assert "cannot be read as a plan" in run("goal", HANG, "--plan", tmp_path / "none").err
