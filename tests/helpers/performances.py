"""Demonstrations by shipped scripts of the simulated person."""

from __future__ import annotations

from cramlite.model import Rollout, World
from cramlite.plugin import RecordScript, Shown
from cramlite_plugins.person.demonstrate import demonstrate
from cramlite_plugins.person.scripts import SCRIPTS


def performed(world: World, *, seed: int, script: str = "take_off_hanger") -> Rollout:
    """Simulate a person who carries out the script of a whole demonstration in a world."""
    return demonstrate(world, [Shown(RecordScript(script, SCRIPTS[script].prepare))], seed=seed)
