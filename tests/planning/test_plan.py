"""A plan holds nothing of the instance it came from, and the same seed gives the same text."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLANNED, ROOT, TASKS, Proven, Run

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.json_text import as_json
from cramlite.model import Action, Episode, Object, Plan
from cramlite.planning.plan import TaskCall, plan_from_episode
from cramlite.plugin.task_type import task_type

DEMONSTRATION = ROOT / "scenarios" / "fetch_from_hanger" / "demonstration"


@pytest.fixture(scope="module")
def episode() -> Episode:
    return Engine().read_episode(DEMONSTRATION)


@pytest.fixture(scope="module")
def plan(episode: Episode) -> Plan:
    engine = Engine()
    sequence = next(iter(engine.interpret(episode).sequences()))
    calls = [TaskCall(task_type(engine.knowledge.tasks, m.task), m.roles) for m in sequence.matches]
    return plan_from_episode("fetch", calls, episode, engine.knowledge.taxonomy)


def _leaves(node: Any) -> list[Any]:
    if isinstance(node, dict):
        return [x for k, v in node.items() for x in (k, *_leaves(v))]
    return [x for v in node for x in _leaves(v)] if isinstance(node, list) else [node]


def _survivors(plan: Plan, episode: Episode) -> set[Any]:
    """Numbers of the plan, and names of the episode's individuals and events in it."""
    leaves = [x for x in _leaves(json.loads(as_json(plan))) if x is not None and not isinstance(x, bool)]
    names = {e.name for e in episode.entities} | {e.name.split("_")[-1] for e in episode.entities if "_" in e.name}
    numbers = {x for x in leaves if isinstance(x, int | float)}
    return numbers | {n for n in names for x in leaves if isinstance(x, str) and n in x and not x.startswith("object_")}


def test_nothing_of_the_instance_survives(plan: Plan, episode: Episode) -> None:
    assert len(plan.actions) >= 3
    assert all(o.entity is None for o in plan.objects)
    assert {t for o in plan.objects for t in o.types}, "classes do survive"
    assert _survivors(plan, episode) == set()


def test_the_look_would_see_an_instance(plan: Plan, episode: Episode) -> None:
    name = episode.entities[0].name
    pose = [float(v) for v in np.asarray(next(iter(episode.tracks.values())).poses)[0]]
    leaky = Plan("fetch", (*plan.objects, Object("object_9", entity=name)), plan.actions)
    assert name in _survivors(leaky, episode)
    posed = Plan("fetch", plan.objects, (*plan.actions, type(plan.actions[0])("9", "x:T", parameters={"at": pose})))
    assert _survivors(posed, episode)


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", [PLANNED, pytest.param(TASKS.stem, marks=pytest.mark.heavy)])
def test_the_same_seed_gives_the_same_text(scenario: str, process: Run, proven: Proven, tmp_path: Path) -> None:
    """In this process and in another (twice in one: test_embedding.py); another seed gives another text."""
    here = next(Engine().resolve(read_scenario(find_scenario(scenario)), seed=3)).code
    assert process("resolve", scenario, "--seed", 3, "--no-report", "--out", tmp_path / "run").code == 0
    assert here == (tmp_path / "run" / "program.script").read_text()
    assert here != proven(scenario).code


def test_a_thing_of_no_known_class_is_called_by_the_class_that_its_name_suggests() -> None:
    cup, other = Object("object_1", like=("cram:Cup", "cram:Crockery")), Object("object_2", types=("cram:Tray",), like=("cram:Cup",))
    plan = Plan("laid", (), (Action("1", "cram:Placing", {"theme": cup, "on": other, "by": Object("object_3")}),))
    assert plan.with_things == "Placing(cram:Cup, cram:Tray, object_3)"
