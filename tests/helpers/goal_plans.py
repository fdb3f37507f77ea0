"""Plans for a goal in a setting, as the engine asks for them."""

from __future__ import annotations

from collections.abc import Iterator

from cramlite import Goal, Setting, Trace
from cramlite.model import Plan
from cramlite.planning.task_sequences import plans_for_goal
from cramlite.plugin.catalogue import Knowledge


def plans_in(setting: Setting, goal: Goal, knowledge: Knowledge, trace: Trace) -> Iterator[Plan]:
    return plans_for_goal(setting.name, goal, setting.symbolic(knowledge.taxonomy), knowledge, trace)
