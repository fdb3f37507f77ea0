"""Places for a held thing: each filter refuses with numbers what its sibling lets pass; generators come best first."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import shapely
from conftest import Run
from helpers.placing import HELD, MOUNT, believed, context_of, query_on, spot_at
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import (
    Feature,
    Geom,
    GripFacts,
    Held,
    Location,
    Place,
    Pose,
    Release,
    Stage,
    Thing,
    World,
    initial_belief,
)
from cramlite.plugin import Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing import stable_poses
from cramlite_plugins.locations.placing.checks import hand, order, shapes
from cramlite_plugins.locations.placing.query import Obstacle, Query
from cramlite_plugins.locations.placing.visibility import visible
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.motion_planning.too_far import too_far
from cramlite_plugins.motions.gripping import release_opening
from cramlite_plugins.objects.products_and_fixtures import basket, block
from cramlite_plugins.objects.vessels import bowl
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes import ray_casting as rays
from cramlite_plugins.shapes.surfaces import Surface
from cramlite_plugins.simulation.model.compile import compile_world


def test_supported_means_the_centre_of_mass_is_above() -> None:
    wanted = query_on(believed())
    assert not shapes.supported(spot_at((0.45, -0.35, 0.22)), wanted)
    assert not shapes.supported(spot_at((0.59, -0.35, 0.22)), wanted)
    assert "10 mm beyond the edge of 'shelf'" in shapes.supported(spot_at((0.61, -0.35, 0.22)), wanted)


def test_inside_means_all_of_it_is_over_the_opening() -> None:
    box = basket("box", Pose((0.4, -0.4, 0.0)), (0.12, 0.10, 0.1))
    wanted = query_on(believed(box), "box")
    assert not shapes.inside(spot_at((0.4, -0.4, 0.1)), wanted)
    said = shapes.inside(spot_at((0.44, -0.4, 0.1)), wanted)
    assert isinstance(said, Refused) and "it takes 40 mm of the 100 mm width of 'box' and sticks out by 10 mm" in said.reason
    assert said.remedy is None, "elsewhere it fits"


def test_an_opening_that_is_too_small_says_what_the_best_turn_needs() -> None:
    """A block of 40 x 40 mm, turned by 45 deg as it is tried, in openings of 30 x 60 and 43 x 60 mm."""
    turned = Pose.from_rotvec((0.4, -0.4, 0.1), (0.0, 0.0, np.pi / 4))
    for width, says in ((0.05, "needs 42 x 42 mm at its best turn, the opening of 'box' is 30 x 60 mm"), (0.063, "")):
        wanted = query_on(believed(basket("box", Pose((0.4, -0.4, 0.0)), (width, 0.08, 0.1))), "box")
        spot = spot_at((0.4, -0.4, 0.1))
        said = shapes.inside(replace(spot, thing=turned), wanted)
        assert isinstance(said, Refused)
        assert (said.remedy.says if said.remedy else "").startswith(f"'it' {says}" if says else "")
        assert bool(said.remedy) == bool(says)


def test_near_and_beside_are_measured_from_middle_to_middle() -> None:
    tin = block("tin", Pose((0.45, -0.45, 0.19)), (0.05, 0.05, 0.08))
    near = query_on(believed(tin), where={"near": "tin", "within": 0.12})
    assert not shapes.near(spot_at((0.45, -0.35, 0.22)), near)
    assert "150 mm from 'tin', up to 120 mm are near" in shapes.near(spot_at((0.45, -0.30, 0.22)), near)
    rolls = replace(spot_at((0.45, -0.35, 0.22)), lies=Pose((0.45, -0.30, 0.2)))
    assert "150 mm from 'tin'" in shapes.near(rolls, near), "where it comes to rest"
    for side, good, bad in (
        ("left_of", (0.45, -0.35, 0.2), (0.45, -0.55, 0.2)), ("right_of", (0.45, -0.55, 0.2), (0.45, -0.35, 0.2)),
        ("behind", (0.55, -0.45, 0.2), (0.35, -0.45, 0.2)), ("in_front_of", (0.35, -0.45, 0.2), (0.55, -0.45, 0.2)),
    ):  # fmt: skip
        wanted = query_on(believed(tin), where={side: "tin"})
        assert not shapes.beside(spot_at(good), wanted)
        assert "at least 20 mm is needed" in shapes.beside(spot_at(bad), wanted)


def test_reachable_asks_the_arm_alone() -> None:
    wanted = query_on(believed())
    assert not hand.reachable(spot_at((0.45, -0.35, 0.25)), wanted)
    refused = hand.reachable(spot_at((1.2, -0.35, 0.25)), wanted)
    assert isinstance(refused, Refused) and "wrist centre at 1.316 m > 0.917 m" in refused.reason
    assert refused.remedy is not None and "0.40 m out of reach" in refused.remedy.says


def test_what_is_hardly_out_of_reach_says_so_in_millimetres() -> None:
    far, near = (too_far("tin", gap, UR5E).says for gap in (0.2, 0.0011))
    assert "'tin' is 0.20 m out of reach" in far and "'tin' is 2 mm out of reach" in near


def test_collision_free_names_what_is_in_the_way() -> None:
    tin = block("tin", Pose((0.45, -0.35, 0.23)), (0.05, 0.05, 0.16))
    wanted = query_on(believed(tin))
    refused = hand.collision_free(spot_at((0.46, -0.34, 0.25)), wanted)
    assert isinstance(refused, Refused) and "'tin'" in refused.reason and refused.blocking == (("tin",),)
    assert not hand.collision_free(spot_at((0.45, -0.23, 0.25)), query_on(believed()))


def test_where_something_is_over_an_opening_the_way_down_needs_room_too() -> None:
    """A post between the stand-off and the place, near neither."""
    spot = spot_at((0.45, -0.35, 0.25))
    far = replace(spot, before=replace(spot.pose, position=(0.45, 0.25, 0.28)))
    post = query_on(believed(block("post", Pose((0.45, -0.05, 0.4)), (0.02, 0.02, 0.8))))
    covered = replace(post, covers=(Obstacle("post", shapely.box(-1.0, -1.0, 1.0, 1.0)),))
    refused = hand.room(far, covered)
    assert isinstance(refused, Refused) and "on its way down" in refused.reason and refused.where is Stage.BEFORE
    assert not hand.room(far, post) and not hand.room(spot, covered)


def test_a_refusal_names_its_check_and_where_on_the_way_it_objects() -> None:
    spot = spot_at((0.46, -0.34, 0.25))
    far = replace(spot.pose, position=(0.46, -0.34, 0.6))
    tin = query_on(believed(block("tin", Pose((0.45, -0.35, 0.23)), (0.05, 0.05, 0.16))))
    for before, at, where in ((far, spot.pose, Stage.POSE), (spot.pose, far, Stage.BEFORE)):
        no = order.first_objection(replace(spot, before=before, pose=at), tin, order.REACHED)
        assert no is not None and (no.check, no.where) == ("collision-free", where)


def test_a_thing_is_let_go_of_where_the_fingers_can_open() -> None:
    """Beside a thing of 50 mm in a bowl of 130 mm the closed fingers fit, 85 mm apart only over the rim."""
    bowl_ = bowl("shelf", Pose((0.45, -0.3, 0.2)), 0.065)
    it = block("it", Pose((0.4, 0.3, 0.5)), (0.05, 0.05, 0.05))
    held = Held("it", Pose((0, 0, 0.0), Pose.from_axes((0, 0, 0), (0, 0, -1), (0, 1, 0)).quaternion), 0.05)
    down = inverse(UR5E, Pose.from_axes((0.45, 0.0, 0.45), (0, 0, -1), (0, 1, 0)), seed=UR5E.home)[0]
    belief = initial_belief(World((bowl_, it), (MOUNT,)), "arm", down, 0.05).grasped(held)
    answers = list(itertools.islice(ground(Location("in(shelf)", "in", "shelf"), belief, context_of(belief)), 40))
    refused = [a for a in answers if isinstance(a, Refused) and "not free to open: with open fingers" in a.reason]
    place = next(a.value for a in answers if isinstance(a, Grounding))
    lowest = stable_poses.OFF_FLOOR - bowl_.feature("cram:Cavity").size["height"]  # type: ignore[union-attr]
    assert refused and place.release.height_m > lowest + stable_poses.RISE / 2


def test_visible_means_that_others_do_not_hide_it() -> None:
    eye = (0.45, -1.2, 0.25)
    screen = block("screen", Pose((0.45, -0.55, 0.25)), (0.3, 0.02, 0.3))
    spot = spot_at((0.45, -0.35, 0.22))
    assert not visible(spot, query_on(believed(), where={"visible_from": eye}))
    assert not visible(spot, query_on(believed(screen)))
    said = visible(spot, query_on(believed(screen), where={"visible_from": eye}))
    assert "0 % of it is seen, 50 % is needed; 'screen' hides most" in said
    assert "none is fixed" in visible(spot, query_on(believed(), where={"visible_from": "camera"}))


def test_a_camera_looks_one_way() -> None:
    from cramlite.model import Camera

    wanted = query_on(believed(), where={"visible_from": "camera"})
    towards = Pose.from_axes((0.45, -1.2, 0.25), (0, 1, 0), (1, 0, 0))
    away = Pose.from_axes((0.45, -1.2, 0.25), (1, 0, 0), (0, -1, 0))
    for pose, sees in ((towards, True), (away, False)):
        said = visible(
            spot_at((0.45, -0.35, 0.22)), replace(wanted, arm=Arm(wanted.belief, replace(wanted.context, camera=Camera(pose))))
        )
        assert (not said) == sees
        assert sees or "deg off the camera's axis" in said


coordinate = st.floats(-0.3, 0.3)


@examples(60)
@given(st.tuples(coordinate, coordinate, coordinate), st.tuples(coordinate, coordinate, coordinate), st.sampled_from(range(4)))
def test_rays_meet_what_the_ray_caster_of_mujoco_meets(a: Any, b: Any, kind: int) -> None:
    geom = (
        Geom("box", (0.05, 0.08, 0.1)), Geom("sphere", (0.09,)), Geom("cylinder", (0.06, 0.1)), Geom("capsule", (0.05, 0.07)),
    )[kind]  # fmt: skip
    thing = Thing("it", "cram:Product", Pose(), (geom,), mass=1.0)
    way = np.subtract(b, a)
    if np.linalg.norm(way) < 0.05:
        return
    compiled = compile_world(World((thing,)), {})
    data = compiled.data()

    def hit(start: Any, end: Any) -> bool:
        way = np.subtract(end, start)
        gap = mujoco.mj_ray(compiled.model, data, np.asarray(start, float), way, None, True, -1, np.zeros(1, np.int32))
        return 0 <= gap <= 1

    expected = hit(a, b)
    got = rays.crossed(rays.body([geom]), np.asarray([a], float), np.asarray([b], float))
    if got != expected:  # only where the surface is grazed, or both ends are inside, which a ray caster does not see
        inside = rays.crossed(rays.body([geom]), np.asarray([a], float), np.asarray([a], float) + 1e-7 * way)
        grazed = rays.crossed(rays.body([geom]), np.asarray([a], float) + 1e-3, np.asarray([b], float) + 1e-3)
        assert (got and inside) or grazed != got


def test_places_come_lazily_and_best_first() -> None:
    belief = believed()
    found = ground(Location("on(shelf)", "on", "shelf"), belief, context_of(belief))
    assert found is not None
    good = [g for g in itertools.islice(found, 6) if isinstance(g, Grounding)]
    assert good and [g.cost for g in good] == sorted(g.cost for g in good)
    assert all("from its middle" not in g.reason for g in good), "the middle first"


def test_near_draws_the_position_and_refusals_name_their_filter() -> None:
    tin = block("tin", Pose((0.45, -0.45, 0.19)), (0.04, 0.04, 0.08))
    belief = believed(tin)
    location = Location("on(shelf)", "on", "shelf", {"near": "tin", "within": 0.13, "left_of": "tin"})
    answers = list(itertools.islice(ground(location, belief, context_of(belief)), 60))
    places = [a for a in answers if isinstance(a, Grounding)]
    assert places
    for answer in places:
        thing = answer.value.pose * HELD.tcp_to_thing
        assert np.hypot(thing.position[0] - 0.45, thing.position[1] + 0.45) <= 0.13
        assert thing.position[1] > -0.45
    nowhere = Location("on(shelf)", "on", "shelf", {"left_of": "tin", "right_of": "tin"})
    with pytest.raises(Unresolvable, match=r"not beside: .* at least 20 mm is needed") as none:
        list(ground(nowhere, belief, context_of(belief)))
    assert set(none.value.because) == {"shelf"}, "no other grasp, and no other way of carrying it, would help"


SHELF = Path(__file__).parents[3] / "scenarios" / "place_on_shelf.yaml"


@pytest.mark.parametrize(
    ("where", "code", "words"),
    [
        ("{near: block, within: 20 mm}", 2, ("'blok'",)),
        ("{left_off: block}", 2, ("left_of",)),
        ("{near: floor, within: 1 mm}", 1, ("not near", "mm from 'floor', up to 1 mm are near")),
    ],
)
def test_where_in_a_scenario(where: str, code: int, words: tuple[str, ...], run: Run, tmp_path: Path) -> None:
    if code == 2 and "near" in where:
        where = where.replace("block", "blok")
    path = tmp_path / "s.yaml"
    path.write_text(SHELF.read_text().replace("Relatum: shelf}", f"Relatum: shelf, where: {where}}}"))
    ran = run("resolve", path, "--no-report", "--out", tmp_path / "run")
    assert ran.code == code, ran.err
    assert "Traceback" not in ran.err
    assert all(w in ran.err for w in words), ran.err


# Into what is not level


def pot(height: float, gap: float = 0.005) -> Thing:
    """Four walls of 10 mm around the block with a gap, on a floor of 10 mm; its origin is the floor's upper side."""
    inner = 0.02 + gap
    walls = (
        Geom("box", (w, d, height / 2), Pose((x, y, height / 2)))
        for x, y, w, d in ((inner + 0.005, 0, 0.005, inner + 0.01), (-inner - 0.005, 0, 0.005, inner + 0.01),
                           (0, inner + 0.005, inner, 0.005), (0, -inner - 0.005, inner, 0.005))
    )  # fmt: skip
    floor = Geom("box", (inner, inner, 0.005), Pose((0, 0, -0.005)))
    hollow = Feature("cavity", "cram:Cavity", Pose((0, 0, height)), {"width": 2 * inner, "depth": 2 * inner, "height": height})
    return Thing("pot", "soma:Bowl", Pose((0.45, -0.35, 0.17)), (floor, *walls), (hollow,), mass=0.3)


def into_pot(height: float, gap: float = 0.005, opening: float = 0.04) -> Query:
    """Fingers that hold something so far open may open by 10 or 30 mm more, or all the way."""
    belief = believed(pot(height, gap)).grasped(replace(HELD, opening=opening))
    return replace(query_on(belief, "shelf"), entity="pot", under=belief.world.thing("pot"), settles=True)


@pytest.mark.parametrize(("height", "meets"), [(0.03, False), (0.09, True)])
def test_the_hand_may_not_be_the_first_to_meet_what_a_thing_is_put_into(height: float, meets: bool) -> None:
    refused = hand.hand_off(spot_at((0.45, -0.35, 0.24)), into_pot(height))
    assert (isinstance(refused, Refused) and "'pot'" in refused.reason) == meets
    assert not hand.hand_off(spot_at((0.45, -0.35, 0.24)), replace(into_pot(height), settles=False))


def test_fingers_open_as_wide_as_there_is_room() -> None:
    wide, narrow = into_pot(0.09, 0.04), into_pot(0.09, 0.04, 0.085)
    at = spot_at((0.45, -0.35, 0.24))
    assert wide.openings == pytest.approx((0.085, 0.07, 0.05))
    assert hand.opened(at, wide) == pytest.approx(0.07)
    assert isinstance(hand.opened(at, narrow), Refused)
    refused = hand.room_to_open(at, narrow)
    assert isinstance(refused, Refused) and refused.reason.startswith("with open fingers")


@pytest.mark.parametrize(("height", "stays"), [(0.06, True), (0.04, False)])
def test_what_sinks_into_a_hollow_needs_no_level_support(height: float, stays: bool) -> None:
    """Its centre of mass, 50 mm over its lowest point, is below the rim or above it."""
    belief = believed(pot(height))
    slope = Surface(Pose((0.45, -0.35, 0.17)), shapely.box(0.03, -0.01, 0.04, 0.01))  # it touches on one side alone
    wanted = replace(query_on(belief, "shelf"), entity="pot", target=slope, under=belief.world.thing("pot"))
    assert (shapes.supported(spot_at((0.45, -0.35, 0.24)), wanted) == "") == stays
    assert shapes.supported(spot_at((0.45, -0.35, 0.24)), replace(wanted, under=None))
    assert shapes.supported(spot_at((0.45 + 0.02, -0.35, 0.24)), wanted)  # beside its middle


def test_a_place_says_how_wide_the_fingers_open_when_they_let_go() -> None:
    belief = believed()
    grasp = Place(Pose(), Pose(), 0.06, thing="it", grip=GripFacts(0.04))
    narrow, elsewhere = (Place(Pose(), Pose(), thing=name, release=Release(0.0, 0.05)) for name in ("it", "tin"))

    def wide(*places: Place) -> float:
        return release_opening(belief, replace(context_of(belief), bindings={str(k): p for k, p in enumerate(places)}))

    assert (wide(), wide(grasp), wide(grasp, narrow), wide(grasp, elsewhere)) == (0.085, 0.06, 0.05, 0.06)
    assert wide(narrow, grasp) == 0.06  # it was put down there before, and grasped again


@pytest.mark.parametrize(("play", "clearance"), [(0.01, 0.0025), (0.1, None)])
def test_between_near_walls_less_clearance_is_kept(play: float, clearance: float | None) -> None:
    """Else a mug was let go of above the rim of a compartment, fell 120 mm, and was thrown out by another simulator's physics."""
    query = query_on(believed(block("box", Pose((0.45, -0.35, 0.2)), (0.2, 0.2, 0.1))), "box")
    opening = shapely.box(-0.02 - play / 2, -0.1, 0.02 + play / 2, 0.1)
    found = shapes.snug(replace(query, target=Surface(query.target.pose, opening)), query.target.pose)
    assert found.clearance == (None if clearance is None else pytest.approx(clearance, abs=1e-6))
