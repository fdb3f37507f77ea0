"""Paths around a wall, refusals with reasons, repeatability."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from helpers import coal_check
from helpers.scenes import BLOCK, TABLE, WALL, box, down, make, stance
from msgspec.structs import replace

from cramlite.model import Geom, Pose
from cramlite.plugin import Refused
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planner import Path, plan, resampled
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.robots.ur5e import UR5E

SHELF = (
    TABLE,
    box("back", (0.3, 0.01, 0.3), (0.5, 0.65, 0.27)),
    box("board", (0.3, 0.15, 0.01), (0.5, 0.5, 0.45)),
    box("left", (0.01, 0.15, 0.23), (0.2, 0.5, 0.22)),
    box("right", (0.01, 0.15, 0.23), (0.8, 0.5, 0.22)),
)
INTO = Pose.from_axes((0.5, 0.5, 0.2), (0, 1, 0), (1, 0, 0))


def wall_query(seed: int, samples: int = 4000) -> tuple[PlanningScene, tuple[float, ...], Path | Refused]:
    """From one side of the wall to the other, on the near branches only: the straight line is blocked."""
    place = make(TABLE, WALL)
    start = stance(place, down(0.5, -0.25, 0.2))
    goals = [q for q in inverse(UR5E, down(0.5, 0.25, 0.2), seed=start) if abs(q[0] - start[0]) < 2][:4]
    return place, start, plan(place, start, goals, seed=seed, samples=samples)


def test_into_a_shelf_and_free_for_coal() -> None:
    place = make(*SHELF)
    start = stance(place, down(0.4, -0.3, 0.2))
    path = plan(place, start, inverse(UR5E, INTO, seed=start), seed=5)
    assert isinstance(path, Path), path
    assert path.points[0] == start
    assert max(forward(UR5E, path.points[-1]).distance(INTO)) < 1e-5
    check_with_coal(place, path)


def check_with_coal(place: PlanningScene, path: Path) -> None:
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    for q in resampled(path.points, 0.02):
        assert min(coal_check.distances(place, q, solids, checked).values()) > 0.001


def test_around_a_wall() -> None:
    place, start, path = wall_query(1)
    assert isinstance(path, Path), path
    assert path.samples > 0
    assert path.duration <= path.first
    assert path.points[0] == start
    check_with_coal(place, path)


def test_a_straight_line_is_tried_first() -> None:
    start = stance(make(TABLE), down(0.5, -0.25, 0.2))
    path = plan(make(TABLE), start, inverse(UR5E, down(0.5, 0.1, 0.2), seed=start), seed=1)
    assert isinstance(path, Path)
    assert path.samples == 0
    assert len(path.points) == 2


def test_around_a_wall_is_nearer_than_straight_on_with_the_arm_turned_over() -> None:
    place, start, near = wall_query(1)
    goals = inverse(UR5E, down(0.5, 0.25, 0.2), seed=start)
    assert any(place.line_free(start, q) for q in goals)
    path = plan(place, start, goals, seed=1)
    assert isinstance(path, Path) and isinstance(near, Path)
    assert path.samples > 0 and path.duration < 1.2 * near.duration


def in_a_sleeve(*sides: int) -> Path | Refused:
    """A rod in the hand, its lower end between walls that are 0.2 mm farther away than they must be; to be turned in the air."""
    gap, rod = 0.02 + 0.0052 + 0.01, box("rod", (0.02, 0.02, 0.08), (0.5, -0.25, 0.09), 0.2)
    at = ((gap, 0.0), (-gap, 0.0), (0.0, gap), (0.0, -gap))
    walls = (box(f"wall{k}", (0.01, 0.05, 0.03) if k < 2 else (0.05, 0.01, 0.03), (0.5 + at[k][0], -0.25 + at[k][1], 0.035)) for k in sides)
    place = make(box("floor", (0.6, 0.6, 0.02), (0.5, 0.0, -0.04)), rod, *walls, held={"rod": Pose((0.0, 0.0, 0.06))}, opening=0.04)
    start = stance(place, down(0.5, -0.25, 0.15))
    goals = inverse(UR5E, Pose.from_axes((0.5, 0.25, 0.5), (0, 0, -1), (0, 1, 0)), seed=start)[:4]
    return plan(place, start, goals, seed=1)


def test_a_start_that_nothing_leads_away_from_is_refused_before_any_search() -> None:
    answer = in_a_sleeve(0, 1, 2, 3)
    assert isinstance(answer, Refused) and not answer.numbers.get("samples"), answer
    assert "none of 500 short ways away from the start is free" in answer.reason and "'wall" in answer.reason
    assert isinstance(in_a_sleeve(0, 2), Path)  # in a corner


def test_a_goal_inside_the_wall_is_refused_and_the_wall_is_named() -> None:
    place = make(TABLE, WALL)
    start = stance(place, down(0.5, -0.25, 0.2))
    answer = plan(place, start, inverse(UR5E, down(0.55, 0.0, 0.2)), seed=1)
    assert isinstance(answer, Refused)
    assert "goal positions are blocked" in answer.reason
    assert "inside 'wall'" in answer.reason


def test_a_start_in_collision_is_refused_and_the_wall_is_named() -> None:
    inside = inverse(UR5E, down(0.55, 0.0, 0.2))[0]
    answer = plan(make(TABLE, WALL), inside, [UR5E.home], seed=1)
    assert isinstance(answer, Refused)
    assert answer.reason.startswith("start is blocked")
    assert "'wall'" in answer.reason


def test_no_goals_are_refused() -> None:
    assert isinstance(plan(make(TABLE), UR5E.home, [], seed=1), Refused)


def test_a_held_thing_makes_a_path_impossible() -> None:
    """Through a window that the empty hand fits through."""
    window = (
        box("sill", (0.5, 0.02, 0.12), (0.5, 0.3, 0.1)),
        box("lintel", (0.5, 0.02, 0.3), (0.5, 0.3, 0.75)),
        box("post", (0.15, 0.02, 0.2), (0.2, 0.3, 0.4)),
        box("jamb", (0.15, 0.02, 0.2), (0.8, 0.3, 0.4)),
    )
    through = Pose.from_axes((0.5, 0.42, 0.34), (0, 1, 0), (1, 0, 0))
    before = Pose.from_axes((0.5, 0.1, 0.34), (0, 1, 0), (1, 0, 0))
    free = make(*window)
    start = stance(free, before)
    goals = inverse(UR5E, through, seed=start)
    assert isinstance(plan(free, start, goals, seed=2), Path)
    bar = replace(BLOCK, geoms=(Geom("box", (0.3, 0.02, 0.3)),))
    held = make(*window, bar, held={"block": Pose((0, 0, 0.0))})
    answer = plan(held, start, goals, seed=2, samples=300)
    assert isinstance(answer, Refused), answer
    assert "'block'" in answer.reason or "samples" in answer.reason


def test_the_budget_is_counted() -> None:
    answer = wall_query(5, samples=3)[2]
    assert isinstance(answer, Refused)
    assert answer.numbers["samples"] <= 6
    assert "no path in" in answer.reason
    assert "'wall'" in answer.reason
    assert not answer.numbers["truncated"]


def test_the_same_seed_gives_the_same_path_twice() -> None:
    assert wall_query(7)[2] == wall_query(7)[2]


def test_another_seed_gives_another_path() -> None:
    assert wall_query(7)[2] != wall_query(8)[2]


@pytest.mark.heavy
def test_the_same_seed_gives_the_same_path_in_another_process_and_nothing_leaks() -> None:
    code = f"import sys; sys.path[:0] = {sys.path!r}\nfrom test_planner import wall_query\nprint(wall_query(7)[2])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == str(wall_query(7)[2])
    assert run.stderr == ""


def test_resampled_keeps_the_step() -> None:
    rows = resampled([(0.0, 0.0), (0.1, 0.02)], 0.005)
    assert np.abs(np.diff(rows, axis=0)).max() == pytest.approx(0.005)
    assert len(rows) == 21
