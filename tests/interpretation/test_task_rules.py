"""The rules of the task types: an action that is the task, and a sibling that it is not."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.interpretation_reading import BOX, RULES, TABLE, TAXONOMY, at, read, tasks
from helpers.interpretation_samples import SHOP, action, episode, state, track

from cramlite import Engine, data_folder
from cramlite.interpretation.interpretation import interpret
from cramlite.model import Entity, Episode, Event, Pose


def held(events: list[Event], *things: Entity, z: float = 0.1) -> Episode:
    hand = track((0, 0.5, 0, 0.2), (4, 0.5, 0, 0.2 + z))
    return episode(
        things,
        [state("grasp", "hand", "box", 0, 4), *events],
        {"hand": hand, "box": track((0, 0.5, 0, 0.1), (4, 0.5, 0, 0.1 + z))},
    )


def test_picking_up_from_a_table_but_not_off_a_peg() -> None:
    lifted = held([state("support", "table", "box", 0, 2), action("soma:PhysicalAction", 1, 3)], BOX, TABLE)
    (match,) = at(read(lifted), 1.5).named("soma:PickingUp")
    assert match.roles == {"Locatum": "box", "Relatum": "table"}
    peg = held([state("support", "hanger/peg", "box", 0, 2), action("soma:PhysicalAction", 1, 3)], BOX, *SHOP[:2])
    assert "soma:PickingUp" not in tasks(at(read(peg), 1.5))


def test_putting_down_needs_a_surface() -> None:
    down = held([state("contact", "table", "box", 2, 4)], BOX, TABLE)
    assert "soma:PuttingDown" in tasks(at(read(down), 1.5))
    plain = Entity("ball", ("dul:PhysicalObject",))
    assert "soma:PuttingDown" not in tasks(at(read(held([state("contact", "ball", "box", 2, 4)], BOX, plain)), 1.5))


def test_releasing_and_ungrasping_tell_resting_from_falling() -> None:
    events = [
        state("grasp", "hand", "product", 0, 2),
        state("contact", "product", "basket", 1, 4),
        state("support", "basket", "product", 1, 4),
    ]
    tracks = {
        "hand": track((0, 0.4, 0.5, 0.9), (4, 0.4, 0.5, 0.9)),
        "product": track((0, 0.4, 0.5, 0.5), (4, 0.4, 0.5, 0.5)),
    }
    resting = tasks(at(read(episode(SHOP, events, tracks)), 1.5))
    assert "soma:Releasing" in resting
    assert "artm:Ungrasping" not in resting
    falling = tasks(at(read(episode(SHOP, events[:1], tracks)), 1.5))
    assert "artm:Ungrasping" in falling
    assert "soma:Releasing" not in falling
    beside = {**tracks, "product": track((0, 0.0, 0.5, 0.5), (4, 0.0, 0.5, 0.5))}
    assert "artm:Ungrasping" not in tasks(at(read(episode(SHOP, events[:1], beside)), 1.5))


def test_inserting_needs_a_free_object_and_a_peg() -> None:
    grasp = [state("grasp", "hand", "product", 0, 4), state("contact", "hand", "product", 0, 4)]
    hung = [*grasp, state("contact", "product", "hanger/peg", 2, 4)]
    (match,) = at(read(episode(SHOP, hung)), 1.0).named("artm:InsertHoleOntoPeg")
    assert match.roles == {"Locatum": "product", "Relatum": "hanger/peg"}
    scraped = [*hung, state("contact", "product", "basket", 0, 4)]
    assert not at(read(episode(SHOP, scraped)), 1.0).named("artm:InsertHoleOntoPeg")
    elsewhere = [*grasp, state("contact", "product", "hanger", 2, 4)]
    assert not at(read(episode(SHOP, elsewhere)), 1.0).named("artm:InsertHoleOntoPeg")


def test_sliding_an_object_needs_support_all_the_way() -> None:
    events = [
        state("support", "table", "box", 0, 4),
        state("contact", "table", "box", 0, 4),
        action("soma:PhysicalAction", 1, 3),
    ]
    assert "artm:SlidingObject" in tasks(at(read(held(events, BOX, TABLE)), 2))
    events[0] = state("support", "table", "box", 0, 2)
    assert "artm:SlidingObject" not in tasks(at(read(held(events, BOX, TABLE)), 2))


def test_holding_and_transporting() -> None:
    still = held([action("soma:PhysicalAction", 1, 3)], BOX, TABLE, z=0.0)
    moving = held([action("soma:PhysicalAction", 1, 3)], BOX, TABLE, z=0.05)
    assert "soma:Holding" in tasks(at(read(still), 2))
    assert "soma:Holding" not in tasks(at(read(moving), 2))
    assert "soma:Transporting" in tasks(at(read(moving), 2))
    assert "soma:Transporting" not in tasks(at(read(still), 2))


def test_reaching_needs_to_come_nearer_or_a_label() -> None:
    near, far = track((0, 0, 0, 0), (2, 0.4, 0, 0)), track((0, 0.4, 0, 0), (2, 0, 0, 0))
    box = {"box": track((0, 0.5, 0, 0), (2, 0.5, 0, 0))}
    label = [action("soma:Reaching", 0, 2, object="box")]
    anonymous = [action("soma:PhysicalAction", 0, 2)]
    assert read(episode([BOX], anonymous, {"hand": near, **box})).actions[0].named("soma:Reaching")[0].roles == {
        "Goal": "box"
    }
    assert not read(episode([BOX], anonymous, {"hand": far, **box})).actions[0].named("soma:Reaching")
    still = track((0, 0.4, 0, 0), (2, 0.4, 0, 0))
    assert read(episode([BOX], label, {"hand": still, **box})).actions[0].named("soma:Reaching")
    assert not read(episode([BOX], anonymous, {"hand": still, **box})).actions[0].named("soma:Reaching")


@pytest.mark.parametrize(
    ("first", "last", "task"), [(0.0, 0.1, "artm:OpenGripperTask"), (0.1, 0.0, "artm:CloseGripperTask")]
)
def test_the_gripper_opens_or_closes(first: float, last: float, task: str) -> None:
    opening = np.array([(0, first), (0.5, first), (1.5, last), (2, last)])
    sample = episode([], [action("soma:PhysicalAction", 0, 1.9)], {"hand": track((0, 0, 0, 0), (2, 0, 0, 0))}, opening)
    found = tasks(read(sample).actions[0])
    assert found == {task}


@pytest.mark.parametrize(
    ("first", "last", "held", "opens"),
    [
        (0.05, 0.1, False, True),  # it has let go of a thing, and opens on
        (0.05, 0.1, True, False),  # it lets go of a thing by this
        (0.05, 0.07, False, False),  # it does not end open
        (0.078, 0.1, False, False),  # it was open
        (0.01, 0.1, True, True),  # closed, whatever it holds
    ],
)
def test_an_empty_hand_opens_on(first: float, last: float, held: bool, opens: bool) -> None:
    opening = np.array([(0, first), (0.5, first), (1.5, last), (2, last)])
    states = [state("grasp", "hand", "box", 0, 1.5)] if held else []
    events = [action("soma:PhysicalAction", 0, 1.9), *states]
    sample = episode([BOX], events, {"hand": track((0, 0, 0, 0), (2, 0, 0, 0))}, opening)
    assert ("artm:OpenGripperTask" in tasks(read(sample).actions[0])) is opens


@pytest.mark.parametrize("name", ["fetch_from_hanger", "hang_onto_hanger"])
def test_the_shipped_demonstrations_have_no_hole(name: str) -> None:
    assert not read(Engine().read_episode(data_folder("scenarios") / name / "demonstration")).unexplained_actions


def test_what_opens_on_is_a_hole_without_the_rule() -> None:
    demonstration = Engine().read_episode(data_folder("scenarios") / "fetch_from_hanger" / "demonstration")
    others = [r for r in RULES if r.task != "artm:OpenGripperTask"]
    (hole,) = interpret(demonstration, others, TAXONOMY).unexplained_actions
    assert at(read(demonstration), hole.start).named("artm:OpenGripperTask")


@pytest.mark.parametrize(("first", "last", "task"), [(0.0, 0.3, "soma:Opening"), (0.3, 0.0, "soma:Closing")])
def test_a_drawer_opens_or_closes(first: float, last: float, task: str) -> None:
    drawer = Entity("drawer", ("soma:Drawer",), properties={"joint_lower": 0.0, "joint_upper": 0.4})
    times = np.arange(0, 2.0, 0.02)
    sample = episode(
        [drawer],
        [action("soma:PhysicalAction", 0, 1.9)],
        {},
        None,
        times=times,
        **{"joint:drawer": np.interp(times, [0, 0.5, 1.5, 2], [first, first, last, last])},
    )
    assert tasks(read(sample).actions[0]) & {"soma:Opening", "soma:Closing"} == {task}


@pytest.mark.parametrize(("first", "last", "task"), [(0.0, -0.8, "soma:Opening"), (0.8, 0.0, "soma:Closing")])
def test_a_lever_that_a_spring_keeps_level_opens_either_way(first: float, last: float, task: str) -> None:
    properties = {"joint_lower": -1.0, "joint_upper": 1.0, "joint_closed": 0.0}
    times, lever = np.arange(0, 2.0, 0.02), Entity("lever", ("cram:Latch",), properties=properties)
    turned = {"joint:lever": np.interp(times, [0, 0.5, 1.5, 2], [first, first, last, last])}
    sample = episode([lever], [action("soma:PhysicalAction", 0, 1.9)], {}, None, times=times, **turned)
    assert tasks(read(sample).actions[0]) & {"soma:Opening", "soma:Closing"} == {task}


def test_pouring_needs_a_tilt_over_the_other_container() -> None:
    cup, bowl, rice = (
        Entity("cup", ("soma:Cup",), size=(0.08, 0.08, 0.1)),
        Entity("bowl", ("soma:Bowl",), pose=Pose((0.5, 0, 0)), size=(0.2, 0.2, 0.1)),
        Entity("rice", ("cram:Granulate",)),
    )
    events = [
        state("grasp", "hand", "cup", 0, 4),
        state("contain", "cup", "rice", 0, 2),
        state("contain", "bowl", "rice", 1.9, 4),
        action("soma:PhysicalAction", 0.5, 3),
    ]
    above = track((0, 0.5, 0, 0.3), (4, 0.5, 0, 0.3))
    tilted = above.poses.copy()
    half = np.deg2rad(np.interp(above.times, [1, 2], [0, 90])) / 2
    tilted[:, 3], tilted[:, 4] = np.cos(half), np.sin(half)
    from cramlite.model import Track

    (match,) = at(read(episode([cup, bowl, rice], events, {"cup": Track(above.times, tilted)})), 1).named(
        "soma:Pouring"
    )
    assert match.roles == {"Source": "cup", "Destination": "bowl"}
    assert not at(read(episode([cup, bowl, rice], events, {"cup": above})), 1).named("soma:Pouring")


def test_parking_navigating_and_looking() -> None:
    times = np.arange(0, 2.0, 0.02)
    joints = np.linspace([0.5, 0.5], [1.0, -1.0], len(times))
    extras = {"times": times, "joints": joints, "park": np.array([1.0, -1.0])}
    move = [action("soma:PhysicalAction", 0, 2)]
    hand = {"hand": track((0, 0, 0, 0), (2, 1, 0, 0))}
    assert "soma:ParkingArms" in tasks(read(episode([], move, hand, None, **extras)).actions[0])
    away = {**extras, "park": np.array([0.0, 0.0])}
    assert "soma:ParkingArms" not in tasks(read(episode([], move, hand, None, **away)).actions[0])
    base = Entity("base", ("cram:MobileBase",))
    drive = episode([base, TABLE], move, {"base": track((0, -3, 0, 0), (2, 0, 0, 0))})
    assert read(drive).actions[0].named("soma:Navigating")[0].roles == {"Destination": "table"}
    stays = episode([base, TABLE], move, {"base": track((0, 0, 0, 0), (2, 0, 0, 0))})
    assert not read(stays).actions[0].named("soma:Navigating")
    camera = Entity("camera", ("cram:Camera",))
    look = episode([camera, TABLE], move, {"camera": track((0, 0.5, 0, 1), (2, 0.5, 0, -1))})
    assert read(look).actions[0].named("soma:LookingAt")[0].roles == {"Patient": "table"}
    lost = episode([BOX], move, {"box": track((1, 0, 0, 0), (2, 0, 0, 0))})
    assert read(lost).actions[0].named("soma:LookingFor")[0].roles == {"Patient": "box"}
    known = episode([BOX], move, {"box": track((0, 0, 0, 0), (2, 0, 0, 0))})
    assert not read(known).actions[0].named("soma:LookingFor")


@pytest.mark.parametrize("held", [True, False])
def test_shaking_is_what_the_log_says_of_a_held_thing(held: bool) -> None:
    events = [action("cram:Shaking", 1.0, 2.0, object="product")]
    events += [state("grasp", "hand", "product", 0.5, 3.0)] if held else [state("contact", "hand", "product", 0.5, 3.0)]
    found = interpret(episode(SHOP, events), RULES, TAXONOMY)
    (shaken,) = [a for a in found.actions if a.label == "cram:Shaking"]
    assert bool(shaken.named("cram:Shaking")) == held
