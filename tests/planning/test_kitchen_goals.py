"""Goals about drawers, stacks and many things: which tasks come first, and that no goal holds that does not."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest
from helpers.goal_plans import plans_in

from cramlite import Engine, Goal, Setting, Trace, read_scenario
from cramlite.planning.goal_quantifiers import without_quantifiers
from cramlite.planning.operators import Grounder
from cramlite.plugin import UserError

ENGINE = Engine()
ROOM = """
scenario: room
goal: [drawer open]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: cabinet, model: cabinet, at: {position: [0.75, 0.1, 0.35], yaw: 180 deg}}
  - {name: drawer, model: drawer, at: {position: [0.75, 0.1, 0.35], yaw: 180 deg}, with: {parent: cabinet}}
  - {name: tray, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.3 m, 0.3 m, 20 mm]}}
"""
IN_DRAWER = "  - {name: tin, model: block, at: {position: [0.83, 0.1, 0.335]}, with: {size: [50 mm, 50 mm, 100 mm]}}\n"
ON_TRAY = "  - {name: tin, model: block, at: {position: [0.45, -0.35, 0.191]}, with: {size: [50 mm, 50 mm, 80 mm]}}\n"
STACK = "".join(
    f"  - {{name: {n}, model: block, at: {{position: [0.55, 0.05, {31 + 61 * k} mm]}}}}\n"
    for k, n in enumerate(("lowest", "middle", "top"))
)
PLACE = ["Grasping", "PickingUp", "Placing"]


def _room(folder: Path, more: str) -> Setting:
    path = folder / "room.yaml"
    path.write_text(ROOM + more)
    return ENGINE.setting(read_scenario(path))


def _first(setting: Setting, *says: str) -> list[str]:
    plan = next(plans_in(setting, Goal(says), ENGINE.knowledge, Trace()))
    return [f"{a.task.split(':')[-1]} {' '.join(o.entity or '' for o in a.roles.values())}" for a in plan.actions]


def _tasks(steps: list[str]) -> list[str]:
    return [s.split()[0] for s in steps]


def test_a_closed_drawer_is_opened_before_something_is_put_into_it(tmp_path: Path) -> None:
    steps = _first(_room(tmp_path, ON_TRAY), "tin in drawer")
    assert _tasks(steps) == ["Opening", "Grasping", "PickingUp", "Ungrasping", "Retracting"]


def test_a_drawer_is_opened_with_an_empty_hand(tmp_path: Path) -> None:
    steps = _tasks(_first(_room(tmp_path, ON_TRAY), "drawer open", "tin on floor"))
    assert sorted(steps) == sorted([*PLACE, "Opening"])
    assert steps.index("Opening") in (0, 3)


def test_the_hand_leaves_a_drawer_before_it_is_closed(tmp_path: Path) -> None:
    steps = _tasks(_first(_room(tmp_path, ON_TRAY), "tin in drawer", "drawer closed"))
    assert steps == ["Opening", "Grasping", "PickingUp", "Ungrasping", "Retracting", "Closing"]


def test_the_hand_leaves_a_basket_before_it_takes_the_next_thing(tmp_path: Path) -> None:
    more = "  - {name: basket, model: basket, at: {position: [0.1, -0.55, 5 mm]}}\n"
    steps = _tasks(_first(_room(tmp_path, ON_TRAY + STACK + more), "tin in basket", "top in basket"))
    assert steps == ["Grasping", "PickingUp", "Ungrasping", "Retracting"] * 2


def test_what_lies_in_a_drawer_is_not_off_it(tmp_path: Path) -> None:
    assert _tasks(_first(_room(tmp_path, IN_DRAWER), "tin off drawer")) == ["Opening", "Grasping", "PickingUp"]
    with pytest.raises(UserError, match="holds already"):
        _first(_room(tmp_path, ON_TRAY), "tin off drawer")
    with pytest.raises(UserError, match="holds already"):
        _first(_room(tmp_path, IN_DRAWER), "tin in drawer")


def test_what_is_taken_out_of_a_drawer_that_shall_be_closed(tmp_path: Path) -> None:
    steps = _tasks(_first(_room(tmp_path, IN_DRAWER), "tin on tray", "drawer closed"))
    assert steps == ["Opening", *PLACE, "Closing"]


def test_what_stands_on_a_thing_is_put_aside_first(tmp_path: Path) -> None:
    steps = _first(_room(tmp_path, STACK), "lowest on tray")
    assert _tasks(steps) == PLACE * 3
    assert [s.split()[1] for s in steps if s.startswith("Grasping")] == ["top", "middle", "lowest"]
    assert len(_first(_room(tmp_path, STACK), "top on tray")) == 3  # nothing stands on the highest


def test_what_stands_on_a_part_of_a_thing_stands_on_it(tmp_path: Path) -> None:
    """On its surface, that is: not on what is as high beside it, nor, with its middle outside, within the box around it."""
    plate = "  - {name: plate, model: block, at: {position: [0.5, 0.05, 21 mm]}, with: {size: [0.3 m, 0.3 m, 40 mm]}}\n"
    edge = "  - {name: cup, model: block, at: {position: [0.62, 0.17, 72 mm]}}\n"
    over = "  - {name: cup, model: block, at: {position: [0.66, 0.05, 72 mm]}}\n"
    assert _tasks(_first(_room(tmp_path, plate + edge), "cup off plate")) == ["Grasping", "PickingUp"]
    with pytest.raises(UserError, match="holds already"):  # its centre of mass is beside the plate
        _first(_room(tmp_path, plate + over), "cup off plate")


def test_four_blocks_on_a_tray(tmp_path: Path) -> None:
    blocks = "".join(
        f"  - {{name: b{k}, model: block, at: {{position: [{0.3 + 0.1 * k:.1f}, 0.3, 31 mm]}}}}\n" for k in range(4)
    )
    steps = _first(_room(tmp_path, blocks), *(f"b{k} on tray" for k in range(4)))
    assert _tasks(steps) == PLACE * 4


def test_two_goals_among_forty_blocks(tmp_path: Path) -> None:
    blocks = "".join(
        f"  - {{name: b{k}, model: block, at: {{position: [{-0.4 + 0.1 * (k % 8):.1f}, {0.3 + 0.1 * (k // 8):.1f}, 31 mm]}}}}\n"
        for k in range(40)
    )
    assert _tasks(_first(_room(tmp_path, blocks), "b7 on tray", "b33 on tray")) == PLACE * 2


def test_no_alternative_contains_an_earlier_one(tmp_path: Path) -> None:
    setting = _room(tmp_path, ON_TRAY)
    found = list(islice(plans_in(setting, Goal(("tin on floor",)), ENGINE.knowledge, Trace()), 4))
    assert len({str(p) for p in found}) == len(found) >= 2


def _meanings(setting: Setting, *says: str) -> list[tuple[str, ...]]:
    grounder = Grounder(setting.symbolic(ENGINE.knowledge.taxonomy), ENGINE.knowledge.predicates)
    return list(without_quantifiers(says, grounder))


def test_what_shall_be_in_a_place_may_be_upon_what_shall_be_there_too(tmp_path: Path) -> None:
    setting, both = _room(tmp_path, STACK), ("lowest in drawer", "top in drawer")
    found = _meanings(setting, *both)
    assert found[:2] == [both, ("lowest in drawer", "top on lowest in drawer")]
    assert not any("middle" in goal for goals in found for goal in goals)  # no goal wants that one there
    assert _meanings(setting, "top in drawer") == [("top in drawer",)]
    assert _meanings(setting, "lowest on tray", "top on tray") == [("lowest on tray", "top on tray")]


def test_what_is_in_a_place_can_be_put_upon(tmp_path: Path) -> None:
    found = _meanings(_room(tmp_path, IN_DRAWER + STACK), "top in drawer")
    assert found == [("top in drawer",), ("tin in drawer", "top on tin in drawer")]


def test_choices_of_things_take_turns(tmp_path: Path) -> None:
    """The second choice is not left until the first one has no further plan."""
    goal = Goal(("lowest on tray or top on floor",))
    plans = islice(plans_in(_room(tmp_path, ON_TRAY + STACK), goal, ENGINE.knowledge, Trace()), 3)
    assert [p.goal for p in plans] == [("lowest on tray",), ("lowest on tray",), ("top on floor",)]


def test_things_that_no_rule_joins_have_no_plan(tmp_path: Path) -> None:
    trace = Trace()
    assert not list(plans_in(_room(tmp_path, ON_TRAY), Goal(("tray on tin",)), ENGINE.knowledge, trace))
    assert "no task's rule makes" in trace.entries[-1].reason


@pytest.mark.heavy
def test_goals_about_classes_of_things(tmp_path: Path) -> None:
    setting = _room(tmp_path, ON_TRAY + STACK)
    each = [s for s in _first(setting, "each Product on floor") if s.startswith("Placing")]
    assert {s.split()[1] for s in each} == {"tin", "middle", "top"}  # the lowest is there
    pairs = [s for s in _first(setting, "2 of cram:Product on tray") if s.startswith("Placing")]
    assert [s for s in pairs if s.endswith("tray")] == ["Placing lowest tray"]  # of the first two in the world, the tin is there
    goals = [p.goal for p in plans_in(setting, Goal(("any Product held",)), ENGINE.knowledge, Trace())]
    assert goals[0] == ("tin held",) and {g[0] for g in goals} == {f"{n} held" for n in ("tin", "lowest", "middle", "top")}


@pytest.mark.heavy
def test_some_things_of_a_class_but_not_a_certain_one(tmp_path: Path) -> None:
    """The goal of a scenario is about more things than it has words: a meaning that contradicts itself is passed over."""
    path = tmp_path / "room.yaml"
    path.write_text(ROOM.replace("[drawer open]", "[2 of Product on tray, not lowest on tray]") + ON_TRAY + STACK)
    scenario = read_scenario(path)
    (goal, *_) = (p.goal for p, _ in ENGINE.plans(scenario, ENGINE.setting(scenario), Trace()))
    assert goal == ("tin on tray", "middle on tray", "not lowest on tray")


@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("each Produkt on floor", "names the class 'Produkt'; did you mean 'Product'"),
        ("9 of Product on tray", "9 or more of Product; in this world there are: tin"),
        ("any vrps:Hook held", "there are: none"),
    ],
)
def test_classes_of_which_too_few_are_there(goal: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=says):
        _first(_room(tmp_path, ON_TRAY), goal)
