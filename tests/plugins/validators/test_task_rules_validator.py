"""Each task is judged by its rule, over its own interval: which must exist, begin as asked, and end as asked."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
import pytest
from helpers.short_runs import COUNT, LANDED, LEFT, LIFTED, OPENED, ORIGINS, RIGHT, TAKEN, WEIGHT, good, touching
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Action, AnyStep, Finding, MoveJoints, Object, Rollout, Touch
from cramlite.plugin import Candidate, Segment, Timeline
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.validators.postconditions import NO_STEPS, TaskRules, _as_many, _asked, _ends, _felt, _ways
from cramlite_plugins.validators.task_times import Span

BLOCK, SHELF = Object("it", entity="block"), Object("place", entity="shelf")


@cache
def knowledge() -> Any:
    return Engine().knowledge


def read(candidate: Candidate) -> Candidate:
    """The candidate with its run read as an episode, by the detection that also reads demonstrations."""
    assert candidate.rollout is not None
    episode = knowledge().episodes.detect(candidate.rollout, "p")
    episode = replace(episode, extras={**episode.extras, "park": np.array(UR5E.home)})
    return replace(candidate, episode=episode, rules=tuple(knowledge().rules))


def judged(candidate: Candidate) -> dict[str, Finding]:
    """What is found of each task and part of a run."""
    return {f.origin: f for f in TaskRules().check(read(candidate))}


def wrong(candidate: Candidate) -> dict[str, str]:
    return {origin: f.reason for origin, f in judged(candidate).items() if not f.passed}


def acting(*actions: Action, of: Candidate | None = None) -> Candidate:
    return replace(of or good(), actions=actions, parts=())


def stepped(*origins: str, of: Candidate | None = None) -> Candidate:
    """The candidate, whose program has a step of each origin."""
    made = of or good()
    steps: tuple[AnyStep, ...] = tuple(MoveJoints((UR5E.home,), 1.0, 1.4, origin=o) for o in origins)
    return replace(made, program=replace(made.program, steps=steps))


def ran(of: Candidate) -> Rollout:
    assert of.rollout is not None
    return of.rollout


def test_the_run_as_it_is_passes_task_by_task_parts_first() -> None:
    found = judged(stepped(*ORIGINS.values()))
    assert list(found) == ["1.Grasping", "2.PickingUp", "3.Placing/PuttingDown", "3.Placing/Releasing", "3.Placing", "4.ParkingArms"]
    assert all(f.passed for f in found.values())
    assert found["1.Grasping"].reason == "1.Grasping: grasps(Gripper, Patient)"
    assert found["4.ParkingArms"].reason == "4.ParkingArms: effector(Agent) and arm_moves() and not collides(_, _) and parked()"


# Before, during, after


def test_after_grasping_it_is_held() -> None:
    one = touching(range(COUNT), without=lambda t: RIGHT in (t.a, t.b))
    assert wrong(one)["1.Grasping"] == "after 1.Grasping 'grasps(Gripper, Patient)' does not hold (Patient = block)"


def test_before_putting_down_it_is_held_and_stands_nowhere() -> None:
    standing = touching(range(LIFTED - 1, LANDED), Touch("floor", "block", WEIGHT, WEIGHT))
    said = wrong(standing)
    assert "after 2.PickingUp 'not supports(_, Locatum)' does not hold" in said["2.PickingUp"]
    assert "before 3.Placing/PuttingDown 'not supports(_, Locatum)' does not hold" in said["3.Placing/PuttingDown"]


def test_after_putting_down_it_touches_its_place() -> None:
    nowhere = touching(range(LANDED, COUNT), without=lambda t: {t.a, t.b} == {"block", "shelf"})
    said = wrong(nowhere)
    assert set(said) == {"3.Placing/PuttingDown", "3.Placing/Releasing", "3.Placing"}
    assert "after 3.Placing 'touches(Locatum, Relatum)' does not hold (Locatum = block, Relatum = shelf)" in said["3.Placing"]


def ways_of(start: float, end: float) -> list[tuple[float, float, float, float]]:
    """Before, from, to and after, of each way of taking the code of a task [s]; states change at 0.5, 1.3, 3.25 and 3.5 s."""
    timeline = Timeline(read(good()).episode, knowledge().taxonomy)  # type: ignore[arg-type]
    found = [(w["pre"].start, w["run"].start, w["run"].end, w["post"].start) for w in _ways(timeline, start, end)]
    return [(round(a, 6), round(b, 6), round(c, 6), round(d, 6)) for a, b, c, d in found]


def test_a_short_task_is_taken_as_it_ran_with_moments_before_it() -> None:
    assert ways_of(3.6, 4.0) == [(before, 3.6, 4.0, 4.0) for before in (3.6, 3.5, 3.25, 3.0, 3.6)]
    assert ways_of(0.3, 0.6) == [(before, 0.3, 0.6, 0.6) for before in (0.3, 0.0, 0.0, 0.3)][: len(ways_of(0.3, 0.6))]


def test_a_longer_one_also_later_with_its_effects_or_from_a_change_on() -> None:
    found = ways_of(1.0, 3.6)
    spans = list(dict.fromkeys((b, c, d) for _, b, c, d in found))
    assert spans == [(1.0, 3.6, 3.6), (1.2, 3.6, 3.6), (1.0, 3.8, 3.8), (1.0, 3.55, 3.55), (1.3, 3.6, 3.6), (3.25, 3.6, 3.6)]
    assert [a for a, b, c, _ in found if (b, c) == (1.0, 3.6)] == [1.0, 0.5, 0.4, 1.0]
    assert [a for a, b, c, _ in found if (b, c) == (1.2, 3.6)] == [1.0, 0.5, 0.4, 1.2]
    assert [a for a, b, c, _ in found if (b, c) == (3.25, 3.6)] == [3.25]


def test_what_is_asked_for_before_may_have_ended_in_the_moments_before() -> None:
    """Fingers that let go leave the block before Releasing begins, by up to 0.6 s."""
    for early, passes in ((6, True), (20, False)):
        opened = touching(range(OPENED - early, COUNT), without=lambda t: bool({LEFT, RIGHT} & {t.a, t.b}))
        assert ("3.Placing/Releasing" not in wrong(opened)) is passes, early


def test_all_through_its_run_the_arm_moves() -> None:
    hand = ran(good()).poses["effector"].copy()
    hand[79:] = hand[79]
    poses = {**ran(good()).poses, "effector": hand, LEFT: hand, RIGHT: hand}
    found = wrong(good(poses=poses))
    assert "during 4.ParkingArms 'arm_moves()' does not hold" in found["4.ParkingArms"]


def test_after_parking_it_is_parked() -> None:
    joints = np.tile(UR5E.home, (COUNT, 1))
    joints[:, 2] += 0.1
    assert "after 4.ParkingArms 'parked()' does not hold" in wrong(good(joints=joints))["4.ParkingArms"]


# What ran


def test_a_task_none_of_whose_code_ran_was_not_executed() -> None:
    lines = np.where(ran(good()).lines >= 9, 7, ran(good()).lines)
    found = wrong(stepped(*ORIGINS.values(), of=good(lines=lines)))
    assert found == {"4.ParkingArms": "4.ParkingArms was not executed: none of the code of its 1 steps ran"}


def test_a_part_none_of_whose_code_ran_was_not_executed() -> None:
    lines = np.where(ran(good()).lines == 7, 5, ran(good()).lines)
    found = wrong(stepped(*ORIGINS.values(), "3.Placing/Releasing/payload", of=good(lines=lines)))
    assert found["3.Placing/Releasing"] == "3.Placing/Releasing was not executed: none of the code of its 2 steps ran"


def test_what_the_run_decides_about_may_be_left_out() -> None:
    """No step of the program has its name: the branch was not taken."""
    lines = np.where(ran(good()).lines == 7, 5, ran(good()).lines)
    found = judged(stepped("3.Placing/PuttingDown/lower", of=good(lines=lines)))
    assert found["3.Placing/Releasing"].passed or "was not executed" not in found["3.Placing/Releasing"].reason


def test_a_program_that_ended_before_is_judged_as_far_as_it_came() -> None:
    lines = np.where(np.arange(COUNT) >= 50, 0, ran(good()).lines)
    short = good(lines=lines, outcome="halted")
    assert list(judged(short)) == ["1.Grasping", "2.PickingUp"]
    assert len(judged(good(lines=lines))) == 6


# What needed no steps


def test_a_task_without_steps_is_judged_by_what_it_asks_for_afterwards() -> None:
    done = Action("3b.Releasing", "soma:Releasing", {"Locatum": BLOCK, "Relatum": SHELF})
    found = judged(acting(*good().actions[:3], done, good().actions[3]))["3b.Releasing"]
    assert found.passed
    assert found.reason.startswith(f"3b.Releasing: nothing was left to do, {NO_STEPS}; afterwards: not grasps(Gripper, _) and touches(")
    elsewhere = Action("3b.Releasing", "soma:Releasing", {"Locatum": BLOCK, "Relatum": Object("o", entity="floor")})
    lacks = judged(acting(*good().actions[:3], elsewhere))["3b.Releasing"]
    assert not lacks.passed and "after 3b.Releasing 'touches(Locatum, Relatum)' does not hold" in lacks.reason


def test_it_is_judged_at_the_moment_between_the_tasks_around_it() -> None:
    held = Action("2b.Grasping", "soma:Grasping", {"Patient": BLOCK})
    for place, passes in ((2, True), (4, False)):
        actions = list(good().actions)
        actions.insert(place, held)
        assert judged(acting(*actions))["2b.Grasping"].passed is passes, place


def test_where_no_code_came_before_nothing_was_done_at_all() -> None:
    first = Action("0.ParkingArms", "soma:ParkingArms")
    found = judged(acting(first, *good().actions))["0.ParkingArms"]
    assert not found.passed and "during 0.ParkingArms 'arm_moves()' does not hold" in found.reason
    later = Action("3b.ParkingArms", "soma:ParkingArms")
    assert judged(acting(*good().actions[:3], later, good().actions[3]))["3b.ParkingArms"].passed


# What the task before did already


def repeated(task: str, roles: dict[str, Object]) -> Finding:
    """Releasing as an action of its own behind Placing, whose last part did it."""
    made = good()
    again = Action("4.Releasing", task, roles)
    actions = (*made.actions[:3], again)
    code = replace(made.code, origins={**ORIGINS, 9: "4.Releasing/open"})  # type: ignore[type-var]
    return judged(replace(made, actions=actions, code=code))["4.Releasing"]


def test_what_the_last_part_of_the_task_before_did_cannot_be_done_again() -> None:
    found = repeated("soma:Releasing", {"Locatum": BLOCK, "Relatum": SHELF})
    assert found.passed and "nothing was left to do, 3.Placing/Releasing did it already; afterwards: not grasps" in found.reason


def test_unless_it_was_another_task_or_with_other_things() -> None:
    for roles in ({"Locatum": BLOCK, "Relatum": Object("o", entity="cup")}, {"Locatum": Object("o", entity="cup"), "Relatum": SHELF}):
        found = repeated("soma:Releasing", roles)
        assert not found.passed and "does not hold" in found.reason
    other = repeated("soma:Placing", {"Locatum": BLOCK, "Relatum": SHELF})
    assert not other.passed and "before 4.Releasing 'not supports(_, Locatum)' does not hold" in other.reason


def test_nor_the_task_before_the_one_before() -> None:
    made = good()
    again = Action("5.Releasing", "soma:Releasing", {"Locatum": BLOCK, "Relatum": SHELF})
    code = replace(made.code, origins={**ORIGINS, 8: "4.ParkingArms/move", 9: "5.Releasing/open"})  # type: ignore[type-var]
    lines = np.where((ran(made).lines == 9) & (np.arange(COUNT) < 85), 8, ran(made).lines)
    found = judged(replace(good(lines=lines), actions=(*made.actions, again), code=code))
    assert not found["5.Releasing"].passed and "before 5.Releasing" in found["5.Releasing"].reason


# Rules


def test_a_task_without_a_rule_is_judged_by_its_trace_alone() -> None:
    made = good()
    free = replace(made.actions[3], task="x:Unknown")
    assert "4.ParkingArms" not in judged(replace(made, actions=(*made.actions[:3], free)))


def test_the_condition_that_is_said_is_the_one_of_the_way_that_came_furthest() -> None:
    """In no way of taking Placing is the block held before; of what it asks for then, the effector is there."""
    one = touching(range(COUNT), without=lambda t: RIGHT in (t.a, t.b))
    assert wrong(one)["3.Placing"].startswith("before 3.Placing 'grasps(Gripper, Locatum)' does not hold")


def test_who_holds_something_takes_nothing_else() -> None:
    """The gripper is no role of Grasping: that it holds nothing is asked all the same."""
    made = good()
    again = replace(made.actions[1], task="soma:Grasping", roles={"Patient": BLOCK})
    found = wrong(replace(made, actions=(made.actions[0], again, *made.actions[2:])))
    assert found == {"2.PickingUp": "before 2.PickingUp 'not grasps(Gripper, _)' does not hold (Patient = block): it held from 0.00 to "
                                    "0.40 s, from 3.50 to 5.00 s; 2.PickingUp ran from 1.25 to 2.45 s"}  # fmt: skip


def test_what_a_task_finds_done_is_no_fault_of_its_program() -> None:
    """That the effect does not hold before tells when a person did it."""
    left_out = []
    for rule in knowledge().rules:
        after = {f"not {c.text}" for c in rule.clauses if c.phase == "post"}
        action = Action("1.X", rule.task, dict.fromkeys(rule.roles, BLOCK))
        for clause in rule.clauses:
            asked = _asked(clause, action, rule)
            assert asked is not (clause.phase == "pre" and clause.text in after), (rule.task, clause.text)
            left_out += [] if asked else [clause.text]
    assert left_out


def lifted(when: Iterable[int], *more: Touch) -> Candidate:
    """The candidate, whose block is off the floor at some samples, and maybe on something else."""
    return touching(when, *more, without=lambda t: {t.a, t.b} == {"floor", "block"})


def test_what_closing_fingers_lifted_off_is_not_lifted_off_again() -> None:
    assert not wrong(lifted(range(TAKEN, LIFTED)))


def test_but_what_stands_on_another_thing_or_was_never_held_is_no_such_thing() -> None:
    elsewhere = wrong(lifted(range(TAKEN, LIFTED), Touch("shelf", "block", WEIGHT, WEIGHT)))
    assert "before 2.PickingUp 'supports(Relatum, Locatum)' does not hold" in elsewhere["2.PickingUp"]
    unheld = touching(range(COUNT), without=lambda t: "block" in (t.a, t.b))
    assert "before 2.PickingUp 'grasps(Gripper, Locatum)' does not hold" in wrong(unheld)["2.PickingUp"]


def test_only_lifting_off_ends_something_that_may_have_ended_before() -> None:
    """What must be in the hand is never found ended."""
    found = {(r.task, c.text) for r in knowledge().rules for c in r.clauses if _ends(r, c)}
    assert found == {("soma:PickingUp", "supports(Relatum, Locatum)")}


def test_what_does_not_hold_of_a_role_that_nobody_fills_is_not_asked() -> None:
    found = []
    for rule in knowledge().rules:
        after = {f"not {c.text}" for c in rule.clauses if c.phase == "post"}
        empty = Action("1.X", rule.task, {name: Object("o") for name in rule.roles})
        skipped = [c for c in rule.clauses if not _asked(c, empty, rule) and c.text not in after]
        assert all(c.phase == "pre" and c.text.startswith("not ") for c in skipped)
        found += [c.text for c in skipped]
    assert "not supports(_, Locatum)" in found and "not grasps(Gripper, _)" not in found


def test_a_feature_without_a_shape_of_its_own_is_felt_as_its_thing() -> None:
    """A table's top has no shape; a peg has."""
    top = {"Locatum": BLOCK, "Relatum": Object("place", entity="shelf/top")}
    made = good()
    placed = replace(made.actions[2], roles=top)
    assert "3.Placing" not in wrong(replace(made, actions=(*made.actions[:2], placed, made.actions[3])))


def test_roles_that_a_rule_does_not_know_do_not_matter() -> None:
    made = good()
    more = replace(made.actions[0], roles={"Patient": BLOCK, "Gripper": Object("x", entity="cup")})
    assert "1.Grasping" not in wrong(replace(made, actions=(more, *made.actions[1:])))


@pytest.mark.parametrize(("more", "passes"), [(-1, True), (0, True), (0.5, False), (1, False)])
def test_what_a_rule_counts_is_reached_where_the_plan_says_how_much(more: float, passes: bool) -> None:
    rule = next(r for r in knowledge().rules if r.task == "cram:Shaking")
    base = ran(good())
    block = base.poses["block"].copy()
    block[30:48, 0] += 0.1 * np.sin(np.arange(18) * np.pi / 3)  # three times to and fro: six swings
    made = read(good(poses={**base.poses, "block": block}))
    assert made.episode is not None
    timeline = Timeline(made.episode, knowledge().taxonomy)

    def found(**parameters: Any) -> list[Finding]:
        action = Action("2.Shaking", rule.task, {"Patient": BLOCK}, parameters=parameters)
        return list(_as_many(rule, action, timeline, Span(1.25, 2.5), "task_rules"))

    (counted,) = found(swings=0.0)
    assert counted.value == 6 and counted.passed
    (one,) = found(swings=counted.value + more)
    assert one.passed is passes and one.origin == "2.Shaking" and one.limit == counted.value + more
    assert one.reason == f"2.Shaking: swings {counted.value:g}, {counted.value + more:g} are wanted"
    assert found() == found(swings="many") == found(times=9.0) == []


# Borders


def test_a_change_right_at_the_end_is_no_beginning_of_a_task() -> None:
    assert 3.7 - 0.2 == 3.5  # a change of state
    assert {b for _, b, _, _ in ways_of(1.0, 3.7)} == {1.0, 1.2, 1.3, 3.25}


def test_a_task_of_half_a_second_is_long_enough_to_be_taken_later() -> None:
    assert {b for _, b, _, _ in ways_of(3.55, 4.05)} == {3.55, 3.75}


def test_code_of_the_first_samples_is_something_that_came_before() -> None:
    lines = np.where(np.arange(COUNT) <= 1, 9, 0)
    found = judged(acting(good().actions[3], Action("5.ParkingArms", "soma:ParkingArms"), of=good(lines=lines)))["5.ParkingArms"]
    assert found.passed and NO_STEPS in found.reason


def test_one_of_twice_the_padding_is_not() -> None:
    assert {(b, c) for _, b, c, _ in ways_of(0.0, 0.4)} == {(0.0, 0.4)}


def test_a_part_without_steps_is_judged_after_the_parts_before_it() -> None:
    """No code says that Releasing opened the fingers: they are asked for where PuttingDown ended, and hold the block."""
    made = good()
    code = replace(made.code, origins={k: o for k, o in ORIGINS.items() if k != 7})  # type: ignore[type-var]
    lines = np.where(ran(made).lines == 7, 5, ran(made).lines)
    found = judged(replace(good(lines=lines), code=code))["3.Placing/Releasing"]
    assert found.passed and NO_STEPS in found.reason


def test_the_first_task_has_none_before_it_and_the_second_the_first() -> None:
    made = good()
    roles = {"Locatum": BLOCK, "Relatum": SHELF}
    code = replace(made.code, origins={**ORIGINS, 9: "4.Releasing/open"})  # type: ignore[type-var]
    again = Action("4.Releasing", "soma:Releasing", roles)
    second = judged(replace(made, actions=(made.actions[2], again), code=code))["4.Releasing"]
    assert second.passed and "3.Placing/Releasing did it already" in second.reason
    first = judged(replace(made, actions=(again, made.actions[2]), code=code))["4.Releasing"]
    assert "did it already" not in first.reason


def test_what_contacts_name_is_a_part_with_a_shape_or_the_whole() -> None:
    made = read(good())
    assert made.episode is not None
    timeline = Timeline(made.episode, knowledge().taxonomy)
    shelf = timeline.entities["shelf"]
    lid = replace(shelf, geoms=(*shelf.geoms, replace(shelf.geoms[0], part="lid")))
    shaped = replace(made.episode, entities=tuple(lid if e.name == "shelf" else e for e in made.episode.entities))
    phases = Timeline(shaped, knowledge().taxonomy).phases(Segment(1.0, 2.0))
    felt = {name: _felt(name, phases) for name in ("shelf", "shelf/lid", "shelf/top", "ghost", "ghost/top", "")}
    assert felt == {"shelf": "shelf", "shelf/lid": "shelf/lid", "shelf/top": "shelf", "ghost": "ghost", "ghost/top": "ghost/top", "": ""}
