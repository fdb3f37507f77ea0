"""Construction of searches for a given world and robot, and of the context that plugins get in a search."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..planning.search.answers import Answers
from ..planning.search.budget import Budget
from ..planning.search.search import Effort, Search
from ..plugin.grounding import Context

if TYPE_CHECKING:
    from ..model.plan import Plan
    from ..planning.trace import Trace
    from ..plugin.catalogue import Knowledge
    from .setting import Setting

Progress = Callable[[str], None]


def search_in(
    setting: Setting, knowledge: Knowledge, budget: Budget, trace: Trace, progress: Progress = lambda _: None,
    answers: Answers | None = None, effort: Effort | None = None,
) -> Search:  # fmt: skip
    """Construct a search for programs in a setting (world, robot, backend and initial belief)."""
    return Search(
        knowledge.registry, knowledge.tasks, knowledge.task_owners, _context(setting, knowledge, budget), trace, budget, progress,
        answers or Answers(), effort or Effort(),
    )  # fmt: skip


def are_there(plan: Plan, setting: Setting, knowledge: Knowledge, trace: Trace) -> bool:
    """Check whether the world has things that fit all objects of a plan; the trace records why other things
    were refused."""
    search = search_in(setting, knowledge, Budget(), trace)
    return next(search.solve(replace(setting.start(plan), agenda=plan.objects)), None) is not None


def _context(setting: Setting, knowledge: Knowledge, budget: Budget) -> Context:
    """Return the context that plugins get in a search: robot, taxonomy, seed, number of samples, camera and
    limits."""
    took = setting.look.camera if setting.look else None
    return Context(
        setting.robot, setting.world.robots[0], {}, knowledge.taxonomy, seed=setting.seed, samples=budget.samples,
        camera=took or next(iter(setting.world.cameras), None), limits=setting.limits,
        errors=setting.doubts.errors if setting.doubts.twins else None,
    )  # fmt: skip
