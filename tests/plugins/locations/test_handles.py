"""How far a drawer is opened: as far as it is asked for, else as far as it goes and the arm comes; and from where a handle is taken."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cramlite import Budget, Engine, find_scenario, read_scenario
from cramlite.model import Held, Location, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.objects.controls import knob
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.ur5e import UR5E

ENGINE = Engine()
POST = "  - {name: post, model: table, at: {position: [0.55, 0.22, 0.45]}, with: {size: [20 mm, 20 mm, 0.4 m]}}\n"
"""It stands where the front comes to when the drawer is open by 182 mm of its 200 mm."""


def _opened(folder: Path, task: str, more: str) -> float | None:
    """How far the drawer is open in the end [m]; None where no program opens it so."""
    text = find_scenario("tasks/opening").read_text()
    head, _, things = text.partition("things:\n")
    path = folder / "opening.yaml"
    path.write_text(head.replace("Patient: drawer", f"Patient: drawer{task}") + "things:\n" + more + things.partition("#")[0])
    scenario = read_scenario(path)
    setting = ENGINE.setting(scenario, twins=0)
    found = next(ENGINE.resolve(scenario, setting=setting, budget=Budget(expansions=400)), None)
    if found is None:
        return None
    closed, there = (b.poses["drawer"].pose for b in (setting.belief(), found.candidate.belief))
    return closed.distance(there)[0]


@pytest.mark.parametrize(
    ("task", "more", "metres"),
    [("", "", 0.19), ("", POST, 0.17), (", parameters: {share: 0.5}", "", 0.10), (", parameters: {share: 0.95}", POST, None)],
)
def test_it_is_opened_as_far_as_it_goes_unless_asked_otherwise(task: str, more: str, metres: float | None, tmp_path: Path) -> None:
    assert _opened(tmp_path, task, more) == (metres if metres is None else pytest.approx(metres, abs=0.005))


def _grips(*beside: Thing) -> dict[str, Place]:
    """The grips of a knob whose axis points up, by name."""
    mount = RobotMount("arm", "ur5e")
    plate = table("plate", Pose((0.5, 0.0, 0.2)), (0.2, 0.2, 0.02))
    taken = knob("knob", Pose.from_rotvec((0.5, 0.0, 0.211), (0.0, -math.pi / 2, 0.0)), parent="plate")
    belief = initial_belief(World((plate, taken, *beside), (mount,)), "arm", UR5E.home, 0.085)
    context = Context(UR5E, mount, {"knob": "knob"}, Engine().knowledge.taxonomy)
    answers = ground(Location("handle(knob)", "handle", "knob"), belief, context)
    return {str(a.key): a.value for a in answers or () if isinstance(a, Grounding)}


def test_a_handle_is_also_taken_by_a_hand_that_leans_along_its_bar() -> None:
    """Its fingers still close across the bar; a straight hand comes first."""
    grips = _grips()
    straight, leaning = grips["across the handle, turned 0 deg"], grips["across the handle, turned 0 deg, leaning +15 deg, by the tips"]
    ahead, closing = ([g.pose.rotate(axis) for g in (straight, leaning)] for axis in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    assert math.degrees(math.acos(float(np.dot(*ahead)))) == pytest.approx(15.0)
    assert float(np.dot(*closing)) == pytest.approx(1.0)
    assert "leaning" not in next(iter(grips))


@pytest.mark.parametrize(("task", "goal"), [("turned", 0.0), ("", 0.005)])
def test_a_knob_is_turned_off_to_its_stop(task: str, goal: float) -> None:
    """Who asks for off exactly may mean the last hundredth of its range; a drawer or a door is closed but for what friction leaves."""
    mount = RobotMount("arm", "ur5e")
    taken = knob("knob", Pose((0.5, 0.0, 0.211)), parent="plate", turned=math.radians(80))
    plate = table("plate", Pose((0.5, 0.0, 0.2)), (0.2, 0.2, 0.02))
    assert taken.joint is not None
    span = taken.joint.upper - taken.joint.lower
    belief = initial_belief(World((plate, taken), (mount,)), "arm", UR5E.home, 0.085)
    belief = belief.grasped(Held("knob", Pose(), 0.0))
    context = Context(UR5E, mount, {"knob": "knob"}, Engine().knowledge.taxonomy)
    location = Location("turned(knob)", "closed", "knob", {task: True} if task else {})
    [found] = [a for a in ground(location, belief, context) if isinstance(a, Grounding)]
    assert found.value.carried.joint == pytest.approx(taken.joint.lower + goal * span - taken.joint.value, abs=1e-4)
