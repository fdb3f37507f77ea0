"""Collisions: against Coal, the capsule trap, allowed contacts, things in the hand, lines between positions."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest
from helpers import coal_check
from helpers.scenes import BLOCK, ROBOTS, TABLE, WALL, box, down, make, stance, world
from msgspec.structs import replace

from cramlite.model import Floats, Geom, Pose, Thing
from cramlite_plugins.kinematics.blends import Corner
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.motion_planning.scene_of_world import scene
from cramlite_plugins.robots.ur5e import UR5E

ROD = Thing("rod", "t:rod", Pose((0.45, -0.3, 0.2)), (Geom("capsule", (0.01, 0.15)),))


def agreement(place: PlanningScene, count: int) -> list[tuple[bool, float]]:
    """(free for us, smallest distance for Coal) at random positions."""
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    rng = np.random.default_rng(0)
    result = []
    for q in rng.uniform(-3, 3, (count, 6)):
        result.append((place.free(q), min(coal_check.distances(place, q, solids, checked).values())))
    return result


def test_coal_agrees_on_random_positions() -> None:
    answers = agreement(make(TABLE, WALL, ROD, BLOCK, held={"block": Pose((0, 0, 0.02))}), 250)
    assert any(ours for ours, _ in answers)
    assert any(not ours for ours, _ in answers)
    for ours, theirs in answers:
        assert theirs > 0.0044 if ours else theirs < 0.005


def test_near_pairs_are_all_seen_with_the_distance_that_coal_measures() -> None:
    place = make(TABLE, WALL, ROD, BLOCK, held={"block": Pose((0, 0, 0.02))})
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    for q in np.random.default_rng(1).uniform(-3, 3, (150, 6)):
        truth = coal_check.distances(place, q, solids, checked)
        for level in place.levels:
            ours = {(min(g, h), max(g, h)): d for g, h, d in place._look(q, level)}
            for pair, d in truth.items():
                if d < level.distance - 1e-5:
                    assert pair in ours
                    assert ours[pair] == pytest.approx(d, abs=1e-5) if d > 0 else ours[pair] < 1e-5


def test_near_convex_hulls_are_all_seen() -> None:
    """They cannot be made bigger like other shapes. Truth: the distance of each pair, measured by itself."""
    rng = np.random.default_rng(0)
    large, small = (hull(rng.normal(size=(20, 3)) * size) for size in (0.06, 0.03))
    rock, gem = (Thing(n, f"t:{n}", Pose(), (g,), mass=0.1) for n, g in (("rock", large), ("gem", small)))
    place = make(rock, gem, held={"gem": Pose((0, 0, 0.05))})
    q, seen = UR5E.home, [0] * len(place.levels)
    names, middle = [o.name for o in place.compiled.owners], place.tip(UR5E.home)
    pair = names.index("rock"), names.index("gem")
    for offset in rng.uniform(-0.25, 0.25, (300, 3)):
        x, y, z = middle + offset
        moved = place.at({"rock": Pose((float(x), float(y), float(z)))})
        for k, level in enumerate(moved.levels):
            near = {frozenset((g, h)) for g, h, _ in moved._look(q, level)}
            if mujoco.mj_geomDistance(place.compiled.model, moved.data, *pair, 0.1, None) < level.distance - 1e-5:
                seen[k] += 1
                assert frozenset(pair) in near
    assert seen == sorted(seen)
    assert seen[-1] > seen[0] > 0


def hull(corners: Floats) -> Geom:
    """A convex hull of points (n, 3)."""
    points = tuple((float(x), float(y), float(z)) for x, y, z in corners)
    return Geom("convex", tuple(float(v) for v in np.abs(corners).max(axis=0)), corners=points)


def test_a_contact_margin_would_miss_boxes() -> None:
    """The reason for inflated.py: if this fails, MuJoCo is mended and a margin would do."""
    xml = """<mujoco><worldbody><geom type="box" size=".02 .02 .05"/><body><freejoint/>
             <geom type="box" size=".02 .03 .05" margin=".04"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data, rng, missed = mujoco.MjData(model), np.random.default_rng(0), 0
    for _ in range(2000):
        data.qpos[:3], data.qpos[3:] = rng.uniform(-0.1, 0.1, 3), rng.normal(size=4)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        missed += data.ncon == 0 and mujoco.mj_geomDistance(model, data, 0, 1, 1.0, np.zeros(6)) < 0.03
    assert missed > 0


def test_a_capsule_through_a_plate_is_found() -> None:
    """MuJoCo 4.0.0 misses it; the planning model must not."""
    stick = Thing("stick", "t:stick", Pose(), (Geom("capsule", (0.05, 0.2)),), mass=0.1)
    held = {"stick": Pose((0, 0, 0.2))}
    q = stance(make(stick, held=held), down(0.45, 0.3, 0.2))
    plate = box("plate", (0.15, 0.15, 0.02), (0.45, 0.3, 0.0))
    assert "'stick'" in make(plate, stick, held=held).why(q)
    assert make(replace(plate, pose=Pose((0.45, 0.3, -0.3))), stick, held=held).free(q)


def test_reasons_name_the_wall_and_the_depth() -> None:
    place = make(TABLE, WALL)
    inside = inverse(UR5E, down(0.55, 0.0, 0.2))[0]
    assert not place.free(inside)
    assert any("wall" in (a, b) and depth > 0.01 for a, b, depth in place.collisions(inside))
    assert "mm inside 'wall'" in place.why(inside)
    assert place.clearance(inside) < 0
    beside = stance(place, down(0.5, 0.25, 0.2))
    assert place.why(beside) == ""
    assert place.collisions(beside) == ()
    assert "elbow" in place.why((0, 0, 4.0, 0, 0, 0))


def test_a_collision_holds_all_that_is_needed_to_come_to_it_again() -> None:
    """The state that it describes, compiled anew: the bodies that it names are as deep in each other as it says."""
    poses = {"block": Pose((0.5, 0.35, 0.05))}
    place = make(TABLE, WALL, ROD, BLOCK, poses=poses)
    for q in np.random.default_rng(2).uniform(-3, 3, (60, 6)):
        found = place.collision(q)
        if found is None:
            assert place.free(q)
            continue
        assert found.moved == poses
        mounts = tuple(replace(m, base=found.base) for m in world(TABLE, WALL, ROD, BLOCK).robots)
        again = scene(replace(world(TABLE, WALL, ROD, BLOCK), robots=mounts), ROBOTS, found.robot, poses=found.moved, opening=found.opening)
        depths = {frozenset(names): depth for *names, depth in again.collisions(found.joints)}
        assert depths[frozenset((found.one, found.other))] == pytest.approx(found.depth, abs=1e-5)
    assert place.collision((0, 0, 4.0, 0, 0, 0)) is None  # beyond a limit, whatever is touched there


def test_allowed_contact_is_for_the_named_pair_only() -> None:
    low = down(0.45, 0.3, 0.01)  # the block reaches into the palm
    other = box("other", (0.02, 0.02, 0.05), (0.45, 0.3, 0.09), 0.2)
    touching = {"allowed": frozenset({frozenset({"effector", "other"})})}
    q = stance(make(), low)
    assert not make(other).free(q)
    assert make(other, **touching).free(q)
    twin = replace(other, name="twin")
    assert not make(other, twin, **touching).free(q)
    assert "'twin'" in make(other, twin, **touching).why(q)


def test_allowed_part_does_not_allow_the_rest_of_the_thing() -> None:
    geoms = (Geom("box", (0.02, 0.02, 0.05), part="grip"), Geom("box", (0.2, 0.2, 0.01), Pose((0, 0, 0.02))))
    thing = Thing("tray", "t:tray", Pose((0.45, 0.3, 0.1)), geoms)
    q = stance(make(), down(0.45, 0.3, 0.1))
    part = make(thing, allowed=frozenset({frozenset({"effector", "tray/grip"})}))
    whole = make(thing, allowed=frozenset({frozenset({"effector", "tray"})}))
    assert all("tray/grip" not in (a, b) for a, b, _ in part.collisions(q))
    assert any("tray" in (a, b) for a, b, _ in part.collisions(q))
    assert not any("tray" in (a, b) for a, b, _ in whole.collisions(q) if "effector" in a or "effector" in b)


def test_a_thing_in_the_hand_moves_with_it_and_collides() -> None:
    q = stance(make(TABLE), down(0.45, 0.3, 0.1))
    assert make(TABLE, BLOCK, held={"block": Pose((0, 0, 0.02))}).free(q)
    long = replace(BLOCK, geoms=(Geom("box", (0.02, 0.02, 0.15)),))
    assert "'block'" in make(TABLE, long, held={"block": Pose()}).why(q)


def test_what_the_hand_meets_it_meets_at_every_position_of_the_arm() -> None:
    """Whether there is room for the hand and the block that it holds is known from the pose alone, as from all joint positions for it."""
    place, count = make(TABLE, WALL, BLOCK, held={"block": Pose((0, 0, 0.02))}), [0, 0]
    base = next(m.base for m in world().robots)
    for x, y, z in np.random.default_rng(5).uniform((0.4, -0.1, 0.0), (0.65, 0.35, 0.3), (60, 3)).tolist():
        solutions, met = inverse(UR5E, down(x, y, z)), place.met(base * down(x, y, z))
        hand = [p for p in place.collisions(solutions[0]) if not any(n.startswith("arm1/") for n in p[:2])]
        count[met is not None] += 1
        assert (met is not None) == bool(hand)
        assert met is None or not any(place.free(q) for q in solutions)
        assert met is None or all(name in met.reason for name in hand[0][:2])
    assert min(count) > 10


def test_things_are_reposed() -> None:
    place = make(TABLE, BLOCK)
    q = stance(place, down(0.45, -0.3, 0.03))
    there = place.at({"block": Pose((0.45, -0.3, 0.05))})
    assert not there.free(q)
    assert place.free(q)
    assert not make(TABLE, BLOCK, poses={"block": Pose((0.45, -0.3, 0.05))}).free(q)


def test_fingers_open_and_close() -> None:
    q = stance(make(), down(0.45, 0.3, 0.05))
    thin = box("thin", (0.03, 0.01, 0.045), (0.45, 0.3, 0.01))
    assert make(thin, opening=0.085).free(q)
    assert not make(thin, opening=0.0).free(q)


def test_a_thin_wall_between_two_free_positions_is_found() -> None:
    """A line that a coarse grid would jump over."""
    place = make(box("sheet", (0.3, 0.001, 0.3), (0.6, 0.0, 0.3)))
    q = stance(place, down(0.5, 0.25, 0.2))
    beyond = (q[0] - 1.2, *q[1:])
    assert place.free(beyond)
    part = place.blocked(q, beyond)
    assert part is not None
    assert "'sheet'" in place.why([a + part * (b - a) for a, b in zip(q, beyond, strict=True)])
    assert not place.line_free(q, beyond)
    assert make().blocked(q, beyond) is None


def test_of_several_lines_each_blocked_one_is_told_with_a_place_on_it() -> None:
    place = make(TABLE, WALL, BLOCK)
    free = [tuple(q) for q in np.random.default_rng(5).uniform(-2, 2, (60, 6)).tolist() if place.free(q)]
    lines = list(itertools.pairwise(free))
    found = place.where_blocked(lines)
    assert [at is None for at in found] == [place.line_free(*line) for line in lines]
    told = [(line, at) for line, at in zip(lines, found, strict=True) if at is not None]
    assert 0 < len(told) < len(lines)
    for (a, b), at in told:
        part = np.dot(np.subtract(at, a), np.subtract(b, a)) / np.dot(np.subtract(b, a), np.subtract(b, a))
        assert np.allclose(at, np.asarray(a) + part * np.subtract(b, a)) and not make(TABLE, WALL, BLOCK).free(at)


def test_what_was_too_close_lately_changes_no_answer() -> None:
    place = make(TABLE, WALL, BLOCK)
    places = [tuple(q) for q in np.random.default_rng(6).uniform(-3, 3, (120, 6)).tolist()]
    after_others = [place.free(q) for q in places]
    assert after_others == [replace(place, known={}, lately=[]).free(q) for q in places]


def test_lines_found_free_are_free_on_a_fine_grid_for_coal() -> None:
    place = make(TABLE, WALL, BLOCK)
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    rng, found = np.random.default_rng(3), 0
    for a, b in rng.uniform(-2, 2, (150, 2, 6)):
        b = a + (b - a) * 0.25
        if place.free(a) and place.line_free(a, b) and found < 6:
            found += 1
            for t in np.linspace(0, 1, 60):
                assert min(coal_check.distances(place, a + t * (b - a), solids, checked).values()) > 0
    assert found == 6


def test_blends_found_free_are_free_on_a_fine_grid_for_coal_and_others_are_blocked() -> None:
    """Free lines lead to the corner and from it; the parabola between them leaves both."""
    place = make(TABLE, WALL, BLOCK)
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    rng, seen = np.random.default_rng(5), {True: 0, False: 0}
    for corner, before, after in rng.uniform(-2, 2, (400, 3, 6)):
        start, goal = corner + 0.2 * (before - corner), corner + 0.2 * (after - corner)
        if not (place.free(corner) and place.line_free(corner, start) and place.line_free(corner, goal)):
            continue
        curve = Corner(start, corner, goal, 1.0)
        found = place.blend_free(start, corner, goal)
        if seen[found] < 3:
            seen[found] += 1
            least = min(min(coal_check.distances(place, curve.at(t), solids, checked).values()) for t in np.linspace(0, 1, 25))
            assert least > 0 if found else least < 0.0051
    assert seen[True] == 3


def test_a_blend_through_a_sheet_is_blocked_where_both_its_ends_are_free() -> None:
    place = make(box("sheet", (0.3, 0.001, 0.3), (0.6, 0.0, 0.3)))
    q = np.array(stance(place, down(0.5, 0.25, 0.2)))
    beyond, aside = q - [1.2, 0, 0, 0, 0, 0], q - [0.6, 0.01, 0, 0, 0, 0]
    assert place.free(q)
    assert place.free(beyond)
    assert not place.blend_free(q, aside, beyond)
    assert make().blend_free(q, aside, beyond)


def test_a_position_that_was_looked_at_is_looked_at_again_where_things_or_demands_are_others() -> None:
    place = make(TABLE, BLOCK)
    q = stance(place, down(0.45, 0.2, 0.25))
    assert place.free(q)
    before = place.checks[0]
    assert place.free(list(q))
    assert place.checks[0] == before
    assert not place.at({"block": place.tcp(q) * Pose((0, 0, -0.05))}).free(q)
    assert place.free(q)


def test_clearance_is_relaxed_near_a_start_that_is_close_and_nowhere_else() -> None:
    post = box("post", (0.02, 0.02, 0.14), (0.45, 0.2845, 0.14))  # 2 mm beside the open finger
    place = make(post)
    q = stance(make(), down(0.45, 0.2, 0.25))
    assert place.clearance(q) == pytest.approx(0.002, abs=1e-4)
    assert "only 2.0 mm from 'post'" in place.why(q)
    assert place.relaxed([q]).free(q)
    assert not place.relaxed([UR5E.home]).free(q)
    deeper = make(replace(post, pose=Pose((0.45, 0.2805, 0.14))))
    assert not deeper.relaxed([q]).free(q)


@pytest.mark.parametrize(("depth", "left"), [(0.0008, True), (0.0013, False)])
def test_a_start_that_leans_on_a_neighbour_may_be_left_and_one_that_is_stuck_in_it_may_not(depth: float, left: bool) -> None:
    post = box("post", (0.02, 0.02, 0.14), (0.45, 0.2825 - depth, 0.14))
    place, q = make(post, clearance=0.0), stance(make(), down(0.45, 0.2, 0.25))
    assert place.clearance(q) == pytest.approx(-depth, abs=2e-4)
    assert place.relaxed([], start=q).free(q) is left
    assert not place.relaxed([q]).free(q), "a goal may not be as deep"


def test_bad_input_is_refused() -> None:
    with pytest.raises(ValueError, match=r"clearance 0\.5 m"):
        make(TABLE, clearance=0.5)
    with pytest.raises(KeyError, match="no thing 'cup'"):
        make(TABLE, held={"cup": Pose()})
    with pytest.raises(KeyError):
        scene(world(TABLE), ROBOTS, "arm9")


def test_a_model_that_was_kept_says_of_moved_things_what_one_of_its_own_says() -> None:
    cell, held = world(TABLE, BLOCK, ROD), {"rod": Pose((0, 0, 0.05))}
    aside = Pose((0.3, -0.3, 0.1), (0.9, 0.1, 0.2, 0.3))
    first = scene(cell, ROBOTS, "arm1", held=held)
    kept = scene(cell, ROBOTS, "arm1", poses={"block": aside}, held=held)
    own = scene(cell.moved({"block": aside}), ROBOTS, "arm1", held=held)
    assert kept.compiled.model is first.compiled.model is not own.compiled.model
    assert kept.compiled.world == own.compiled.world
    positions = np.random.default_rng(4).uniform(-3, 3, (200, 6))
    assert [kept.clearance(q) for q in positions] == [own.clearance(q) for q in positions]
    assert any(first.clearance(q) != own.clearance(q) for q in positions)
    elsewhere = scene(cell, ROBOTS, "arm1", held={"rod": Pose((0, 0, 0.06))})
    assert elsewhere.compiled.model is not first.compiled.model
