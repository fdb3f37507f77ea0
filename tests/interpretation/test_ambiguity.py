"""What an action is where it might be several tasks, as in the paper; and what the published rules got wrong."""

from __future__ import annotations

import itertools

import pytest
from helpers.interpretation_reading import BOX, RULES, TABLE, TAXONOMY, at, read, tasks
from helpers.interpretation_samples import action, episode, state, track
from hypothesis import given
from hypothesis import strategies as st

from cramlite.interpretation.interpretation import interpret
from cramlite.model import Entity, Episode, Event, Pose

CONTAINER = Entity("jar", ("soma:Jar",), pose=Pose((0.5, 0, 0)), size=(0.1, 0.1, 0.1))
LID = Entity("lid", ("soma:Lid",), size=(0.1, 0.1, 0.01))


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
