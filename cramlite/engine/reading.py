"""Goals with their demonstrations, each of which is read and interpreted once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from ..base.value import Value

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..model.episode import Episode
    from ..planning.task_goals import Goal
    from ..scenario.scenario import Scenario
    from ..scenario.task_specs import RuleSpec, TaskSpec

    AnyGoal = Scenario | Episode | Goal | Sequence[TaskSpec | RuleSpec] | TaskSpec | RuleSpec


class Reading(Value, dict=True, eq=False):
    """Goal with its demonstration, if it has one, as ``Engine.read`` makes it.

    The episode is read when it is first asked for, and interpreted when that is first asked for.

    Args:
        goal: what was read.
    """

    goal: AnyGoal
    _read: Callable[[], Episode | None]
    _interpret: Callable[[Episode], Interpretation]

    @cached_property
    def episode(self) -> Episode | None:
        """Recorded demonstration of the goal; None if the goal has no demonstration.

        Raises:
            UserError: it cannot be read.
        """
        return self._read()

    @cached_property
    def interpretation(self) -> Interpretation | None:
        """Interpretation of the goal's demonstration; None if the goal has no demonstration.

        Raises:
            UserError: it cannot be read, or has no events.
        """
        return self._interpret(self.episode) if self.episode is not None else None


def goal_text(goal: object) -> str:
    """Describe a goal that is not a scenario, in words."""
    from ..planning.task_goals import Goal
    from ..scenario.asked_text import SHOWN, tasks_text
    from ..scenario.task_specs import RuleSpec, TaskSpec

    if isinstance(goal, Goal):
        return "; ".join(goal.says)
    entries = goal if isinstance(goal, list | tuple) else (goal,)
    tasks = [e for e in entries if isinstance(e, TaskSpec | RuleSpec)]
    return tasks_text(tasks) if tasks else SHOWN
