"""Every first-party plugin keeps the contract, and the checks see what does not."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from cramlite import Action, Belief, Decomposition, Motion, Parameter, Role, TaskType
from cramlite.registry import GROUP
from cramlite.testing import check_file, check_plugin, check_task_type

PLUGINS = sorted(p.value for p in importlib.metadata.entry_points(group=GROUP) if p.dist and p.dist.name == "cramlite")


@pytest.mark.parametrize("module", PLUGINS)
def test_first_party_plugins(module: str) -> None:
    check_plugin(module)


class Fine(TaskType):
    task = "x:Fine"
    summary = "hold still"
    roles = (Role("Patient"),)

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        yield Decomposition((Motion(action.inside("hold"), "hold"),), "hold")


def _variant(**changes: object) -> TaskType:
    variant: TaskType = type("Variant", (Fine,), changes)()
    return variant


def test_a_fine_task() -> None:
    check_task_type(Fine())


def _decompose(*steps: object) -> Callable[..., Iterable[Decomposition]]:
    return lambda self, action, belief: [Decomposition(steps, "x")]  # type: ignore[arg-type]


def _bug(self: TaskType, action: Action, belief: Belief) -> Iterable[Decomposition]:
    raise KeyError("cup")


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"task": "Fine"}, "CURIE"),
        ({"aliases": ("Fine",)}, "names repeat"),
        ({"summary": ""}, "summary"),
        ({"roles": (Role("A"), Role("A"))}, "roles repeat"),
        ({"parameters": (Parameter("speed_m_s", 1.0, ""),)}, "where its default comes from"),
        ({"decompose": _bug}, "only Unresolvable"),
        ({"decompose": _decompose(Motion("a", "levitate"))}, "levitate"),
        ({"decompose": _decompose("grasp it")}, "no designator"),
        ({"decompose": _decompose(Motion("a", "hold"), Motion("a", "hold"))}, "share a name"),
        ({"decompose": lambda self, action, belief: []}, "neither"),
    ],
)
def test_what_breaks_the_contract(changes: dict[str, object], says: str) -> None:
    with pytest.raises(AssertionError, match=says):
        check_task_type(_variant(**changes))


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    path.write_text("from cramlite import hookimpl\n@hookimpl\ndef robots():\n    return []\n")
    check_file(path)
    path.write_text("from cramlite import hookimpl\n@hookimpl\ndef robts():\n    return []\n")
    with pytest.raises(AssertionError, match="robts"):
        check_file(path)
