"""Worlds that are left alone until they rest, each simulated once: physics does not depend on who judges it."""

from __future__ import annotations

from copy import deepcopy

import mujoco

from cramlite.model import Pose, Rollout, Thing, World
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.recording.recorder import Recorder

FLOOR = table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02))
IN = (basket("basket", Pose((0.4, 0.3, 0.0))), block("tin", Pose((0.4, 0.3, 0.05))))
TWO = (block("tin", Pose((0.5, 0.1, 0.031))), block("cup", Pose((0.5, -0.05, 0.031))))
_KEPT: dict[str, Rollout] = {}


def settled(*things: Thing, seconds: float = 1.0) -> Rollout:
    """Simulate things that settle on a floor, once for each set of things, and return a copy of the rollout."""
    key = f"{things} {seconds}"
    if key not in _KEPT:
        _KEPT[key] = _run(things, seconds)
    return deepcopy(_KEPT[key])


def _run(things: tuple[Thing, ...], seconds: float) -> Rollout:
    compiled = compile_world(World((FLOOR, *things), ()), {}, hand=True)
    data, recorder = compiled.data(), Recorder(compiled, "hand")
    for _ in range(500):
        mujoco.mj_step(compiled.model, data)
    data.time = 0.0
    while data.time < seconds:
        mujoco.mj_step(compiled.model, data)
        recorder.observe(data)
    return recorder.rollout()


def opened(way: float) -> tuple[Thing, Thing]:
    """Make a drawer that is open by a distance [m], and its cabinet."""
    return cabinet("c", Pose((0.7, 0, 0.3))), drawer("d", Pose((0.7, 0, 0.3)), "c", opened=way)


def ready() -> None:
    """Simulate the worlds that most tests use, before the tests need them."""
    for things in (IN, TWO, opened(0.12), opened(0.0)):
        settled(*things)
