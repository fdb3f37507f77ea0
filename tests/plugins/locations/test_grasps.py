"""Grasps from geometry: what is proposed holds in physics, and what cannot be held is refused with numbers."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Estimate, Geom, Location, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding
from cramlite_plugins.locations.grasps import PER_TIGHT, Grasp, _in_order, _openings
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching import antipodal, grips
from cramlite_plugins.locations.pinching.hand_room import HandRoom
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.objects.products_and_fixtures import block, product
from cramlite_plugins.objects.vessels import bottle, can
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes import ray_casting as rays

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import grasp_objects
import grasps as benchmark

GRIPPER = UR5E.gripper


# one development seed of each: block, bowl, mug, mesh carton, mesh bowl, mesh bracket
@pytest.mark.heavy
@pytest.mark.parametrize("seed", [10005, 10008, 10009, 10012, 10013, 10015])
def test_one_of_the_first_five_holds(seed: int) -> None:
    item = grasp_objects.thing(seed)
    found = benchmark.proposals(item)
    assert any(benchmark.holds(item, g) for g in found), [g.name for g in found]


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [10006, 10013])
def test_pads_without_friction_hold_nothing(seed: int) -> None:
    item = grasp_objects.thing(seed)
    assert not any(benchmark.holds(item, g, friction=0.0) for g in benchmark.proposals(item)[:2])


@examples(30)
@given(st.floats(0.01, 0.038), st.floats(0.02, 0.1))
def test_a_can_is_as_wide_as_its_diameter(radius: float, half: float) -> None:
    every = grips.ranked(can("c", Pose(), radius, 2 * half), GRIPPER, 0.9)
    found = [g for g in every if "shallow" not in g.name and "tips" not in g.name and not g.ends]  # those grip beside the axis
    assert found
    assert all(g.width < 2 * radius + 1e-6 and g.slant < math.atan(0.9) for g in every)
    assert all(g.width == pytest.approx(2 * radius, abs=1e-6) and g.slant < 1e-3 for g in found)
    assert any("side" in g.name for g in every)


def test_a_hanging_product_is_gripped_as_before_and_never_by_its_tab() -> None:
    found = grips.ranked(product("p", Pose(), (0.06, 0.05, 0.1)), GRIPPER, 0.9)
    assert found[0].lever == 0
    assert all(g.width > 0.04 for g in found)


@pytest.mark.parametrize("height", [0.06, 0.10, 0.14])
def test_a_deep_grasp_leaves_room_between_palm_and_payload_beyond_what_reaches_over_the_palm(height: float) -> None:
    """Knuckles reach 4 mm over the palm: with no more room they pinched a box whose place was off by 4 mm."""
    down = Pose.from_axes((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
    shape = rays.body(block("b", Pose(), (0.07, 0.11, height)).geoms)
    ((deepest, *_),) = antipodal.depths(shape, [down], GRIPPER)
    palm = deepest[0].position[2] + GRIPPER.depth
    assert palm - height / 2 >= 0.004 + 0.005 and (deepest[0].position[2] == 0.0 or palm - height / 2 < 0.011)


@pytest.mark.parametrize(("height", "overlap"), [(0.018, 0.6 * 0.018), (0.06, 0.016)])
def test_what_is_thin_is_taken_by_its_upper_part(height: float, overlap: float) -> None:
    down = Pose.from_axes((0, 0, 0), (0, 0, -1), (1, 0, 0))
    found = antipodal.by_tips(down, -height / 2, height / 2, GRIPPER)
    assert found is not None
    ends = found[0].position[2] - GRIPPER.pad[1] / 2
    assert height / 2 - ends == pytest.approx(overlap, abs=1e-6)


def test_of_grasps_alike_of_many_parts_one_is_enough() -> None:
    sides = [Pose.from_rotvec((0, 0, 0), (0, 0, math.pi * k / 8)) for k in range(8)]
    parts = tuple(Geom("box", (0.03, 0.0062, 0.05), p) for p in sides)
    found = grips.ranked(Thing("can", "cram:Product", Pose(), parts, mass=0.1), GRIPPER, 0.9)
    for ends in (False, True):
        alike = [g for g in found if g.ends == ends]
        cells = grips._cells(antipodal.Hands.at([g.pose for g in alike]))
        assert len(np.unique(cells, axis=0)) == len(alike) > 0


@pytest.mark.parametrize(("beside", "sigma", "opening"), [(1.0, 0.0, 0.04), (1.0, 0.005, GRIPPER.opening[1]), (0.045, 0.005, 0.02)])
def test_fingers_open_wide_around_what_was_only_seen_and_by_30_mm_around_what_is_known(
    beside: float, sigma: float, opening: float
) -> None:
    walls = tuple(Geom("box", (0.01, 0.04, 0.04), Pose((s * beside, 0, 0))) for s in (1, -1))
    thing = Thing("thing", "cram:Product", Pose(), (Geom("box", (0.005, 0.01, 0.04)), *walls), mass=0.1)
    belief = Belief(World((thing,), ()), {"thing": Estimate(Pose(), sigma)}, "arm", (), 0.08)
    grip = next(g for g in grips.ranked(thing, GRIPPER, 0.9) if g.width == pytest.approx(0.01))
    found = next(_openings(Grasp(grip, grip.pose, 0.02, 0.0, ""), thing, belief, GRIPPER))
    assert found == pytest.approx(opening)


def test_too_wide_names_the_nearest_miss() -> None:
    big = block("crate", Pose(), (0.12, 0.2, 0.13))
    assert grips.ranked(big, GRIPPER, 0.9) == []
    assert grips.why_none(big, GRIPPER) == "no face pair of 'crate' (120 mm) fits the gripper's 81 mm"
    assert grips.ranked(can("drum", Pose(), 0.05), GRIPPER, 0.9) == []


def test_a_part_that_is_walled_in_is_refused() -> None:
    plates = tuple(Geom("box", (0.1, 0.1, 0.1), Pose((0, 0, s * 0.112))) for s in (1, -1))
    cage = Thing("cage", "cram:Product", Pose(), (Geom("box", (0.01, 0.01, 0.012)), *plates), mass=1.0)
    assert grips.ranked(cage, GRIPPER, 0.9) == []
    assert "in the way" in grips.why_none(cage, GRIPPER)


def test_slanted_contacts_are_outside_the_cone() -> None:
    tilted = Pose((0, 0, 0), (math.cos(0.5), 0, 0, math.sin(0.5)))
    down = antipodal.Hands.at([Pose.from_axes((0, 0, 0), (0, 0, -1), (0, 1, 0))])
    found = antipodal.pinches(rays.body([Geom("box", (0.02, 0.02, 0.05), tilted)]), down)
    assert found.slant[0] == pytest.approx(math.pi / 2 - 1.0, abs=1e-6)
    assert antipodal.pinches(rays.body([Geom("sphere", (0.01,))]), antipodal.Hands.at([Pose((0.1, 0, 0))])).width[0] < 0


def test_a_bottle_is_also_gripped_by_its_neck() -> None:
    widths = np.array([g.width for g in grips.ranked(bottle("b", Pose()), GRIPPER, 0.9)])
    assert np.isclose(widths, 0.028).any()
    assert np.isclose(widths, 0.068).any()


def test_a_flat_box_is_also_taken_by_a_hand_that_leans_but_upright_first() -> None:
    half = (0.04, 0.021, 0.009)
    found = grips.ranked(Thing("box", "cram:Product", Pose(), (Geom("box", half),), mass=0.1), GRIPPER, 0.9)
    above = [g for g in found if g.pose.rotate((0, 0, 1))[2] < -0.8]
    leaning = [g for g in above if g.lean]
    assert leaning and not above[0].lean
    for grip in leaning:
        assert abs(math.degrees(math.acos(-grip.pose.rotate((0, 0, 1))[2])) - 30) < 0.1
        assert abs(grip.pose.rotate((0, 1, 0))[2]) < 1e-6  # the pads stay along the faces
        ends = [grip.pose.apply((side * GRIPPER.pad[0] / 2, 0.0, GRIPPER.pad[1] / 2))[2] for side in (-1, 1)]
        assert -half[2] + 0.002 < min(ends) < half[2]  # off what it lies on
    assert {g.lean for g in grips.ranked(Thing("can", "cram:Product", Pose(), (Geom("cylinder", (0.03, 0.05)),)), GRIPPER, 0.9)} == {0.0}


@pytest.mark.heavy
def test_grasps_of_a_hand_that_leans_come_after_all_others_whatever_they_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a flat box before a wall, which leaves an upright hand no room on two of its sides."""
    monkeypatch.setattr(grips, "PER_LEAN", 0.0)
    mount, half = RobotMount("arm", "ur5e"), (0.04, 0.021, 0.03)
    floor = Thing("floor", "cram:Table", Pose((0.45, 0.0, -0.01)), (Geom("box", (0.5, 0.5, 0.01)),))
    wall = Thing("wall", "soma:DesignedFurniture", Pose((0.52, 0.0, 0.1)), (Geom("box", (0.02, 0.3, 0.1)),))
    box = Thing("box", "cram:Product", Pose((0.45, 0.0, half[2])), (Geom("box", half),), mass=0.1)
    belief = initial_belief(World((floor, wall, box), (mount,)), "arm", UR5E.home, 0.085)
    context = Context(UR5E, mount, {"box": "box"}, Engine().knowledge.taxonomy, seed=0)
    found = [f for f in ground(Location("grasp(box)", "grasp", "box"), belief, context) if isinstance(f, Grounding)]
    kinds = [2 if "by their ends" in f.key else int("leaning" in f.key) for f in found]
    assert {0, 1} <= set(kinds) and kinds == sorted(kinds)
    costs = {k: [f.cost for f, kind in zip(found, kinds, strict=True) if kind == k] for k in (0, 1)}
    assert min(costs[1]) < max(costs[0]), "else their costs alone put them last"


def test_fingers_that_hardly_pass_a_thing_are_dear_where_its_place_is_uncertain() -> None:
    """Open by 85 mm they leave 2.5 mm on each side across 80 mm of a box, 22.5 mm across 40; what is known is taken as before."""
    mount, half = RobotMount("arm", "ur5e"), (0.04, 0.02, 0.05)
    box = Thing("box", "cram:Product", Pose((0.45, 0.0, half[2])), (Geom("box", half),), mass=0.1)
    context = Context(UR5E, mount, {"box": "box"}, Engine().knowledge.taxonomy, seed=0)
    found = grips.ranked(box, GRIPPER, 0.9)

    def costs(sigma: float) -> dict[float, float]:
        """Least cost of a grasp across each width [m]."""
        belief = initial_belief(World((box,), (mount,)), "arm", UR5E.home, 0.085)
        belief = replace(belief, poses={"box": Estimate(box.pose, sigma)})
        room = HandRoom.about(box, belief, Arm(belief, context).scene())
        widths: dict[float, list[float]] = {}
        for cost, grasp in _in_order(found, box, belief, context, room):
            widths.setdefault(round(grasp.grip.width, 3), []).append(cost)
        return {width: min(own) for width, own in widths.items()}

    known, seen, doubted = costs(0.0), costs(0.001), costs(0.006)
    assert known == seen and known.keys() == {0.04, 0.08}
    assert doubted[0.04] == known[0.04] and doubted[0.08] - known[0.08] == pytest.approx(PER_TIGHT * (0.012 - 0.0025))


def under_a_bar(reach: float) -> dict[str, list[bool]]:
    """Whether a box of 50 mm, 110 mm high, catches on the pads when it is let go, by the axis that it is gripped across from above, best
    first; on a post over it is a bar that reaches so far from its middle along x [m]."""
    parts = Geom("box", (0.004, 0.004, 0.015), Pose((0, 0, 0.069))), Geom("box", (reach, 0.01, 0.002), Pose((0, 0, 0.085)))
    thing = Thing("carton", "cram:Product", Pose(), (Geom("box", (0.025, 0.025, 0.055)), *parts), mass=0.03)
    found: dict[str, list[bool]] = {}
    upright = [g for g in grips.ranked(thing, GRIPPER, 0.9) if not g.lean]
    for grip in (g for g in upright if re.match(r"from \+z .* geom 0, by the tips", g.name)):
        found.setdefault(re.findall("across (.)", grip.name)[0], []).append(grip.caught)
    return found


def test_a_cartons_ridge_is_not_taken_by_its_ends_before_its_body_is_taken_beside_it() -> None:
    """The ridge slipped out of pads that its ends covered by a ninth."""
    body, ridge = Geom("box", (0.026, 0.026, 0.055)), Geom("box", (0.0265, 0.003, 0.0035), Pose((0, 0, 0.0735)))
    found = grips.ranked(Thing("carton", "cram:Product", Pose(), (body, ridge), mass=0.03), GRIPPER, 0.9)
    ends = [k for k, g in enumerate(found) if g.coverage < 0.15 and g.lever < 0.001]
    beside = [k for k, g in enumerate(found) if g.coverage > 0.9 and 0.01 < g.lever < 0.02]
    assert ends and beside and beside[0] < ends[0]


def test_what_catches_on_a_pad_when_it_is_let_go_is_gripped_another_way_first() -> None:
    """The bar is right over the pads across x, flush with the faces, and not over those across y."""
    found = under_a_bar(0.025)
    assert next(iter(found)) == "y" and not any(found["y"]) and found["x"] and all(found["x"])


def test_a_bar_that_ends_before_the_pads_does_not_catch() -> None:
    found = under_a_bar(0.02)
    assert next(iter(found)) == "x" and not any(found["x"] + found["y"])


def between_walls(above: float) -> list[str]:
    """Which grasps have room, of a board that stands between two walls, 34 mm from each; these reach so far above it [m]."""
    mount, height = RobotMount("arm", "ur5e"), 0.1
    board = Thing("board", "cram:Product", Pose((0.45, 0.0, height / 2)), (Geom("box", (0.002, 0.05, height / 2)),), mass=0.1)
    half = (height + above) / 2
    walls = [
        Thing(f"wall_{k}", "soma:DesignedFurniture", Pose((0.45 + x, 0.0, half)), (Geom("box", (0.01, 0.3, half)),))
        for k, x in enumerate((-0.044, 0.044))
    ]
    belief = initial_belief(World((*walls, board), (mount,)), "arm", UR5E.home, 0.085)
    context = Context(UR5E, mount, {"board": "board"}, Engine().knowledge.taxonomy, seed=0)
    found = list(ground(Location("grasp(board)", "grasp", "board"), belief, context))
    return [f.key for f in found if isinstance(f, Grounding) and f.key.startswith("from +z")]


@pytest.mark.heavy
def test_where_walls_leave_the_palm_too_little_room_a_thing_is_taken_by_the_ends_of_the_pads() -> None:
    free, narrow = between_walls(0.050), between_walls(0.056)
    ends = ["by their ends" in name for name in free]
    assert any(ends) and ends == sorted(ends), "they come last"
    assert narrow and all("by their ends" in name for name in narrow)
    assert not between_walls(0.062)
