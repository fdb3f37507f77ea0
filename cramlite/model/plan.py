"""Plans: task sequences with types, roles and constraints, without the things of the demonstration that they
came from."""

from __future__ import annotations

from collections.abc import Callable

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
        goal: what should hold when it is done, in words, e.g. "coffee in basket"; all of it.
        lasting: what a demonstration ended with: names of actions, each with a postcondition of its task's rule that still
            held when the recording ended, e.g. ("3.Placing", "touches(Locatum, Relatum)").
    """

    name: str
    objects: tuple[Object, ...]
    actions: tuple[Action, ...]
    goal: tuple[str, ...] = ()
    lasting: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        return " -> ".join(_title(a, _task) for a in self.actions)

    @property
    def with_things(self) -> str:
        """Tasks in order, each with the things in its roles: "Grasping(coffee) -> Placing(coffee, shelf)"."""
        return " -> ".join(_title(a, _call) for a in self.actions)


def _title(action: Action, title: Callable[[Action], str]) -> str:
    """Title of a task; of a control structure its kind, with the titles of the tasks in its branches."""
    if not isinstance(action, Compound):
        return title(action)
    parts = " | ".join(", ".join(_title(p, title) for p in b if isinstance(p, Action)) for b in action.branches)
    return f"{action.kind}({parts})"


def _task(action: Action) -> str:
    return action.task.split(":")[-1]


def _call(action: Action) -> str:
    """Format a task with the things that fill its roles, such as "Grasping(coffee)".

    A thing that is not known by name is shown by the wanted class, else by a class that its name suggests.
    """
    fillers = ", ".join(o.entity or next(iter((*o.types, *o.like)), o.name) for o in action.roles.values())
    return f"{_task(action)}({fillers})" if fillers else _task(action)
