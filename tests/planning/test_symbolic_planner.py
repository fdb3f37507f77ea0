"""Fast Downward is ended by counted work where it would search on and on, and says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run

from cramlite.planning import symbolic_planner
from cramlite.planning.pddl import PddlText
from cramlite.planning.symbolic_planner import fast_downward

DOMAIN = """(define (domain lamps) (:requirements :adl) (:types lamp) (:predicates (lit ?x - lamp))
  (:action two :parameters (?x ?y - lamp) :precondition (not (= ?x ?y)) :effect (and
    (when (lit ?x) (not (lit ?x))) (when (not (lit ?x)) (lit ?x)) (when (lit ?y) (not (lit ?y))) (when (not (lit ?y)) (lit ?y)))))
"""
"""Lamps of which any two are switched at once: an odd number of them is never lit, which only a search through all states shows."""


def lamps(count: int, lit: int) -> PddlText:
    """The problem that the first so many lamps shall be lit, and no other."""
    names = [f"l{k}" for k in range(count)]
    goal = " ".join(f"(lit {n})" if k < lit else f"(not (lit {n}))" for k, n in enumerate(names))
    problem = f"(define (problem some) (:domain lamps) (:objects {' '.join(names)} - lamp) (:init) (:goal (and {goal})))"
    return PddlText(DOMAIN, problem, {}, {})


def test_a_search_that_would_go_on_and_on_is_ended_by_counted_states() -> None:
    said = list[str]()
    assert fast_downward(lamps(32, 1), progress=said.append).plan is None
    assert "no plan among as many states as 64M of memory hold" in said


def test_a_plan_and_that_there_is_none_are_found_within_that() -> None:
    said = list[str]()
    assert (fast_downward(lamps(32, 2), progress=said.append).plan or "").startswith("(two l")
    assert fast_downward(lamps(8, 1), progress=said.append).plan is None
    assert not said


def test_a_goal_without_the_planner_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch, run: Run, tmp_path: Path) -> None:
    monkeypatch.setattr(symbolic_planner, "find_spec", lambda name: None)
    ran = run("resolve", "hang_up_a_product", "--out", tmp_path / "run")
    assert ran.code == 2 and "pip install up-fast-downward" in ran.err and "Traceback" not in ran.err
