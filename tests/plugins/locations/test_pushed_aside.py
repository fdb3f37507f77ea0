"""Ways out of the way: away from what later tasks are about first, and none that something is on."""

from __future__ import annotations

import math

import pytest

from cramlite import Engine
from cramlite.model import Action, Belief, Location, Object, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E

MOUNT, AT = RobotMount("arm", "ur5e"), (0.45, 0.0, 0.003)
FAR = 0.1
BOARD = block("board", Pose(AT), (0.12, 0.12, 0.016))


def asked(*things: Thing, about: str = "") -> list[Grounding | Refused]:
    """Where hands may be that push a board out of the way, with a later task about a thing."""
    world = World((table("floor", Pose((0.3, 0.0, -0.005)), (1.6, 1.6, 0.02)), BOARD, *things), (MOUNT,))
    belief: Belief = initial_belief(world, "arm", UR5E.home, 0.085)
    later = Action("2.Opening", "soma:Opening", {"Patient": Object("o", entity=about)}) if about else None
    agenda = (later,) if later else ()
    context = Context(UR5E, MOUNT, {"board": "board"}, Engine().knowledge.taxonomy, agenda=agenda)
    aside = Location("behind(board)", "behind", "board", {"aside_m": FAR, "apart": 0.6})
    return list(ground(aside, belief, context))


def way(found: Grounding) -> tuple[float, float]:
    """Of the board [m]."""
    x, y = found.value.carried.to_m
    return x - AT[0], y - AT[1]


@pytest.mark.parametrize(("y", "to"), [(0.3, -1.0), (-0.3, 1.0)])
def test_it_goes_away_from_what_a_later_task_is_about(y: float, to: float) -> None:
    other = block("other", Pose((AT[0], y, 0.035)), (0.05, 0.05, 0.06))
    first = next(a for a in asked(other, about="other") if isinstance(a, Grounding))
    assert way(first) == pytest.approx((0.0, to * FAR), abs=1e-6)


def test_it_goes_no_way_on_which_something_is() -> None:
    """However the hand comes over that."""
    bar = table("bar", Pose((AT[0], -0.13, 0.01)), (0.4, 0.02, 0.01))
    (free, near) = ([way(a)[1] for a in asked(*more) if isinstance(a, Grounding)] for more in ((), (bar,)))
    assert min(free) < -FAR and min(near) > -0.06 and max(near) > FAR


def test_between_four_fences_there_is_no_way() -> None:
    sides = [Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, k * math.pi / 2)) * Pose((0.1, 0.0, 0.03)) for k in range(4)]
    fence = [table(f"fence_{k}", Pose((AT[0], 0.0, 0.0)) * at, (0.02, 0.24, 0.05)) for k, at in enumerate(sides)]
    free, shut = asked(), asked(*fence)
    assert any(isinstance(a, Grounding) for a in free)
    assert shut and all(isinstance(a, Refused) and "'fence_" in a.reason for a in shut)
