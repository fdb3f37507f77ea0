"""Interpretation: which tasks actions are, which they are not and why, sequences, and merging."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interpretation_samples import SHOP, action, episode, hanger_episode, state, track

from cramlite.engine import Engine
from cramlite.episode import Entity, Episode, Event
from cramlite.errors import UserError
from cramlite.geometry import Pose
from cramlite.interpretation import Interpretation, Interpreted, Match, interpret
from cramlite.ontology import load_taxonomy
from cramlite.ranking import affinity, specificity
from cramlite.resources import data_folder
from cramlite.rules import load_rules
from cramlite_plugins.experts.predicates import all_predicates

TAXONOMY = load_taxonomy([data_folder("ontologies")])
RULES = load_rules([data_folder("task_rules")], all_predicates(), TAXONOMY)

CONTAINER = Entity("jar", ("soma:Jar",), pose=Pose((0.5, 0, 0)), size=(0.1, 0.1, 0.1))
LID = Entity("lid", ("soma:Lid",), size=(0.1, 0.1, 0.01))
BOX = Entity("box", ("cram:BoxedProduct",), size=(0.05, 0.05, 0.1))
TABLE = Entity("table", ("soma:Table",), pose=Pose((0.5, 0, 0)), size=(1, 1, 0.02))


def read(sample: Episode, merge: bool = True) -> Interpretation:
    return interpret(sample, RULES, TAXONOMY, merge=merge)


def tasks(one: Interpreted) -> set[str]:
    return {m.task for m in one.matches}


def at(found: Interpretation, time: float) -> Interpreted:
    """The action that is going on."""
    return next(a for a in found.actions if a.start <= time < a.end)


def test_a_product_is_taken_off_a_hanger_and_dropped_into_a_basket() -> None:
    found = read(hanger_episode())
    best = next(found.sequences())
    assert [m.task for m in best.matches] == [
        "soma:Reaching",
        "soma:Grasping",
        "artm:ExtractHoleFromPeg",
        "artm:Ungrasping",
        "soma:Retracting",
        "soma:AssumingArmPose",
    ]
    assert best.matches[2].roles == {"Locatum": "product", "Relatum": "hanger/peg"}
    assert best.matches[3].roles == {"Locatum": "product", "Relatum": "basket"}
    assert "soma:AssumingArmPose" in tasks(at(found, 5.0))


def test_without_friction_there_is_no_grasp_and_nothing_that_needs_one() -> None:
    needs = {
        "soma:Grasping",
        "soma:Holding",
        "soma:Releasing",
        "artm:Ungrasping",
        "soma:PickingUp",
        "soma:PuttingDown",
        "soma:Placing",
        "artm:ExtractHoleFromPeg",
        "artm:InsertHoleOntoPeg",
        "artm:SlidingObject",
        "soma:Transporting",
    }
    for one in read(hanger_episode(friction=False)).actions:
        assert not tasks(one) & needs


def test_every_task_is_matched_or_rejected_with_the_reason() -> None:
    found = read(hanger_episode())
    for one in found.actions:
        assert tasks(one) | {r.task for r in one.rejections} == {r.task for r in RULES}
        assert not tasks(one) & {r.task for r in one.rejections}
        for refused in one.rejections:
            assert refused.condition in refused.sentence
            assert refused.where.rsplit(":", 1)[1].isdigit()


def test_why_and_why_not_name_bindings_and_facts() -> None:
    found = read(hanger_episode())
    k = found.actions.index(at(found, 3.0))
    text = found.why("PickUp", k)
    assert "constrained_dof(hanger, product) = 4" in text
    assert "picking_up.yaml:" in text
    assert "pulled off hanger/peg" in found.why("artm:ExtractHoleFromPeg", k)
    with pytest.raises(UserError, match="No rule speaks"):
        found.why("Juggling", k)
    with pytest.raises(UserError, match="There is no action 99"):
        found.why("Grasping", 99)


def test_json_form() -> None:
    found = read(hanger_episode())
    data = json.loads(json.dumps(found.to_json()))
    assert data["sequences"] == found.count() == math.prod(len(a["tasks"]) or 1 for a in data["actions"])
    assert {"start", "end", "tasks", "rejections"} <= set(data["actions"][0])
    assert {"task", "roles"} <= set(data["actions"][0]["tasks"][0])


# Ambiguity, as in the paper


def moved_lid(closes: bool) -> Episode:
    """A lid is carried onto a jar (or onto a table) and let go: one action, labelled by the log."""
    target = "jar" if closes else "table"
    events = [
        state("grasp", "hand", "lid", 0, 2.0),
        state("contact", "hand", "lid", 0, 2.0),
        state("contact", target, "lid", 1.9, 4),
        state("support", target, "lid", 1.9, 4),
        action("soma:PhysicalAction", 0.5, 2.05),
    ]
    hand = track((0, 0, 0, 0.3), (2, 0.5, 0, 0.12), (4, 0, 0, 0.3))
    return episode(
        [CONTAINER, LID, TABLE],
        events,
        {"hand": hand, "lid": track((0, 0, 0, 0.2), (2, 0.5, 0, 0.06), (4, 0.5, 0, 0.06))},
    )


def test_a_lid_moved_onto_a_container_is_closing_and_placing() -> None:
    assert {"soma:Closing", "soma:Placing"} <= tasks(at(read(moved_lid(True)), 1.0))
    beside = tasks(at(read(moved_lid(False)), 1.0))
    assert "soma:Placing" in beside
    assert "soma:Closing" not in beside


def touched(then_grasped: bool, then_moved: bool) -> Episode:
    events = [state("contact", "hand", "box", 1, 2), state("support", "table", "box", 0, 4)]
    if then_grasped:
        events += [state("grasp", "hand", "box", 2, 4), state("contact", "hand", "box", 2, 4)]
    way = 0.1 if then_moved else 0.0
    hand = track((0, 0, 0, 0), (1, 0.4, 0, 0), (2, 0.4 + way, 0, 0), (4, 0.4 + way, 0, 0.01))
    return episode(
        [BOX, TABLE],
        events,
        {"hand": hand, "box": track((0, 0.45, 0, 0), (1, 0.45, 0, 0), (2, 0.45 + way, 0, 0), (4, 0.45 + way, 0, 0))},
    )


def test_a_touch_is_grasping_or_pushing_by_what_happens_afterwards() -> None:
    assert "soma:Grasping" in tasks(at(read(touched(True, False)), 1.5))
    assert "soma:Pushing" not in tasks(at(read(touched(True, False)), 1.5))
    assert "soma:Pushing" in tasks(at(read(touched(False, True)), 1.5))
    assert "soma:Grasping" not in tasks(at(read(touched(False, True)), 1.5))
    assert not tasks(at(read(touched(False, False)), 1.5)) & {"soma:Grasping", "soma:Pushing"}


# Defects of the published rules


def slide(retract: float = 0.065) -> Episode:
    """A labelled sliding of the gripper, directly followed by a short labelled retracting."""
    end = 2 + retract
    hand = track((0, 0, 0, 0.1), (1, 0, 0, 0.02), (2, 0.2, 0, 0.02), (end, 0.2, 0, 0.05), (4, 0.2, 0, 0.3))
    return episode(
        [TABLE],
        [
            state("contact", "hand", "table", 1, end),
            action("artm:SlidingGripper", 1, 2),
            action("soma:Retracting", 2, end),
        ],
        {"hand": hand},
    )


def test_sliding_of_the_gripper_fires() -> None:
    (match,) = at(read(slide()), 1.5).named("artm:SlidingGripper")
    assert match.roles == {"Locatum": "hand", "Relatum": "table"}


@pytest.mark.parametrize("duration", [0.065, 0.5])
def test_padding_suits_a_short_retracting_after_a_sliding(duration: float) -> None:
    found = read(slide(duration))
    assert "artm:SlidingGripper" in tasks(at(found, 1.5))
    assert "soma:Retracting" in tasks(at(found, 2.01))


def test_padding_sees_effects_that_come_a_little_late_but_no_later() -> None:
    def labelled(delay: float) -> Episode:
        return episode([BOX], [action("soma:Grasping", 1, 2), state("grasp", "hand", "box", 2 + delay, 4)], {})

    assert "soma:Grasping" in tasks(at(read(labelled(0.15)), 1.5))
    assert "soma:Grasping" not in tasks(at(read(labelled(0.25)), 1.5))
    assert "soma:Grasping" in tasks(at(interpret(labelled(0.25), RULES, TAXONOMY, padding=0.3), 1.5))


def test_retracting_has_both_roles_and_needs_to_come_free() -> None:
    (match,) = at(read(slide()), 2.01).named("soma:Retracting")
    assert match.roles == {"Relatum": "table", "Locatum": "hand"}
    stuck = episode([TABLE], [state("contact", "hand", "table", 0, 4), action("soma:Retracting", 1, 2)], {})
    assert "soma:Retracting" not in tasks(at(read(stuck), 1.5))


def test_a_short_collision_inside_an_action_counts() -> None:
    def motion(hit: bool) -> Episode:
        events = [action("soma:AssumingArmPose", 0, 3), *([state("contact", "hand", "box", 1.0, 1.1)] if hit else [])]
        return episode([BOX], events, {"hand": track((0, 0, 0, 0), (3, 1, 0, 0))})

    free, hit = at(read(motion(False)), 1.0), at(read(motion(True)), 1.0)
    assert tasks(free) & {"soma:AssumingArmPose", "artm:AssumingArmPoseConstrained"} == {"soma:AssumingArmPose"}
    assert tasks(hit) & {"soma:AssumingArmPose", "artm:AssumingArmPoseConstrained"} == {
        "artm:AssumingArmPoseConstrained"
    }


def sliding(which: str, where: str, start: float) -> list[Event]:
    """A thing is held on a support from a second before to a second after a labelled slide of two seconds."""
    first, last = start - 1, start + 3
    states = [state("grasp", "hand", which, first, last)]
    states += [state(kind, where, which, first, last) for kind in ("contact", "support")]
    return [*states, action("artm:Sliding", start, start + 2)]


@pytest.mark.parametrize("moving", [(True, True), (True, False), (False, True)])
def test_an_action_is_judged_by_its_own_motion_and_things(moving: tuple[bool, bool]) -> None:
    """The published rules read the poses of an arbitrary action. Here two things are slid in turn, on two supports;
    where one of the slides stands still, that one is none, whatever the other is."""
    shelf, cup = Entity("shelf", ("soma:Shelf",)), Entity("cup", ("soma:Cup",))
    first, second = (0.1 if m else 0.0 for m in moving)
    path = track(
        (0, 0, 0, 0), (2, 0, 0, 0), (4, first, 0, 0), (12, first, 0, 0), (14, first + second, 0, 0), (16, 1, 0, 0)
    )
    events = [*sliding("box", "table", 2), *sliding("cup", "shelf", 12)]
    found = read(episode([BOX, TABLE, shelf, cup], events, {"hand": path}))
    slides = [(a.start, m.roles) for a in found.actions for m in a.named("artm:SlidingObject") if a.label is not None]
    wanted = [(2, {"Locatum": "box", "Relatum": "table"}), (12, {"Locatum": "cup", "Relatum": "shelf"})]
    assert slides == list(itertools.compress(wanted, moving))


@given(st.floats(-0.3, 0.3), st.floats(0.0, 3.0), st.sampled_from(["box", "cup"]))
def test_what_happens_later_changes_no_action(far: float, long: float, which: str) -> None:
    cup = Entity("cup", ("soma:Cup",))
    before = ((0, 0, 0, 0), (2, 0, 0, 0), (4, 0.1, 0, 0), (6, 0.1, 0, 0))
    later = ((8, 0.1, far, 0), (9 + long, 0, far, far))
    alone = [*sliding("box", "table", 2), action("soma:PhysicalAction", 6, 7)]
    more = [*alone, action("soma:PhysicalAction", 8, 9 + long, object=which), state("contact", "hand", which, 8, 9)]
    one = read(episode([BOX, TABLE, cup], alone, {"hand": track(*before, (9, 0.1, 0, 0))}))
    other = read(episode([BOX, TABLE, cup], more, {"hand": track(*before, (7.5, 0.1, 0, 0), *later)}))
    kept = [(a.start, a.end, a.readings) for a in one.actions if a.end <= 6]
    assert len(kept) > 2
    assert [(a.start, a.end, a.readings) for a in other.actions if a.end <= 6] == kept


def test_there_and_back_is_motion() -> None:
    away = episode(
        [], [action("soma:PhysicalAction", 0, 2)], {"hand": track((0, 0, 0, 0), (1, 0.3, 0, 0), (2, 0, 0, 0))}
    )
    still = episode([], [action("soma:PhysicalAction", 0, 2)], {"hand": track((0, 0, 0, 0), (2, 0, 0, 0))})
    assert tasks(read(away).actions[0]) == {"soma:AssumingArmPose"}
    assert tasks(read(still).actions[0]) == {"artm:NoOp"}


def test_roles_come_from_the_action_itself_never_from_another() -> None:
    other = Entity("can", ("cram:Product",))
    sample = episode(
        [BOX, other],
        [state("grasp", "hand", "box", 1, 2), state("grasp", "hand", "can", 4, 5)],
        {"hand": track((0, 0, 0, 0), (6, 0, 0, 0))},
    )
    found = read(sample)
    assert [m.roles["Patient"] for a in found.actions for m in a.named("soma:Grasping")] == ["box", "can"]


def test_an_action_without_a_task_is_a_reported_hole() -> None:
    opening = np.array([(0, 0.0), (2, 0.1)])
    sample = episode(
        [BOX],
        [action("soma:PhysicalAction", 0, 2), state("contact", "hand", "box", 1, 2)],
        {"hand": track((0, 0, 0, 0), (2, 1, 0, 0))},
        opening,
    )
    found = read(sample)
    assert len(found.holes) == 1
    assert found.count() == 0
    assert list(found.sequences()) == []
    assert len(found.holes[0].rejections) == len(RULES)


# Each task and a sibling that it is not


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
    assert not read(Engine().read_episode(data_folder("scenarios") / name / "demonstration")).holes


def test_what_opens_on_is_a_hole_without_the_rule() -> None:
    demonstration = Engine().read_episode(data_folder("scenarios") / "fetch_from_hanger" / "demonstration")
    others = [r for r in RULES if r.task != "artm:OpenGripperTask"]
    (hole,) = interpret(demonstration, others, TAXONOMY).holes
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
    from cramlite.episode import Track

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


# Merging


def test_an_irrelevant_boundary_is_merged_with_its_evidence() -> None:
    other = [state("contact", "jar", "table", 1, 2)]
    sample = episode([CONTAINER, TABLE], other, {"hand": track((0, 2, 0, 1), (3, 3, 0, 1))})
    apart, joined = read(sample, merge=False), read(sample)
    assert len(apart.actions) == 3
    (one,) = joined.actions
    assert len(one.segments) == 3
    assert "1.00 s, 2.00 s" in one.evidence
    assert joined.count() == 1
    assert joined.to_json()["actions"][0]["merged"]["segments"] == [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0]]


def test_a_boundary_that_matters_is_kept() -> None:
    sample = episode([BOX], [state("grasp", "hand", "box", 1, 2)], {"hand": track((0, 2, 0, 1), (3, 3, 0, 1))})
    assert len(read(sample).actions) == 3


def test_labelled_actions_are_never_merged() -> None:
    sample = episode(
        [],
        [action("soma:PhysicalAction", 0, 1), action("soma:PhysicalAction", 1, 2)],
        {"hand": track((0, 0, 0, 0), (2, 1, 0, 0))},
    )
    assert len(read(sample).actions) == 2


def test_every_instant_belongs_to_an_action() -> None:
    found = read(hanger_episode())
    assert found.actions[0].start == 0.0
    assert found.actions[-1].end == 8.0
    assert all(a.end == b.start for a, b in itertools.pairwise(found.actions))


# Sequences

CHOICES = st.lists(
    st.lists(
        st.builds(
            Match,
            st.sampled_from(["soma:Grasping", "soma:Reaching", "artm:NoOp"]),
            st.dictionaries(st.sampled_from(["Patient", "Goal"]), st.sampled_from("ab"), max_size=2),
            st.just(""),
            st.integers(0, 8),
        ),
        max_size=3,
    ),
    max_size=5,
)


@settings(max_examples=60, deadline=None)
@given(CHOICES)
def test_sequences_are_counted_complete_and_best_first(choices: list[list[Match]]) -> None:
    found = Interpretation("x", tuple(Interpreted(k, k + 1, tuple(m)) for k, m in enumerate(choices)), TAXONOMY)
    listed = list(found.sequences())
    explained = [c for c in choices if c]
    assert found.count() == len(listed) == (math.prod(len(c) for c in explained) if explained else 0)
    scores = [s.score for s in listed]
    assert all(a >= b - 1e-9 for a, b in itertools.pairwise(scores))
    for one in listed:
        total = sum(specificity(m, TAXONOMY) for m in one.matches) + sum(
            affinity(a, b) for a, b in itertools.pairwise(one.matches)
        )
        assert one.score == pytest.approx(total)


def test_sequences_are_lazy_and_bounded_in_memory() -> None:
    choices = tuple(Match("soma:Grasping", {"Patient": p}, "") for p in "abc")
    found = Interpretation("x", tuple(Interpreted(k, k + 1, choices) for k in range(300)), TAXONOMY)
    assert found.count() == 3**300
    listed = list(itertools.islice(found.sequences(cap=2000), 5))
    assert len(listed) == 5
    assert listed[0].score == max(s.score for s in listed)


def test_an_episode_without_events_has_no_actions() -> None:
    found = read(episode([], [], {}))
    assert found.actions == ()
    assert found.count() == 0
    assert list(found.sequences()) == []


@pytest.mark.parametrize("held", [True, False])
def test_shaking_is_what_the_log_says_of_a_held_thing(held: bool) -> None:
    events = [action("cram:Shaking", 1.0, 2.0, object="product")]
    events += [state("grasp", "hand", "product", 0.5, 3.0)] if held else [state("contact", "hand", "product", 0.5, 3.0)]
    found = interpret(episode(SHOP, events), RULES, TAXONOMY)
    (shaken,) = [a for a in found.actions if a.label == "cram:Shaking"]
    assert bool(shaken.named("cram:Shaking")) == held
