"""Stages of an open program: tasks that are resolved when their time comes, or others in their place."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Literal

from ...base.errors import CramliteError, PluginError
from ...planning.trace import Trace

if TYPE_CHECKING:
    from ...scenario.scenario import Scenario
    from ..engine import Engine
    from ..setting import Setting
    from ..solution import Solution

CLOSED = "what comes then cannot be done as things are"
"""Reason why an execution ends before its last stage."""
Failure = Callable[[Trace, Iterable[object]], str]
"""Text on a search that proved nothing, with the faults of plugins."""


def stage_program(
    scenario: Scenario, number: int, engine: Engine, seed: int, setting_of: Callable[[Scenario], Setting], failure: Failure
) -> tuple[Solution | None, str]:
    """Return a proven program for a stage of a scenario's ``then``, else for that stage's ``else``, and why it was chosen; or None, and
    why there is none.

    Args:
        number: of the stage, from 0.
        setting_of: the setting in which a stage is resolved.

    Raises:
        PluginError: a plugin failed.
    """
    why = list[str]()
    keys: tuple[Literal["do", "else"], ...] = ("do", "else")
    for key in keys:
        stage, trace = scenario.stage(number, key), Trace()
        if stage is None:
            continue
        try:
            found = next(engine.resolve(stage, setting=setting_of(stage), seed=seed, trace=trace), None)
        except PluginError:
            raise
        except CramliteError as error:  # a named thing is not there, or nobody can see it
            why.append(str(error))
            continue
        if found is not None and found.candidate.code is not None:
            return found, f"resolves what comes then ({key}): {found.plan}"
        why.append(failure(trace, engine.registry.faults))
    return None, f"{CLOSED}. {' '.join(why)}"
