"""Cache of planning models: most scenes of a search differ only by the poses of movable things and by the
fingers.

A movable thing is free in a planning model, so where it is belongs to the state and not to the model.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from cramlite.model import Robot, World

from ..shapes.itself import Itself
from ..simulation.model.build import Carried
from ..simulation.model.compile import Compiled, compile_world
from .approach import Chains, chains
from .inflated import Inflated, inflated
from .pairs import Movers, movers

MODELS = 16
"""Number of planning models that are cached: one for each thing in the hand at each grasp, and one for the
empty hand; for a scene of 200 hulls some 2 MB each."""
LEVELS = 4
"""Inflated copies of each planning model that are kept."""


def planning_model(world: World, robots: Mapping[str, Robot], carried: Mapping[str, Carried]) -> Compiled:
    """Return the planning model of a world, compiled the first time; its things stand where that world has
    them.

    Args:
        robots: descriptions by type name.
        carried: as in ``compile_world``.

    Raises:
        UserError: the world does not compile.
    """
    return _model(
        Itself(world),
        tuple((t, Itself(r)) for t, r in sorted(robots.items())),
        tuple(sorted(carried.items())),
    )


@lru_cache(maxsize=MODELS)
def _model(
    world: Itself[World],
    robots: tuple[tuple[str, Itself[Robot]], ...],
    carried: tuple[tuple[str, Carried], ...],
) -> Compiled:
    return compile_world(world.it, {t: r.it for t, r in robots}, planning=True, carried=dict(carried))


def arm_movers(compiled: Compiled, mount: str) -> Movers:
    """Return the tables (geoms, joints) that tell which joints of the robot on a mount move which geoms."""
    return _movers(Itself(compiled), mount)


@lru_cache(maxsize=MODELS)
def _movers(compiled: Itself[Compiled], mount: str) -> Movers:
    return movers(compiled.it, compiled.it.robots[mount])


def arm_chains(compiled: Compiled, mount: str) -> Chains:
    """Return the chains of joints of the robot on a mount between the geoms of a planning model."""
    return _chains(Itself(compiled), mount)


@lru_cache(maxsize=MODELS)
def _chains(compiled: Itself[Compiled], mount: str) -> Chains:
    model, joints = compiled.it.model, compiled.it.robots[mount].joints
    first = int(np.flatnonzero(model.jnt_qposadr == joints[0])[0])
    return chains(model, arm_movers(compiled.it, mount), first)


def inflated_model(compiled: Compiled, mount: str, distance: float) -> Inflated:
    """Return a planning model inflated for a distance [m] between the robot of a mount and everything
    else."""
    return _inflated(Itself(compiled), mount, distance)


@lru_cache(maxsize=LEVELS * MODELS)
def _inflated(compiled: Itself[Compiled], mount: str, distance: float) -> Inflated:
    return inflated(compiled.it.model, arm_movers(compiled.it, mount).apart(), distance)
