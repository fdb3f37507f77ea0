"""Text of a scenario's request, for the first lines of a report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .task_specs import RuleSpec, TaskSpec

if TYPE_CHECKING:
    from .scenario import ScenarioSpec

SHOWN = "what the demonstration shows"


def asked_text(spec: ScenarioSpec) -> str:
    """Return what a scenario asks for, in words: its goal, its tasks with their things, or what a
    demonstration shows."""
    if spec.goal is not None:
        return "; ".join(spec.goal)
    if spec.demonstration is not None:
        return SHOWN
    return tasks_text((spec.designator,) if spec.designator is not None else spec.tasks or ())


def tasks_text(entries: Sequence[TaskSpec | RuleSpec]) -> str:
    """Format tasks in their order, such as "Grasping tin, then Placing tin box"; of a control structure only the name."""
    return ", then ".join(map(_entry_text, entries))


def _entry_text(entry: TaskSpec | RuleSpec) -> str:
    if isinstance(entry, TaskSpec):
        return " ".join((entry.task.split(":")[-1], *entry.roles.values()))
    return entry.rule
