"""Demonstrations by a scripted person; physics decides whether they succeed.

A script is a sequence of intentions (reach, grip, pull along the peg, carry). It knows where things are, as a person
who looks at them does, but nothing holds unless contacts and friction hold it. All variety (approach, speeds,
hesitation, detours, grip, height of release, tremor) comes from the seed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import Pose, Rollout, World, thing_of
from cramlite.plugin import Performance, Shown, UserError

from ..simulation.model.compile import Compiled, compile_world
from ..simulation.model.hand_model import WristTooFar
from .at_ease import at_ease, facing, forward_and_down
from .person import Person


def demonstrate(world: World, shown: Sequence[Shown], *, seed: int, rate: float = 50.0) -> Rollout:
    """Record a person performing scripts in a world, one after the other, until one fails.

    Args:
        world: with the things that the scripts need; robots are left out.
        shown: scripts, at least one, each with what fills its task's roles.
        seed: of everything that varies between two demonstrations.
        rate: samples a second.

    Returns:
        The recording, whatever came of it; its outcome is "failed", with the reason, where a script knows what it is for and
        that did not come about, or a wrist could not turn so far. Nobody makes another one: a person's failures are data, too.

    Raises:
        UserError: the world lacks what a script needs.
        PluginError: a script prepares no performance.
    """
    rng = np.random.default_rng(seed)
    performances = [s.prepared(world, rng) for s in shown]
    person = _beginning(world, performances, rng, rate)
    wrong = ""
    for performance in performances:
        if wrong := _performed(performance, person):
            break
    rollout = person.rollout()
    for performance in performances:
        rollout = performance.recorded(rollout) if performance.recorded else rollout
    return replace(rollout, outcome="failed", reason=wrong) if wrong else rollout


def _performed(performance: Performance, person: Person) -> str:
    """Perform a script; return why it failed, "" if it succeeded."""
    try:
        performance.act(person)
    except WristTooFar as too_far:
        return str(too_far)
    return performance.missed(person) if performance.missed else ""


def _beginning(world: World, shown: Sequence[Performance], rng: np.random.Generator, rate: float) -> Person:
    """Return a simulated person whose hands are where the first script begins and touch nothing.

    Raises:
        UserError: there is no room for a hand where it begins.
    """
    rests = max((p.rests for p in shown), key=len) or (forward_and_down(facing(world)),)
    start: Callable[[], tuple[Pose, ...]] = shown[0].start or (lambda: (at_ease(world, rng),))
    compiled = compile_world(replace(world, robots=()), {}, hand=rests)
    for _ in range(50):
        person = Person(compiled, rng, start(), rate)
        if not _in_touch(compiled, person):
            return person
    raise UserError("there is no room for a hand in front of the thing to take; move the obstacle there")


def _in_touch(compiled: Compiled, person: Person) -> bool:
    return any(thing_of(name) == "effector" for pair in compiled.collisions(person.data) for name in pair)
