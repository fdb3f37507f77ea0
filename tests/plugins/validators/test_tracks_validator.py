"""The validator of whole tracks: what no task takes, what falls, slides or comes back is refused, and what resembles it passes."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest
from helpers.short_runs import (
    COUNT,
    HANDOVERS,
    LEFT,
    OPENED,
    ORIGINS,
    RIGHT,
    TAKEN,
    good,
    only,
    posed,
    said,
    shifted,
    touching,
    track,
)
from msgspec.structs import replace

from cramlite.model import Finding, Floats, Geom, Joint, MoveLinear, Pose, Swing, Touch, Wait
from cramlite.plugin import Allowance, Candidate
from cramlite_plugins.validators.tracks import BACK, DROP, SLIDES, Tracks

VALIDATOR = Tracks()
PARKING = range(OPENED + 20, OPENED + 28)


def pinched(thing: str, when: range) -> Candidate:
    """The candidate, in whose run both pads press a thing at some samples."""
    return touching(when, Touch(LEFT, thing, 20.0, 1.0), Touch(thing, RIGHT, 20.0, -1.0))


def refused(of: Candidate) -> Finding:
    """The one objection to a candidate."""
    (found,) = (f for f in VALIDATOR.check(of) if not f.passed)
    return found


def test_a_thing_that_is_taken_carried_and_put_down_is_explained() -> None:
    assert only(VALIDATOR, good()).reason == "the hand held 'block' (1 times), always as tasks of the plan explain"
    idle = touching(range(COUNT), without=lambda t: LEFT in (t.a, t.b))
    assert only(VALIDATOR, replace(idle, handovers=())).reason == "the hand held nothing, always as tasks of the plan explain"


@pytest.mark.parametrize(("before", "end"), [(0.2, 0.15), (0.15, 0.2)])
def test_the_way_of_what_no_task_takes_is_told(before: float, end: float) -> None:
    """The furthest, until its last sample in the hand."""
    carried, base = pinched("cup", PARKING), good().rollout
    assert carried.rollout is not None and base is not None
    x, last = 0.4, PARKING.stop - 1
    knots = ((0, 0.0), (PARKING.start, 0.0), (last - 2, 0.1), (last - 1, before), (last, end), (last + 1, 0.3))
    way = track(*((k, (x + by, -0.35, 0.2)) for k, by in knots))
    found = refused(replace(carried, rollout=replace(carried.rollout, poses={**base.poses, "cup": way})))
    assert found.value == pytest.approx(0.2) and "and moved by 200 mm" in found.reason and found.origin == "4.ParkingArms"


@pytest.mark.parametrize("thing", ["cup", "block"])
def test_a_grip_that_no_task_takes_is_refused(thing: str) -> None:
    (why,) = said(VALIDATOR, pinched(thing, PARKING))
    assert f"'{thing}' was in the hand from 4.5 to 4.9 s" in why and "no task" in why


def test_a_brush_of_both_pads_is_no_grip() -> None:
    assert said(VALIDATOR, pinched("cup", PARKING[:3])) == []


def test_of_a_text_without_a_run_the_tasks_roles_say_what_may_be_taken() -> None:
    unknown = replace(good(), handovers=None)
    assert said(VALIDATOR, unknown) == []
    (why,) = said(VALIDATOR, replace(pinched("cup", PARKING), handovers=None))
    assert "no task that runs then is about it" in why


def test_a_task_that_says_nothing_of_handovers_may_take_what_its_roles_name() -> None:
    silent = replace(good(), handovers=())
    (why,) = said(VALIDATOR, silent)  # it is let go of in another task than it was taken in
    assert "no task of the plan takes it then" in why
    once = replace(silent, actions=(replace(silent.actions[0], name="1.Own"),), parts=())
    assert once.code is not None
    assert said(VALIDATOR, replace(once, code=replace(once.code, origins={1: "1.Own/all"}))) == []
    code, other = replace(once.code, origins={1: "1.Own/all"}), pinched("cup", PARKING)
    (why,) = said(VALIDATOR, replace(other, handovers=(), actions=once.actions, parts=(), code=code))
    assert "'cup' was in the hand" in why


def test_fingers_that_open_after_the_retreat_are_refused() -> None:
    late = replace(good(), program=replace(good().program, steps=tuple(Wait(0.1, origin=o) for o in ORIGINS.values())))
    assert said(VALIDATOR, late) == []
    swapped = {**ORIGINS, 5: "4.ParkingArms/move", 9: "3.Placing/PuttingDown/lower"}
    assert late.code is not None
    (why,) = said(VALIDATOR, replace(late, code=replace(late.code, origins=swapped)))
    assert "3.Placing/Releasing/open lets go of it, but it is still in the hand during 4.ParkingArms/move" in why


def test_what_is_let_go_on_the_way_and_taken_again_is_refused() -> None:
    lost = touching(range(40, 46), without=lambda t: LEFT in (t.a, t.b) or RIGHT in (t.a, t.b))
    assert lost.rollout is not None
    opening = lost.rollout.opening.copy()
    opening[40:46] = 0.085
    why = said(VALIDATOR, replace(lost, rollout=replace(lost.rollout, opening=opening)))
    assert any("no task of the plan lets go of it then" in w for w in why)
    assert any("was not in the hand from 2.0 to 2.2 s, between 1.Grasping/close and 3.Placing/Releasing/open" in w for w in why)


def lost(rows: range) -> Candidate:
    """The candidate, whose fingers open about the block at some samples."""
    free = touching(rows, without=lambda t: LEFT in (t.a, t.b))
    assert free.rollout is not None
    opening = free.rollout.opening.copy()
    opening[list(rows)] = 0.085
    return replace(free, rollout=replace(free.rollout, opening=opening))


def gap(of: Candidate) -> list[Finding]:
    return [f for f in VALIDATOR.check(of) if "was not in the hand" in f.reason]


def test_a_time_without_a_grip_is_told_of_the_task_in_which_it_begins() -> None:
    (found,) = gap(lost(range(49, 56)))
    assert found.origin == "2.PickingUp"


@pytest.mark.parametrize(("count", "passes"), [(4, True), (5, False)])
def test_a_time_without_a_grip_is_from_its_first_sample_to_its_last(count: int, passes: bool) -> None:
    slow = lost(range(30, 30 + count))
    assert slow.rollout is not None
    assert (gap(replace(slow, rollout=replace(slow.rollout, times=np.arange(COUNT) * 0.06))) == []) is passes


@pytest.mark.parametrize(("count", "passes"), [(4, True), (5, False)])
def test_what_is_in_the_hand_at_the_start_is_so_from_the_first_sample(count: int, passes: bool) -> None:
    held = touching(range(count, TAKEN), Touch(LEFT, "block", 50.0, 1.0), Touch("block", RIGHT, 50.0, -1.0))
    assert held.rollout is not None
    opening = held.rollout.opening.copy()
    opening[count:TAKEN] = 0.06
    slow = replace(held.rollout, opening=opening, times=np.arange(COUNT) * 0.06)
    begun = replace(held, rollout=slow, handovers=(replace(HANDOVERS[0], by=""), HANDOVERS[1]))
    assert (gap(begun) == []) is passes


@pytest.mark.parametrize(("first", "passes"), [(0, True), (10, True), (11, False), (20, False)])
def test_what_is_in_the_hand_at_the_start_is_so_for_its_first_half_second(first: int, passes: bool) -> None:
    base = good().rollout
    assert base is not None
    pads = (Touch(LEFT, "block", 50.0, 1.0), Touch("block", RIGHT, 50.0, -1.0))
    free = [tuple(t for t in row if not {LEFT, RIGHT} & {t.a, t.b}) for row in base.touches]
    held = [first <= k < OPENED for k in range(COUNT)]
    rows = tuple((*row, *pads) if now else row for row, now in zip(free, held, strict=True))
    begun = good(touches=rows, opening=np.where(held, 0.06, 0.085))
    why = said(VALIDATOR, replace(begun, handovers=(replace(HANDOVERS[0], by=""), HANDOVERS[1])))
    assert any("no task of the plan takes it then" in w for w in why) is not passes


def test_code_that_takes_a_thing_may_run_for_one_sample() -> None:
    base = good().rollout
    assert base is not None
    lines = base.lines.copy()
    lines[:25] = 0.0
    lines[TAKEN + 1] = 1.0
    once = good(lines=lines)
    assert said(VALIDATOR, once) == []
    (found,) = gap(replace(once, handovers=(replace(HANDOVERS[0], thing="cup"), replace(HANDOVERS[1], thing="cup"))))
    assert "'cup' was not in the hand from 0.6 to 3.5 s" in found.reason


@pytest.mark.parametrize(("first", "count", "passes"), [(25, 4, True), (25, 6, False), (64, 4, True), (64, 6, False)])
def test_between_handovers_a_thing_is_lost_for_a_fifth_of_a_second_at_most(first: int, count: int, passes: bool) -> None:
    """At once after the fingers closed, and right up to when they open."""
    rows = range(first, first + count) if first == 25 else range(70 - count, 70)
    wrong = [f for f in VALIDATOR.check(lost(rows)) if not f.passed]
    gaps = [f for f in wrong if "was not in the hand" in f.reason]
    assert (gaps == []) is passes and all(f.things for f in wrong)
    if gaps:
        span = f"from {0.05 * rows[0]:.1f} to {0.05 * rows[-1]:.1f} s"
        assert gaps[0].reason == f"'block' was not in the hand {span}, between 1.Grasping/close and 3.Placing/Releasing/open"
        assert gaps[0].origin == ("2.PickingUp" if first == 25 else "3.Placing/PuttingDown")


def test_who_has_no_code_for_a_handover_is_told_by_others() -> None:
    elsewhere = (HANDOVERS[0], replace(HANDOVERS[1], by="9.Nowhere"))
    assert all("was not in the hand" not in w for w in said(VALIDATOR, replace(good(), handovers=elsewhere)))
    never = touching(range(COUNT), without=lambda t: LEFT in (t.a, t.b))
    assert any("was not in the hand" in w for w in said(VALIDATOR, never))
    free = tuple(replace(h, optional=True) for h in HANDOVERS)
    assert said(VALIDATOR, replace(never, handovers=free)) == []
    for k in (0, 1):
        half = tuple(replace(h, optional=n == k) for n, h in enumerate(HANDOVERS))
        assert said(VALIDATOR, replace(never, handovers=half)) == []


def test_what_is_let_go_comes_to_rest_in_three_seconds() -> None:
    base = good().rollout
    assert base is not None
    way = base.poses["block"].copy()
    way[OPENED - 1 :, 0] += np.linspace(0.0, 0.3, COUNT - OPENED + 1)
    for period, passes in ((0.09, True), (0.15, False)):
        rolls = good(poses={**base.poses, "block": way}, times=np.arange(COUNT) * period)
        assert (said(VALIDATOR, rolls) == []) is passes
    found = refused(rolls)
    assert "'block', let go at 10.3 s, kept moving for 4.5 s, limit 3 s" in found.reason
    assert found.value == pytest.approx(30 * 0.15) and (found.limit, found.unit, found.origin) == (3.0, "s", "3.Placing/PuttingDown")
    assert found.things


def test_a_contact_that_chatters_is_no_interruption() -> None:
    assert said(VALIDATOR, touching(range(40, 43), without=lambda t: LEFT in (t.a, t.b))) == []


def test_a_fall_is_as_deep_as_its_place_says_and_no_deeper() -> None:
    for deeper, passes in ((-0.001, True), (0.001, False)):
        fallen = shifted((0.0, 0.0, -(DROP + deeper)), "block", OPENED + 1)
        assert (said(VALIDATOR, fallen) == []) is passes
    let_fall = replace(HANDOVERS[1], rest=replace(HANDOVERS[1].rest, fall=0.2)) if HANDOVERS[1].rest else HANDOVERS[1]
    far = shifted((0.0, 0.0, -0.2), "block", OPENED + 1)
    assert said(VALIDATOR, replace(far, handovers=(HANDOVERS[0], let_fall))) == []
    found = refused(far)
    assert found.reason == "'block', let go at 3.5 s, fell by 200 mm after 3.Placing/Releasing/open, limit 30 mm"
    assert found.value == pytest.approx(0.2) and (found.limit, found.unit, found.origin) == (DROP, "m", "3.Placing/PuttingDown")
    assert found.things


@pytest.mark.parametrize(("geoms", "more"), [
    ((Geom("box", (0.03, 0.03, 0.08)),), 0.05), ((Geom("box", (0.03, 0.03, 0.08), Pose((0.0, 0.0, 0.05))),), 0.0),
    ((Geom("box", (0.03, 0.03, 0.08), Pose((0.0, 0.0, 0.07))),), 0.0),
])  # fmt: skip
def test_what_falls_over_comes_down_by_the_difference_of_its_sides(geoms: tuple[Geom, ...], more: float) -> None:
    """A post of 160 mm stands and may lie, with its origin in its middle; one with its origin low does not come down."""
    for deeper, passes in ((-0.001, True), (0.001, False)):
        fallen = shifted((0.0, 0.0, -(DROP + more + deeper)), "block", OPENED + 1)
        assert fallen.rollout is not None
        world = fallen.rollout.world
        things = tuple(replace(t, geoms=geoms) if t.name == "block" else t for t in world.things)
        tall = replace(fallen, rollout=replace(fallen.rollout, world=replace(world, things=things)))
        assert (said(VALIDATOR, tall) == []) is passes


def test_what_came_to_rest_may_sink_by_a_millimetre() -> None:
    for sinks in (0.0, 0.001):
        fallen = shifted((0.0, 0.0, -(DROP - 0.0005)), "block", OPENED + 1).rollout
        assert fallen is not None
        way = fallen.poses["block"].copy()
        way[OPENED + 2 :, 2] -= sinks
        assert said(VALIDATOR, posed(block=way)) == []


def test_a_fall_is_refused_whatever_else_was_wrong_before() -> None:
    both = pinched("cup", range(2, 8))
    fallen = shifted((0.0, 0.0, -0.2), "block", OPENED + 1)
    assert both.rollout is not None and fallen.rollout is not None
    why = said(VALIDATOR, replace(both, rollout=replace(both.rollout, poses=fallen.rollout.poses)))
    assert len(why) == 2 and "'cup' was in the hand" in why[0] and "'block', let go at 3.5 s, fell" in why[1]


def dragged(by: float) -> Candidate:
    """The candidate, whose block is led along the floor after it was taken."""
    base = good().rollout
    assert base is not None
    way = base.poses["block"].copy()
    way[TAKEN + 3 : 24, 0] += np.linspace(0.0, by, 24 - TAKEN - 3)
    way[24:, 0] += by
    return posed(block=way)


def free(candidate: Candidate, slides: bool) -> Candidate:
    """The candidate, whose tasks all slide what they hold, or none does."""
    return replace(candidate, allowances={k: replace(a, slides=slides) for k, a in candidate.allowances.items()})


def test_a_payload_is_not_dragged_by_a_task_that_slides_nothing() -> None:
    assert said(VALIDATOR, free(dragged(SLIDES - 0.001), slides=False)) == []
    (why,) = said(VALIDATOR, free(dragged(SLIDES + 0.002), slides=False))
    assert "'block' was dragged along 'floor' by 17 mm from 0.5 to 1.2 s, limit 15 mm in a task that may not slide a thing" in why
    turns = MoveLinear(Pose(), 0.1, 0.5, origin="1.Grasping/close", swing=Swing(Pose(), Pose((0.0, 0.0, 0.1)), (0.0, 0.0, 0.0)))
    for origin, excused in (("1.Grasping/close", True), ("2.PickingUp/lift", False), ("4.ParkingArms/move", False)):
        swings = replace(dragged(0.1), program=replace(good().program, steps=(replace(turns, origin=origin),)))
        assert (said(VALIDATOR, free(swings, slides=False)) == []) is excused
    assert said(VALIDATOR, free(dragged(0.1), slides=True)) == []
    assert refused(free(dragged(0.1), slides=False)).things


def test_a_turn_excuses_a_slide_that_it_meets_at_one_end() -> None:
    """The block is dragged along the floor from sample 10 to 23."""
    turn = MoveLinear(Pose(), 0.1, 0.5, origin="1.Grasping/turn", swing=Swing(Pose(), Pose((0.0, 0.0, 0.1)), (0.0, 0.0, 0.0)))
    made = dragged(0.1)
    assert made.rollout is not None and made.code is not None
    for rows, excused in ((range(24, 25), False), (range(23, 25), True), (range(2, 11), True), (range(2, 10), False)):
        lines = made.rollout.lines.copy()
        lines[rows.start : rows.stop] = 2.0
        code = replace(made.code, origins={**ORIGINS, 2: turn.origin})
        turned = replace(made, rollout=replace(made.rollout, lines=lines), code=code)
        turned = replace(turned, program=replace(turned.program, steps=(turn,)))
        assert all("was dragged" not in w for w in said(VALIDATOR, free(turned, slides=False))) is excused


def test_a_task_that_slides_nothing_is_asked_behind_one_that_slides() -> None:
    base = dragged(0.0)
    assert base.rollout is not None
    for until, dragging in ((49, True), (50, False), (65, False)):  # PickingUp ends at 49, and PuttingDown slides
        way = base.rollout.poses["block"].copy()
        way[:, 2] = 0.03
        way[:, 1] = 0.2 + np.where(np.arange(COUNT) >= until, 0.03, 0.0)
        rows = tuple((*r, Touch("floor", "block", 1.0, 1.0)) for r in base.rollout.touches)
        allowed = {k: replace(a, slides=k != "2.PickingUp") for k, a in base.allowances.items()}
        slid = replace(base, rollout=replace(base.rollout, poses={**base.rollout.poses, "block": way}, touches=rows), allowances=allowed)
        why = [w for w in said(VALIDATOR, slid) if "was dragged" in w]
        assert len(why) == dragging


def test_a_thing_that_is_pushed_stays_where_it_was_pushed_to() -> None:
    for back, passes in ((BACK - 0.001, True), (BACK + 0.001, False)):
        way = track((0, (0.4, -0.35, 0.2)), (82, (0.4, -0.35, 0.2)), (90, (0.46, -0.35, 0.2)), (95, (0.46 - back, -0.35, 0.2)))
        way[70:80, :3] += (0.0, 0.0, 0.3)  # another task ran then
        pushed = posed(cup=way)
        moving = {**pushed.allowances, "4.ParkingArms": Allowance(moves=frozenset({"cup"}))}
        assert (said(VALIDATOR, replace(pushed, allowances=moving)) == []) is passes


def test_what_a_task_carries_and_pushes_may_go_to_and_fro_in_the_hand() -> None:
    """Where it ends, its place says; another task may push it, not push it back."""
    base = good().rollout
    assert base is not None
    for first, task, passes in ((52, "3.Placing/PuttingDown", True), (82, "4.ParkingArms", False)):
        way = base.poses["block"].copy()
        way[first:, 0] += np.interp(range(first, COUNT), [first, first + 4, first + 8], [0.0, 0.8, 0.0])
        made = posed(block=way)
        moving = {**made.allowances, task: Allowance(moves=frozenset({"block"}))}
        found = [w for w in said(VALIDATOR, replace(made, allowances=moving)) if "came back" in w]
        assert (found == []) is passes


def test_what_is_on_a_joint_and_led_by_the_hand_does_not_come_back() -> None:
    base = good().rollout
    assert base is not None
    things = tuple(replace(t, joint=Joint("hinge", Pose(), 0.0, 2.0)) if t.name == "block" else t for t in base.world.things)
    for back, passes in ((0.19, True), (0.3, False)):
        values = np.interp(range(COUNT), [50, 58, 66], [0.0, 1.0, 1.0 - back])
        turned = good(world=replace(base.world, things=things), values={"block": values})
        moving = {**turned.allowances, "3.Placing/PuttingDown": Allowance(moves=frozenset({"block"}))}
        found = [w for w in said(VALIDATOR, replace(turned, allowances=moving)) if "came back" in w]
        assert (found == []) is passes


def pushed(*knots: tuple[int, tuple[float, float, float]], **changes: Any) -> Candidate:
    """The candidate, in whose run a task moves the cup while the arm parks, at samples 80 to 99."""
    made = posed(cup=track(*knots))
    moving = {**made.allowances, "4.ParkingArms": Allowance(moves=frozenset({"cup"}))}
    assert made.rollout is not None
    return replace(made, allowances=moving, rollout=replace(made.rollout, **changes))


def test_a_push_is_from_the_first_sample_of_its_task_to_the_last() -> None:
    start, far = (0.4, -0.35, 0.2), (0.46, -0.35, 0.2)
    assert said(VALIDATOR, pushed((80, start), (85, far))) == []
    assert said(VALIDATOR, pushed((80, start), (85, far), (98, far), (99, (0.44, -0.35, 0.2)))) != []
    assert said(VALIDATOR, pushed((80, start), (81, (0.42, -0.35, 0.2)), (82, (0.408, -0.35, 0.2)))) != []  # nearer to its second place
    assert said(VALIDATOR, pushed((80, start), (85, (0.4, -0.35, 0.26)), (90, (0.4, -0.35, 0.23)))) != []  # lifted and set down again


def test_a_push_may_last_for_one_sample() -> None:
    base = good().rollout
    assert base is not None
    lines = base.lines.copy()
    lines[80:] = 0.0
    lines[40] = 9.0  # the last line goes on to the end of the run
    lines[41:80] = np.where(lines[41:80] == 3.0, 3.0, lines[41:80])
    once = pushed((39, (0.4, -0.35, 0.2)), (40, (0.46, -0.35, 0.2)), (41, (0.4, -0.35, 0.2)), lines=lines)
    assert all("came back" not in w for w in said(VALIDATOR, once))


def test_what_is_pushed_may_turn_to_and_fro() -> None:
    made = pushed((0, (0.4, -0.35, 0.2)))
    assert made.rollout is not None
    way = made.rollout.poses["cup"].copy()
    for k in range(85, 90):
        way[k, 3:] = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, 0.8)).quaternion
    assert said(VALIDATOR, replace(made, rollout=replace(made.rollout, poses={**made.rollout.poses, "cup": way}))) == []


def joined(values: Floats | None) -> Candidate:
    """The candidate, whose cup is on a slide of 2 m and moved by the task that parks."""
    base = good().rollout
    assert base is not None
    things = tuple(replace(t, joint=Joint("slide", Pose(), 0.5, 2.5)) if t.name == "cup" else t for t in base.world.things)
    world = replace(base.world, things=things)
    return pushed((0, (0.4, -0.35, 0.2)), world=world, values={} if values is None else {"cup": values})


def test_a_drawer_that_was_closed_stays_as_far_closed() -> None:
    assert said(VALIDATOR, joined(np.interp(range(COUNT), [80, 85, 90], [2.0, 0.5, 0.65]))) == []
    assert said(VALIDATOR, joined(np.interp(range(COUNT), [80, 85, 90], [2.0, 0.5, 0.75]))) != []
    assert said(VALIDATOR, joined(np.interp(range(COUNT), [80, 81, 82], [1.0, 1.4, 1.15]))) != []  # nearer to its second value


def test_of_a_drawer_whose_values_nobody_noted_the_place_is_judged() -> None:
    assert said(VALIDATOR, joined(None)) == []
    made = joined(None)
    assert made.rollout is not None
    way = track((80, (0.4, -0.35, 0.2)), (85, (0.46, -0.35, 0.2)), (90, (0.44, -0.35, 0.2)))
    (why,) = said(VALIDATOR, replace(made, rollout=replace(made.rollout, poses={**made.rollout.poses, "cup": way})))
    assert "'cup' was moved by 60 mm and came back by 20 mm" in why


def test_a_door_that_was_opened_stays_as_far_open() -> None:
    base = good().rollout
    assert base is not None
    kinds: tuple[tuple[Literal["hinge", "slide"], str, str], ...] = (("hinge", "rad", "29 deg"), ("slide", "m", "500 mm"))
    for kind, unit, came_back in kinds:
        for back, passes in ((0.19, True), (0.21, False), (0.5, False)):
            joint = Joint(kind, Pose(), 0.5, 2.5)
            things = tuple(replace(t, joint=joint) if t.name == "cup" else t for t in base.world.things)
            opened = np.interp(range(COUNT), [79, 80, 82, 88, 89], [1.4, 0.5, 0.5, 2.0, 2.0 - back])
            turned = good(world=replace(base.world, things=things), values={"cup": opened})
            moving = {**turned.allowances, "4.ParkingArms": Allowance(moves=frozenset({"cup"}))}
            wrong = [f for f in VALIDATOR.check(replace(turned, allowances=moving)) if not f.passed]
            assert (wrong == []) is passes and all(f.things and f.origin == "4.ParkingArms" for f in wrong)
        (found,) = wrong
        assert found.unit == unit and found.limit == pytest.approx(0.2) and f"came back by {came_back}" in found.reason
