"""The judge of whole tracks: what no task takes, what falls, slides or comes back is refused, and what resembles it passes."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from short_runs import HANDOVERS, LEFT, OPENED, ORIGINS, RIGHT, TAKEN, good, posed, said, shifted, touching, track

from cramlite.model import Touch, Wait
from cramlite.plugin import Allowance, Candidate
from cramlite_plugins.validators.tracks import BACK, DROP, SLIDES, Tracks

JUDGE = Tracks()
PARKING = range(OPENED + 20, OPENED + 28)


def pinched(thing: str, when: range) -> Candidate:
    """The candidate, in whose run both pads press a thing at some samples."""
    return touching(when, Touch(LEFT, thing, 20.0, 1.0), Touch(thing, RIGHT, 20.0, -1.0))


def test_a_thing_that_is_taken_carried_and_put_down_is_explained() -> None:
    assert said(JUDGE, good()) == []


@pytest.mark.parametrize("thing", ["cup", "block"])
def test_a_grip_that_no_task_takes_is_refused(thing: str) -> None:
    (why,) = said(JUDGE, pinched(thing, PARKING))
    assert f"'{thing}' was in the hand from 4.5 to 4.9 s" in why and "no task" in why


def test_a_brush_of_both_pads_is_no_grip() -> None:
    assert said(JUDGE, pinched("cup", PARKING[:3])) == []


def test_of_a_text_without_a_run_the_tasks_roles_say_what_may_be_taken() -> None:
    unknown = replace(good(), handovers=None)
    assert said(JUDGE, unknown) == []
    (why,) = said(JUDGE, replace(pinched("cup", PARKING), handovers=None))
    assert "no task that runs then is about it" in why


def test_a_task_that_says_nothing_of_handovers_may_take_what_its_roles_name() -> None:
    silent = replace(good(), handovers=())
    (why,) = said(JUDGE, silent)  # it is let go of in another task than it was taken in
    assert "no task of the plan takes it then" in why
    once = replace(silent, actions=(replace(silent.actions[0], name="1.Own"),), parts=())
    assert once.code is not None
    assert said(JUDGE, replace(once, code=replace(once.code, origins={1: "1.Own/all"}))) == []
    code, other = replace(once.code, origins={1: "1.Own/all"}), pinched("cup", PARKING)
    (why,) = said(JUDGE, replace(other, handovers=(), actions=once.actions, parts=(), code=code))
    assert "'cup' was in the hand" in why


def test_fingers_that_open_after_the_retreat_are_refused() -> None:
    late = replace(good(), program=replace(good().program, steps=tuple(Wait(0.1, origin=o) for o in ORIGINS.values())))
    assert said(JUDGE, late) == []
    swapped = {**ORIGINS, 5: "4.ParkingArms/move", 9: "3.Placing/PuttingDown/lower"}
    assert late.code is not None
    (why,) = said(JUDGE, replace(late, code=replace(late.code, origins=swapped)))
    assert "3.Placing/Releasing/open lets go of it, and 4.ParkingArms/move comes after that" in why


def test_what_is_let_go_on_the_way_and_taken_again_is_refused() -> None:
    lost = touching(range(40, 46), without=lambda t: LEFT in (t.a, t.b) or RIGHT in (t.a, t.b))
    assert lost.rollout is not None
    opening = lost.rollout.opening.copy()
    opening[40:46] = 0.085
    why = said(JUDGE, replace(lost, rollout=replace(lost.rollout, opening=opening)))
    assert any("no task of the plan lets go of it then" in w for w in why)
    assert any("was not in the hand from 2.0 to 2.2 s, between 1.Grasping/close and 3.Placing/Releasing/open" in w for w in why)


def test_a_contact_that_chatters_is_no_interruption() -> None:
    assert said(JUDGE, touching(range(40, 43), without=lambda t: LEFT in (t.a, t.b))) == []


def test_a_fall_is_as_deep_as_its_place_says_and_no_deeper() -> None:
    for deeper, passes in ((-0.001, True), (0.001, False)):
        fallen = shifted((0.0, 0.0, -(DROP + deeper)), "block", OPENED + 1)
        assert (said(JUDGE, fallen) == []) is passes
    let_fall = replace(HANDOVERS[1], rest=replace(HANDOVERS[1].rest, fall=0.2)) if HANDOVERS[1].rest else HANDOVERS[1]
    far = shifted((0.0, 0.0, -0.2), "block", OPENED + 1)
    assert said(JUDGE, replace(far, handovers=(HANDOVERS[0], let_fall))) == []
    assert "'block' fell by 200 mm when it was let go" in said(JUDGE, far)[0]


def dragged(by: float) -> Candidate:
    """The candidate, whose block is led along the floor after it was taken."""
    base = good().rollout
    assert base is not None
    way = base.poses["block"].copy()
    way[TAKEN + 3 : 24, 0] += np.linspace(0.0, by, 24 - TAKEN - 3)
    way[24:, 0] += by
    return posed(block=way)


def test_a_payload_is_not_dragged_by_a_task_that_slides_nothing() -> None:
    def free(candidate: Candidate, slides: bool) -> Candidate:
        allowed = {k: replace(a, slides=slides) for k, a in candidate.allowances.items()}
        return replace(candidate, allowances=allowed)

    assert said(JUDGE, free(dragged(SLIDES - 0.001), slides=False)) == []
    (why,) = said(JUDGE, free(dragged(SLIDES + 0.002), slides=False))
    assert "'block' was dragged along 'floor' by 17 mm" in why
    assert said(JUDGE, free(dragged(0.1), slides=True)) == []


def test_a_thing_that_is_pushed_stays_where_it_was_pushed_to() -> None:
    for back, passes in ((BACK - 0.001, True), (BACK + 0.001, False)):
        way = track((0, (0.4, -0.35, 0.2)), (82, (0.4, -0.35, 0.2)), (90, (0.46, -0.35, 0.2)), (95, (0.46 - back, -0.35, 0.2)))
        pushed = posed(cup=way)
        moving = {**pushed.allowances, "4.ParkingArms": Allowance(moves=frozenset({"cup"}))}
        assert (said(JUDGE, replace(pushed, allowances=moving)) == []) is passes
