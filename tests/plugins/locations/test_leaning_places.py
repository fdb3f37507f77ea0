"""Where a thing is let go of between walls so that it comes to rest leaning, since upright its origin would be below its region."""

from __future__ import annotations

import math
from itertools import islice

import pytest

from cramlite import Engine
from cramlite.model import Feature, Geom, Held, Location, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing import at_rest
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")
DEEP, WIDE, LONG, HIGH = 0.06, 0.03, 0.10, 0.13
"""Between the walls of the compartment, and sides of the book [m]."""


def _wall(size: tuple[float, float, float], x: float, y: float = 0.0) -> Geom:
    half = (size[0] / 2, size[1] / 2, size[2] / 2)
    return Geom("box", half, Pose((x, y, half[2])), friction=0.9)


def _compartment(front: float) -> Thing:
    """A compartment whose wall in front, towards x, is so high [m]; the one behind is as high as the book."""
    floor = Geom("box", (0.05, 0.08, 0.005), Pose((0.0, 0.0, -0.005)), friction=0.9)
    walls = (_wall((0.008, 0.16, 0.13), -DEEP / 2 - 0.004), _wall((0.008, 0.16, front), DEEP / 2 + 0.004))
    sides = tuple(_wall((DEEP, 0.008, 0.06), 0.0, y) for y in (-0.064, 0.064))
    cavity = Feature("back", "cram:Cavity", Pose((0.0, 0.0, 0.13)), {"width": DEEP, "depth": 0.12, "height": 0.13})
    level = Feature("floor", "vrps:SurfaceFeature", Pose(), {"width": DEEP, "depth": 0.12})
    at = Pose.from_rotvec((0.5, -0.1, 0.02), (0.0, 0.0, 0.0))
    return Thing("caddy", "soma:DesignedContainer", at, (floor, *walls, *sides), features=(cavity, level))


def _book(origin: float) -> Thing:
    """A book whose foot is so high over its origin [m]."""
    body = Geom("box", (WIDE / 2, LONG / 2, HIGH / 2), Pose((0.0, 0.0, origin + HIGH / 2)), friction=0.9)
    return Thing("book", "cram:Product", Pose((0.4, 0.3, 0.1)), (body,), mass=0.05)


def _answers(front: float, origin: float, count: int = 1) -> list[tuple[Pose, Grounding]]:
    """Poses of the book where it is let go of, in the frame of the region's opening."""
    caddy, book = _compartment(front), _book(origin)
    held = Held("book", Pose.from_rotvec((0.0, 0.0, origin + HIGH - 0.01), (math.pi, 0.0, 0.0)), WIDE)
    world = World((table("floor", Pose((0.2, 0, -0.005)), (1.6, 1.6, 0.02)), caddy, book), (MOUNT,))
    belief = initial_belief(world, "arm", UR5E.home, 0.085).grasped(held)
    context = Context(UR5E, MOUNT, {"caddy": "caddy/back"}, Engine().knowledge.taxonomy)
    found = ground(Location("in(caddy)", "in", "caddy", {"region": "back"}), belief, context)
    assert found is not None
    opening = caddy.pose * caddy.features[0].pose
    answers = islice((a for a in found if isinstance(a, Grounding)), count)
    return [(opening.inverse() * a.value.pose * held.tcp_to_thing, a) for a in answers]  # type: ignore[union-attr]


def _lean(pose: Pose) -> float:
    return math.degrees(math.acos(min(1.0, float(pose.rotate((0.0, 0.0, 1.0))[2]))))


def test_a_book_with_its_origin_below_its_foot_is_let_go_of_leaning_over_the_lower_wall() -> None:
    [(there, found)] = _answers(front=0.085, origin=0.002)
    assert 10.0 < _lean(there) < 26.0
    assert there.rotate((0.0, 0.0, 1.0))[0] > 0.0  # towards the lower wall, in front
    assert found.value.reorients  # type: ignore[union-attr]


def test_one_with_its_origin_above_its_foot_stands() -> None:
    [(there, _)] = _answers(front=0.085, origin=-0.01)
    assert _lean(there) < 1.0


def test_between_walls_that_are_too_high_to_lean_far_enough_it_is_refused() -> None:
    with pytest.raises(Unresolvable, match=r"its origin would be 4 mm below 'back' of 'caddy'.*nor would it rest in the region"):
        _answers(front=0.13, origin=0.004)


@pytest.mark.heavy
def test_it_is_in_its_region_wherever_it_is_let_go_of_nearby(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where an arm may be as far off as there is room, no place is sure."""
    monkeypatch.setattr(at_rest, "ASTRAY", 0.015)
    with pytest.raises(Unresolvable, match="if it leaned against a wall"):
        _answers(front=0.085, origin=0.002)
