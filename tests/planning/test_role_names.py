"""Roles by plain names: 'object' and 'target' are taken for a task's own roles where the task says which."""

from __future__ import annotations

import pytest

from cramlite import Engine, TaskSpec, Trace, find_scenario, read_scenario
from cramlite.model import Plan
from cramlite.plugin import UserError

ENGINE = Engine()
SETTING = ENGINE.setting(read_scenario(find_scenario("place_on_shelf")))


def plan(task: str, **roles: str) -> Plan:
    ((found, _),) = ENGINE.plans(TaskSpec(task=task, roles=roles), SETTING, Trace())
    return found


@pytest.mark.parametrize(
    ("task", "plain", "own"),
    [
        ("Place", {"object": "block", "target": "shelf"}, {"Locatum": "block", "Relatum": "shelf"}),
        ("Grasp", {"object": "block"}, {"Patient": "block"}),
        ("Transporting", {"object": "block", "target": "shelf"}, {"Patient": "block", "Destination": "shelf"}),
    ],
)
def test_plain_names_mean_the_tasks_own_roles(task: str, plain: dict[str, str], own: dict[str, str]) -> None:
    assert plan(task, **plain) == plan(task, **own)


@pytest.mark.parametrize(
    ("task", "roles", "said"),
    [
        ("Lift", {"object": "block", "target": "shelf"}, "has no role 'target'"),  # what it lies on, not where it goes
        ("Place", {"object": "block", "Locatum": "shelf", "target": "shelf"}, "two fillers for its role 'Locatum': 'block' and 'shelf'"),
        ("Place", {"objct": "block", "target": "shelf"}, "did you mean 'object'"),
    ],
)
def test_what_is_not_clear_is_refused(task: str, roles: dict[str, str], said: str) -> None:
    with pytest.raises(UserError, match=said):
        plan(task, **roles)
