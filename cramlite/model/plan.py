"""Plans: task sequences with types, roles and constraints, and nothing of the instance that they came from."""

from __future__ import annotations

from ..base.value import Value
from .control_flow import Compound
from .designators import Action, Location, Object

HOME = Location("home", "home")


class Plan(Value):
    """Underspecified plan: a task sequence whose objects are designators.

    Args:
        name: for people.
        objects: what plays a role, one designator per thing meant.
        actions: in order.
    """

    name: str
    objects: tuple[Object, ...]
    actions: tuple[Action, ...]

    def __str__(self) -> str:
        return " -> ".join(_title(a) for a in self.actions)


def _title(action: Action) -> str:
    """The task, or the rule with its tasks."""
    if not isinstance(action, Compound):
        return action.task.split(":")[-1]
    parts = " | ".join(", ".join(_title(p) for p in b if isinstance(p, Action)) for b in action.branches)
    return f"{action.kind}({parts})"
