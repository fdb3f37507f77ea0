"""Recording of demonstrations: a simulated person acts, and what happened is written as an episode."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..scenario.worlds import build_world

if TYPE_CHECKING:
    from ..model.episode import Episode
    from ..scenario.scenario import Scenario
    from .engine import Engine



def record_episode(scenario: Scenario, engine: Engine, *, seed: int, out: Path) -> Episode:
    """Record a demonstration of a scenario into a folder.

    Raises:
        UserError: the scenario says nothing about recording.
    """
    recipe = scenario.spec.record
    if recipe is None:
        raise UserError(f"{scenario.path}: has no 'record' section, which says what a person should do in which world.")
    world, _ = build_world(scenario, recipe.things, recipe.vary, engine.knowledge.models, seed)
    knowledge = engine.knowledge
    rollout = knowledge.simulator.demonstrate(replace(world, robots=()), recipe.script, seed=seed)
    episode = knowledge.episodes.detect(rollout, scenario.name)
    knowledge.episodes.write(episode, out)
    return episode
