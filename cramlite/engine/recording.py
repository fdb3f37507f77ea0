"""Recording of demonstrations: a simulated person acts, and what happened is written as an episode."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.episode import Episode
from ..scenario.worlds import build_world

if TYPE_CHECKING:
    from ..scenario.scenario import Scenario
    from .engine import Engine



class Recording(Value):
    """Recording of a demonstration.

    Args:
        episode: that was written.
        failure: what the person did not bring about; "" where it came off, or the script does not say what it is for.
    """

    episode: Episode
    failure: str


def record_episode(scenario: Scenario, engine: Engine, *, seed: int, out: Path) -> Recording:
    """Record a demonstration of a scenario into a folder, whatever comes of it.

    Raises:
        UserError: the scenario says nothing about recording.
    """
    recipe = scenario.spec.record
    if recipe is None:
        raise UserError(f"{scenario.path}: has no 'record' section, which says what a person should do in which world.")
    world, _ = build_world(scenario, recipe.things, recipe.vary, engine.knowledge, seed)
    knowledge = engine.knowledge
    rollout = knowledge.simulator.demonstrate(replace(world, robots=()), recipe.script, seed=seed)
    episode = knowledge.episodes.detect(rollout, scenario.name)
    knowledge.episodes.write(episode, out)
    return Recording(episode, rollout.reason)
