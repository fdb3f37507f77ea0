"""Transfers keep what a proof doubts from things, where there is room for it."""

from __future__ import annotations

import pytest
from helpers import coal_check
from helpers.placing import taxonomy
from helpers.scenes import BLOCK, TABLE, box, down, stance, world
from msgspec.structs import replace

from cramlite.model import Belief, ErrorModel, Thing
from cramlite.model.belief import initial_belief
from cramlite.plugin import Context, Refused
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planner import Path, plan, resampled
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.motion_planning.reach import WIDEST, make_scene
from cramlite_plugins.motion_planning.with_room import doubt_margins, planned
from cramlite_plugins.robots.ur5e import UR5E

ERRORS = ErrorModel()


def asked(*things: Thing, errors: ErrorModel | None) -> tuple[PlanningScene, Belief, Context]:
    there = world(*things)
    belief = initial_belief(there, "arm1", UR5E.home, 0.085)
    context = Context(UR5E, there.robots[0], {}, taxonomy(), errors=errors)
    return make_scene(belief, context), belief, context


def room(place: PlanningScene, path: Path, names: set[str]) -> float:
    """Smallest distance of the arm from some things along a path [m]."""
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    named = [(g, h) for g, h in checked if {place.compiled.owners[g].name, place.compiled.owners[h].name} & names]
    return min(min(coal_check.distances(place, q, solids, named).values()) for q in resampled(path.points, 0.02))


def across(errors: ErrorModel | None, top: float) -> tuple[Path, float, str]:
    """A path from one side of a wall of a given height to the other [m], its room over the wall, and what is told."""
    wall = box("wall", (0.3, 0.02, top / 2), (0.55, 0.0, top / 2))
    place, belief, context = asked(TABLE, wall, errors=errors)
    start = stance(place, down(0.5, -0.3, 0.4))
    goals = [q for q in inverse(UR5E, down(0.5, 0.3, 0.4), seed=start) if abs(q[0] - start[0]) < 2][:4]
    path, said = planned(place, belief.moved(start), context, goals, seed=1, speed=1.05, acceleration=1.4)
    assert isinstance(path, Path), path
    return path, room(place, path, {"wall"}), said


def test_a_line_that_keeps_the_clearance_alone_is_left_where_twins_are_drawn() -> None:
    bare, near, said = across(None, 0.375)
    assert len(bare.points) == 2 and 0.005 < near < 0.008 and said == "clearance kept"
    path, far, said = across(ERRORS, 0.375)
    assert said == "clearance and room for the proof's errors kept"
    assert far > 0.005 + WIDEST and path.duration < 1.1 * bare.duration


def test_where_no_path_with_room_is_found_the_planner_with_its_clearance_answers() -> None:
    place, belief, context = asked(TABLE, box("wall", (0.3, 0.02, 0.2), (0.55, 0.0, 0.2)), errors=ERRORS)
    start = stance(place, down(0.5, -0.3, 0.4))
    goals = inverse(UR5E, down(0.5, 0.0, 0.3), seed=start)[:2]
    path, said = planned(place, belief.moved(start), context, goals, seed=1, speed=1.05, acceleration=1.4)
    assert path == plan(place, start, goals, seed=1, samples=context.samples, speed=1.05, acceleration=1.4)
    assert isinstance(path, Refused) and said == "clearance kept"


def test_the_margin_is_that_of_pose_lean_and_size_and_never_less_than_a_cameras() -> None:
    _, belief, _ = asked(TABLE, BLOCK, errors=ERRORS)
    found = doubt_margins(belief, ERRORS)
    assert found["table"] == WIDEST and found["block"] == pytest.approx(0.00325, abs=3e-4)
    assert doubt_margins(belief, ERRORS.scaled(0.5))["block"] == pytest.approx(found["block"] / 2)
    seen = replace(belief, poses={**belief.poses, "block": replace(belief.poses["block"], sigma=0.003)})
    assert doubt_margins(seen, ERRORS)["block"] == pytest.approx(0.006)
