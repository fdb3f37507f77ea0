"""What an action may be made of: tasks that there are, and never itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .designators import Action
from .errors import nearest
from .flow import Compound


def misfit(action: Action, inside: Iterable[Action], tasks: Mapping[str, object]) -> str:
    """Why an action cannot be part of what it is to be part of; empty when it can.

    Args:
        inside: the actions that it is a part of, the innermost first.
        tasks: the task types that there are.

    Returns:
        A clause: the task is unknown, with the nearest name; or it comes round to an action of the same task with the same
        objects and parameters, which would go on for ever.
    """
    if isinstance(action, Compound):
        return ""
    above = list(inside)
    if action.task not in tasks:
        whose = f", which '{above[0].task}' is to be made of" if above else ""
        return f"there is no task '{action.task}'{whose}; {nearest(action.task, tasks)}"
    for k, one in enumerate(above):
        if _meaning(one) == _meaning(action):
            way = " > ".join(a.task for a in (*reversed(above[: k + 1]), action))
            return f"a cyclic decomposition: {way}, with the same objects and parameters"
    return ""


def _meaning(action: Action) -> tuple[object, ...]:
    fillers = {k: (v.name, v.entity) for k, v in action.roles.items()}
    return action.task, fillers, dict(action.parameters), action.goal
