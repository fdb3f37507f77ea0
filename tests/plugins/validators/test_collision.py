"""Who may touch whom, when, and how hard: each touch that a task lets happen, and its neighbour that is an objection."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import (
    COUNT,
    HANDOVERS,
    LANDED,
    LEFT,
    LIFTED,
    OPENED,
    RIGHT,
    SHELF,
    STEP,
    TAKEN,
    WEIGHT,
    candidate,
    good,
    only,
    said,
    touching,
)
from msgspec.structs import replace

from cramlite.model import Feature, Handover, JudgingLimits, Pose, Touch
from cramlite.plugin import HAND, Allowance, Candidate
from cramlite_plugins.validators.collision import GAP, GRIP, Bump, Collision, bumps

BODY = "effector/body"


def allowing(task: str, allowance: Allowance, of: Candidate) -> Candidate:
    """The candidate with what one task may touch changed."""
    return replace(of, allowances={**of.allowances, task: allowance})


def pair(one: str, other: str, **more: float | None) -> Allowance:
    return Allowance(frozenset({frozenset({one, other})}), **more)  # type: ignore[arg-type]


def hits(samples: range, one: str, other: str, force: float = 10.0) -> Candidate:
    return touching(samples, Touch(one, other, force, 0.0))


def test_the_run_as_it_is_passes() -> None:
    found = only(Collision(), good())
    assert found.passed and (found.value, found.limit) == (0.0, 2.0)
    assert "(for other contacts, limit 2 N by default)" in found.reason


def test_a_carried_thing_that_hits_another_is_an_objection() -> None:
    found = only(Collision(), hits(range(60, 61), "block", "cup"))
    assert (found.passed, found.origin, found.value, found.limit) == (False, "3.Placing/PuttingDown", 10.0, 2.0)
    assert found.reason == "'block' hit 'cup' with 10 N at 3.0 s in 3.Placing/PuttingDown; limit 2 N by default"


def test_an_objection_says_what_would_let_the_touch_be_and_offers_no_limit_that_no_task_has() -> None:
    found = only(Collision(), hits(range(60, 61), "block", "cup"))
    assert str(found.remedy) == (
        "'block' and 'cup' meet with 10.0 N where 2 N are permitted: make more room between them, or name another place, "
        "or, if that contact does no harm, permit it by 'limits: {brush: 10 N}' in the scenario"
    )
    limits = JudgingLimits(brush=10.0, of_scenario=("brush",))
    assert only(Collision(), replace(hits(range(60, 61), "block", "cup"), limits=limits)).passed, "what it says, does"
    hard = only(Collision(), hits(range(60, 61), "block", "cup", 26.0))
    assert "make more room" in str(hard.remedy) and "brush" not in str(hard.remedy)
    assert only(Collision(), good()).remedy is None


@pytest.mark.parametrize(("force", "passes"), [(2.0, True), (2.001, False)])
def test_a_brush_is_no_touch(force: float, passes: bool) -> None:
    assert only(Collision(), hits(range(60, 62), "block", "cup", force)).passed is passes
    of_scenario = JudgingLimits(brush=force, of_scenario=("brush",))
    assert only(Collision(), replace(hits(range(60, 62), "block", "cup", force), limits=of_scenario)).passed


def test_the_force_between_two_is_that_of_all_their_parts() -> None:
    both = touching([60], Touch("block", "cup/rim", 1.5, 0.0), Touch("cup", "block", 1.2, 0.0))
    found = only(Collision(), both)
    assert not found.passed and found.value == pytest.approx(2.7)
    assert found.reason.startswith("'block' hit 'cup/rim' with 3 N")


def test_the_worst_is_said() -> None:
    two = hits(range(60, 62), "block", "cup", 5.0)
    assert two.rollout is not None
    rows = tuple((*row, Touch("arm/forearm", "shelf", 8.0, 0.0)) if k == 75 else row for k, row in enumerate(two.rollout.touches))
    found = only(Collision(), candidate(replace(two.rollout, touches=rows)))
    assert (found.value, found.origin) == (8.0, "3.Placing/Releasing")
    assert [b.excess for b in bumps(candidate(replace(two.rollout, touches=rows)))] == [3.0, 3.0, 6.0]


def test_before_the_program_began_no_task_is_named() -> None:
    assert only(Collision(), hits(range(1, 2), "arm/forearm", "shelf")).reason == (
        "'arm/forearm' hit 'shelf' with 10 N at 0.1 s; limit 2 N by default"
    )


def test_what_touches_at_the_start_goes_on_touching_however_hard() -> None:
    leaning = touching(range(COUNT), Touch("cup", "shelf/edge", 500.0, 0.0))
    assert only(Collision(), leaning).passed


def test_the_hand_may_touch_at_the_start_and_no_longer_than_it_does() -> None:
    assert said(Collision(), hits(range(4), BODY, "cup")) == []
    assert said(Collision(), hits(range(1, 4), BODY, "cup"))  # at 0.05 s it is new
    within = touching([0, *range(4, 6)], Touch(BODY, "cup", 9.0, 0.0))  # lost for 0.2 s, which is a rattle
    beyond = touching([0, *range(5, 6)], Touch(BODY, "cup", 9.0, 0.0))
    assert round(GAP / STEP) == 4 and said(Collision(), within) == [] and said(Collision(), beyond)


def test_the_arm_itself_touches_nothing_ever_again() -> None:
    assert said(Collision(), hits(range(COUNT), "arm/forearm", "shelf"))  # also what it touches at the start


def test_the_hand_touches_itself() -> None:
    assert said(Collision(), hits(range(40, 45), LEFT, RIGHT, 200.0)) == []
    assert said(Collision(), hits(range(40, 45), LEFT, "arm/wrist", 200.0))


def test_the_hand_touches_nothing_that_its_task_does_not_name() -> None:
    assert said(Collision(), hits(range(60, 62), BODY, "cup"))
    named = allowing("3.Placing/PuttingDown", pair(HAND, "cup"), hits(range(60, 62), BODY, "cup", 500.0))
    assert [r for r in said(Collision(), named) if "cup" in r] == []  # what it feels is judged by ``force_peak``


def test_pads_press_what_they_close_on_a_tenth_of_a_second_before_and_let_go_of_as_long_as_contacts_chatter() -> None:
    def beside(*samples: int) -> Candidate:
        made = allowing("1.Grasping", Allowance(), touching(samples, Touch(LEFT, "block", 30.0, 0.0)))
        assert made.rollout is not None
        return replace(made, rollout=replace(made.rollout, times=made.rollout.times + 30.0))

    assert round(GRIP / STEP) == 2
    assert said(Collision(), beside(TAKEN - 2, TAKEN - 1, OPENED, OPENED + 1)) == []
    assert said(Collision(), beside(TAKEN - 3))  # at 0.35 s one pad alone presses, longer than both need
    assert said(Collision(), beside(OPENED + 8))  # the pair was forgotten: 0.4 s after the last touch


def test_what_is_held_and_lost_for_a_moment_is_still_pressed() -> None:
    slipping = touching(range(40, 50), Touch(LEFT, "block", 30.0, 0.0), without=lambda t: {LEFT, RIGHT} & {t.a, t.b} != set())
    assert said(Collision(), slipping) == []  # one grip, in which one pad presses on


def test_what_is_held_may_touch_what_it_stood_on_when_it_was_taken() -> None:
    """It stood on the floor and against the cup, which it meets once more before the floor is left."""

    def leaning(carries_on: bool) -> Candidate:
        rows = {**dict.fromkeys(range(TAKEN + 1), 1.0), LIFTED - 2: 9.0}
        base = good().rollout
        assert base is not None
        more = tuple((*row, Touch("cup", "block", rows[k], 0.0)) if k in rows else row for k, row in enumerate(base.touches))
        own = replace(good().allowances["1.Grasping"], carries_on=carries_on)
        return allowing("1.Grasping", own, good(touches=more))

    assert said(Collision(), leaning(True)) == []
    assert said(Collision(), leaning(False))


@pytest.mark.parametrize(
    ("touched", "passes"),
    [
        ((LIFTED + 3,), True),  # it leaps 0.2 s high
        ((LIFTED + 4,), False),
        ((40,), False),  # it is pressed on the floor that it was lifted from
        (tuple(range(LIFTED, 45)), True),  # it slides
        (tuple(range(LIFTED + 2, 45, 3)), True),  # it rattles
        (tuple(range(LIFTED + 2, 45, 5)), False),
    ],
)
def test_a_support_is_left_once_nothing_was_touched_for_longer_than_contacts_rattle(touched: tuple[int, ...], passes: bool) -> None:
    pressed = touching(touched, Touch("floor", "block", 14.0, 14.0))
    assert (said(Collision(), pressed) == []) is passes


def test_what_still_stands_on_one_of_two_has_left_neither() -> None:
    """It leans on the cup, which it does not touch for a second while it is drawn along the floor."""

    def drawn(last: int) -> Candidate:
        floor = range(LIFTED, last)
        base = touching(floor, Touch("floor", "block", 1.0, 1.0)).rollout
        assert base is not None
        at = {*range(TAKEN + 1), 45}
        rows = tuple((*row, Touch("cup", "block", 9.0, 0.0)) if k in at else row for k, row in enumerate(base.touches))
        return allowing("1.Grasping", pair("block", "cup"), candidate(replace(base, touches=rows)))

    assert said(Collision(), drawn(45)) == []
    assert said(Collision(), drawn(38))


def test_what_it_stood_on_is_what_it_touched_in_that_moment() -> None:
    def after(last: int) -> Candidate:
        """The cup is touched at the start up to a sample, and once more while the block is lifted."""
        return touching([*range(last + 1), LIFTED], Touch("cup", "block", 1.0, 0.0), Touch("cup", "block", 9.0, 0.0))

    assert said(Collision(), after(TAKEN - 4)) == []  # 0.2 s before it was taken
    assert said(Collision(), after(TAKEN - 5))


def test_what_a_task_says_of_the_held_thing_is_said_of_no_other() -> None:
    held = pair("held", "shelf")
    assert said(Collision(), allowing("3.Placing/PuttingDown", held, touching([62], Touch("block", "shelf", 30.0, 0.0)))) == []
    assert said(Collision(), allowing("3.Placing/PuttingDown", held, hits(range(62, 63), "cup", "floor")))
    assert said(Collision(), allowing("3.Placing/PuttingDown", pair("held", "floor"), hits(range(62, 63), "cup", "floor")))
    assert said(Collision(), allowing("3.Placing/Releasing", held, hits(range(72, 73), "block", "cup")))


def test_what_one_thing_stood_on_is_no_place_for_another() -> None:
    """What the cup stands on is no place for the block, until the task says so that puts it there."""
    assert said(Collision(), touching(range(48, 50), Touch("block", "shelf", 30.0, 0.0)))
    landed = said(Collision(), touching(range(61, 63), Touch("block", "shelf", 30.0, 0.0)))
    assert landed == []  # from the moment on that it is put down


def test_two_that_are_pressed_together_by_nobody_are_limited_by_the_task_and_their_weight() -> None:
    pushes = Allowance(frozenset({frozenset({"cup", "floor"})}), frozenset({"cup"}), force=25.0)

    def pushed(force: float) -> Candidate:
        return allowing("4.ParkingArms", pushes, hits(range(82, 83), "cup", "floor", force))

    assert said(Collision(), pushed(25.0 + WEIGHT - 1e-6)) == []
    (reason,) = said(Collision(), pushed(25.0 + WEIGHT + 1.0))
    assert reason == "'cup' hit 'floor' with 28 N at 4.1 s in 4.ParkingArms; limit 27 N, the task's force plus the weights of both things"
    assert next(bumps(pushed(25.0 + WEIGHT + 1.0))) == Bump(pytest.approx(1.0), 25 + WEIGHT + 1, 25 + WEIGHT, 82, "cup", "floor",
                                                            "limit 27 N, the task's force plus the weights of both things")  # fmt: skip
    first = allowing("3.Placing/Releasing", Allowance(force=60.0), pushed(25.0 + WEIGHT + 1.0))
    assert len(said(Collision(), first)) == 1  # the limit is that of the task that runs, not of one that moved them before
    free = allowing("4.ParkingArms", replace(pushes, force=None), hits(range(82, 83), "cup", "floor", 1e4))
    assert said(Collision(), free) == []


def test_what_a_task_let_go_of_may_still_fall_while_the_next_one_runs() -> None:
    """Rolling block: until it rests, it may touch what its own task let it touch, and nothing else."""
    base = good().rollout
    assert base is not None
    rolls = base.poses["block"].copy()
    rolls[LANDED:, 0] += np.minimum(np.arange(COUNT - LANDED), 31) * 0.01
    apart = tuple(tuple(t for t in row if {t.a, t.b} != {"block", "shelf"}) for row in base.touches)
    box = replace(SHELF, features=(Feature("inside", "cram:Cavity", Pose(), {"width": 0.2, "depth": 0.2, "height": 0.1}),))
    things = tuple(box if t.name == "shelf" else t for t in base.world.things)
    for other, world, falls in (
        ("shelf", base.world, True), ("cup", base.world, False), ("cup", replace(base.world, things=things), True),
    ):  # fmt: skip
        rows = tuple((*row, Touch("block", other, 10.0, 0.0)) if k in (94, 95) else row for k, row in enumerate(apart))
        rolling = good(poses={**base.poses, "block": rolls}, touches=rows, world=world)
        assert (said(Collision(), rolling) == []) is falls
        assert f"'block' hit '{other}' with 10 N" in said(Collision(), good(touches=rows, world=world))[0]  # it rests


def test_at_the_start_things_settle_onto_each_other_and_the_hand_onto_nothing() -> None:
    base = good().rollout
    assert base is not None
    drops = base.poses["cup"].copy()
    drops[:8, 2] += 0.005 * (8 - np.arange(8)) / 8
    dropping = {**base.poses, "cup": drops}
    rows = tuple((*row, Touch("cup", "floor", 9.0, 0.0)) if k == 4 else row for k, row in enumerate(base.touches))
    assert said(Collision(), good(poses=dropping, touches=rows)) == []
    assert said(Collision(), good(touches=rows))  # at rest from the start: nothing settles
    felt = tuple((*row, Touch("cup", BODY, 9.0, 0.0)) if k == 4 else row for k, row in enumerate(base.touches))
    assert said(Collision(), good(poses=dropping, touches=felt))
    moved = tuple((*row, Touch("cup", "block", 9.0, 0.0)) if k == 4 else row for k, row in enumerate(base.touches))
    assert said(Collision(), good(poses=dropping, touches=moved))  # one of them is at rest


def test_a_run_of_one_sample_is_judged() -> None:
    base = good().rollout
    assert base is not None
    one = {n: p[:1] for n, p in base.poses.items()}
    short = replace(base, times=base.times[:1], poses=one, touches=base.touches[:1], lines=base.lines[:1], opening=base.opening[:1])
    assert only(Collision(), candidate(short)).passed


def test_a_thing_that_is_taken_twice_is_asked_what_it_stands_on_each_time() -> None:
    """The block is put onto the shelf, taken again, and must not touch the floor any more, though the shelf."""
    again = (Touch(LEFT, "block", 5.0, 0.0), Touch("block", RIGHT, 5.0, 0.0))

    def retaken(place: str) -> Candidate:
        both = touching(range(78, 90), *again, without=lambda t: False)
        assert both.rollout is not None
        opening = both.rollout.opening.copy()
        opening[78:90] = 0.06
        lifted = dict.fromkeys(range(82, 90), ())
        rows = []
        for k, row in enumerate(both.rollout.touches):
            kept = tuple(t for t in row if k not in lifted or {t.a, t.b} != {"block", "shelf"})
            rows.append((*kept, Touch("block", place, 30.0, 0.0)) if k == 84 else kept)
        made = candidate(replace(both.rollout, opening=opening, touches=tuple(rows)))
        twice = (*HANDOVERS, Handover("block", "4.ParkingArms/move", taken=True))
        return replace(allowing("4.ParkingArms", pair(HAND, "block"), made), handovers=twice)

    assert said(Collision(), retaken("shelf")) == []
    assert said(Collision(), retaken("floor"))


def test_what_is_held_from_the_start_to_the_end_was_taken_at_the_start() -> None:
    base = touching(range(COUNT), *(Touch(s, "block", 30.0, 0.0) for s in (LEFT, RIGHT)))
    assert base.rollout is not None
    held = replace(base.rollout, opening=np.full(COUNT, 0.06))
    rows = tuple((*row, Touch("block", "floor", 30.0, 0.0)) if k == LIFTED else row for k, row in enumerate(held.touches))
    assert said(Collision(), candidate(replace(held, touches=rows))) == []
    rows = tuple((*row, Touch("block", "cup", 30.0, 0.0)) if k == LIFTED else row for k, row in enumerate(held.touches))
    assert said(Collision(), candidate(replace(held, touches=rows)))


def test_what_is_held_at_the_first_sample_stood_on_what_it_touched_then() -> None:
    """The cup, which the first task lets it touch, is touched one sample later."""
    base = touching(range(COUNT), *(Touch(s, "block", 30.0, 0.0) for s in (LEFT, RIGHT)))
    assert base.rollout is not None
    lines = np.where(np.arange(COUNT) < 2, 1, base.rollout.lines)
    for first, passes in ((0, True), (1, False)):
        rows = tuple((*row, Touch("block", "cup", 9.0, 0.0)) if k in (first, LIFTED) else row for k, row in enumerate(base.rollout.touches))
        made = candidate(replace(base.rollout, opening=np.full(COUNT, 0.06), touches=rows, lines=lines))
        assert (said(Collision(), allowing("1.Grasping", pair("block", "cup"), made)) == []) is passes


def test_the_limit_of_the_task_that_runs_comes_before_that_of_the_one_that_moves() -> None:
    """The block rolls on the shelf while the arm is parked, and knocks at the floor, which both tasks let it touch."""
    base = good().rollout
    assert base is not None
    rolls = base.poses["block"].copy()
    rolls[LANDED:, 0] += np.arange(COUNT - LANDED) * 0.01
    rows = tuple((*row, Touch("cup", "block", 40.0, 0.0)) if k == 85 else row for k, row in enumerate(base.touches))
    made = good(poses={**base.poses, "block": rolls}, touches=rows)
    for runs, let_go, passes in ((50.0, 10.0, True), (10.0, 50.0, False)):
        both = allowing("4.ParkingArms", pair("block", "cup", force=runs), made)
        both = allowing("3.Placing/PuttingDown", pair("block", "cup", force=let_go), both)
        assert (said(Collision(), both) == []) is passes


@pytest.mark.parametrize("sample", [LIFTED - 1, LANDED])
def test_standing_is_no_pressing(sample: int) -> None:
    """The floor bears the block however hard the pads push it down, as long as they held it nowhere else."""
    assert said(Collision(), touching([sample], Touch("floor" if sample < LIFTED else "shelf", "block", 300.0, 0.0))) == []


@pytest.mark.parametrize(("hollow", "lies_there", "passes"), [(True, True, True), (True, False, False), (False, True, False)])
def test_what_is_brought_into_a_container_may_touch_what_lies_in_there(hollow: bool, lies_there: bool, passes: bool) -> None:
    """Siblings that fail: the cup is held over the container by somebody else, and the shelf is no container."""
    box = replace(SHELF, features=(Feature("inside", "cram:Cavity", Pose(), {"width": 0.2, "depth": 0.2, "height": 0.1}),))
    found = touching(range(66, 68), Touch("block", "cup", 10.0, 0.0))
    run = found.rollout
    assert run is not None
    things = tuple(box if t.name == "shelf" and hollow else t for t in run.world.things)
    apart = tuple(tuple(t for t in row if {t.a, t.b} != {"shelf", "cup"}) for row in run.touches)
    rollout = replace(run, world=replace(run.world, things=things), touches=run.touches if lies_there else apart)
    assert only(Collision(), replace(found, rollout=rollout)).passed is passes


# What sleeps

STANDS = Touch("shelf", "cup", WEIGHT, WEIGHT)


def sleeping(rows: dict[range, tuple[Touch, ...]], more: dict[int, tuple[Touch, ...]] | None = None) -> Candidate:
    """The candidate, in whose run these touches are of what sleeps at some samples; the cup stands on the shelf awake at all others."""
    base = good().rollout
    assert base is not None
    asleep = [next((still for when, still in rows.items() if k in when), ()) for k in range(COUNT)]
    awake = [tuple(t for t in row if (t.a, t.b) != ("shelf", "cup")) for row in base.touches]
    awake = [row if asleep[k] else (*row, STANDS) for k, row in enumerate(awake)]
    touches = tuple((*(more or {}).get(k, ()), *awake[k], *asleep[k]) for k in range(COUNT))
    return good(touches=touches, asleep=tuple(asleep))


def as_if_awake(of: Candidate) -> Candidate:
    assert of.rollout is not None
    return replace(of, rollout=replace(of.rollout, asleep=()))


LEANS = Touch("cup", "block", 9.0, 0.0)
NOTED, NEW = (Touch("shelf", "cup", WEIGHT, WEIGHT),), (Touch("shelf", "cup", WEIGHT, WEIGHT), Touch("cup", "ghost", 9.0, 0.0))


@pytest.mark.parametrize(("rows", "more", "count"), [
    ({range(0, COUNT): NOTED}, {}, 0),
    ({range(5, 20): NOTED, range(20, COUNT): NEW}, {}, COUNT - 20),  # more falls asleep, and touches what it may not
    ({range(5, COUNT): NEW}, {}, COUNT - 5),  # and goes on doing so
    ({range(5, COUNT): NEW[1:]}, {}, COUNT - 5),
    ({range(5, 60): NOTED}, {}, 0),  # what wakes goes on standing there
    ({range(5, COUNT): NOTED}, {60: (LEANS,), 61: (LEANS,)}, 2),  # what is awake is judged meanwhile
    ({range(5, COUNT): NOTED}, {3: (LEANS,)}, 1),
])  # fmt: skip
def test_what_sleeps_is_judged_as_if_it_were_awake(
    rows: dict[range, tuple[Touch, ...]], more: dict[int, tuple[Touch, ...]], count: int
) -> None:
    made = sleeping(rows, more)
    found = [(b.sample, b.one, b.other, b.force) for b in bumps(made)]
    assert found == [(b.sample, b.one, b.other, b.force) for b in bumps(as_if_awake(made))]
    assert len(found) == count


def test_what_is_taken_stood_on_what_it_slept_on() -> None:
    """It wakes as the pads touch it, rattles off what it stands on at the same time, and may touch that until it is lifted."""
    base = good().rollout
    assert base is not None
    floor = (Touch("floor", "block", 9.0, WEIGHT),)
    free = [tuple(t for t in row if "floor" not in (t.a, t.b)) for row in base.touches]
    touches = tuple((*free[k], *(() if TAKEN <= k < TAKEN + 2 or k >= LIFTED else floor)) for k in range(COUNT))
    asleep = tuple(floor if 1 <= k < TAKEN else () for k in range(COUNT))
    lifting = allowing("1.Grasping", Allowance(frozenset({frozenset({HAND, "block"})}), carries_on=True), good())
    made = replace(lifting, rollout=replace(base, touches=touches, asleep=asleep))
    assert said(Collision(), made) == said(Collision(), as_if_awake(made)) == []
