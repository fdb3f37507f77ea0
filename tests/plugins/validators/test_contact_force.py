"""How hard a task may press on something: as it declares, as its motions end, or as any; and not where nothing is touched."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_runs import COUNT, OPENED, TAKEN, good, only, touching
from msgspec.structs import replace

from cramlite.model import AnyStep, Floats, ForceInsert, MoveUntilContact, Parallel, Pose, Touch, Wait, World
from cramlite.plugin import Candidate
from cramlite_plugins.validators.contact_force import task_forces
from cramlite_plugins.validators.physics import ForcePeak

ON_TOP = Touch("effector/body", "block", 54.0, -54.0)
ANY = 25.0 * 1.15


def felt(newtons: float, sample: int, candidate: Candidate) -> Candidate:
    """The candidate, in whose run so much is felt at one sample."""
    assert candidate.rollout is not None
    force: Floats = np.zeros(COUNT)
    force[sample] = newtons
    return replace(candidate, rollout=replace(candidate.rollout, force=force))


def moving(candidate: Candidate, *steps: AnyStep) -> Candidate:
    return replace(candidate, program=replace(candidate.program, steps=steps))


def guarded(force: float) -> MoveUntilContact:
    return MoveUntilContact((0.0, 0.0, -1.0), 0.01, force, 0.03, 9.0, origin="2.PickingUp/lower")


def inserted(limit: float) -> ForceInsert:
    return ForceInsert(Pose(), 8.0, 0.05, 0.02, limit, 9.0, origin="2.PickingUp/push")


@pytest.mark.parametrize(("newtons", "passes"), [(ANY - 0.01, True), (ANY + 0.01, False), (54.0, False)])
def test_what_was_let_go_of_is_pressed_no_harder_than_any_task_presses(newtons: float, passes: bool) -> None:
    found = only(ForcePeak(), felt(newtons, 85, touching(range(83, 88), ON_TOP)))
    assert (found.passed, found.origin) == (passes, "4.ParkingArms") and found.limit == pytest.approx(ANY)
    assert found.reason.endswith("limit 28.75 N of every task that declares none (25 N, plus 15% while the arm stops)")


@pytest.mark.parametrize(("sample", "passes"), [(85, True), (84, False), (83, False), (82, True)])
def test_what_is_felt_shortly_before_or_after_a_contact_is_of_it(sample: int, passes: bool) -> None:
    for met in (range(sample + 2, sample + 3), range(sample - 2, sample - 1)):
        near = touching(met, ON_TOP) if sample in (83, 84) else touching((sample + 3, sample - 3), ON_TOP)
        assert only(ForcePeak(), felt(50.0, sample, near)).passed is passes


def test_what_is_held_meets_things_for_the_hand() -> None:
    at = 40
    in_the_air, met = good(), touching(range(39, 42), Touch("block", "cup", 5.0, 0.0))
    assert only(ForcePeak(), felt(40.0, at, in_the_air)).passed and not only(ForcePeak(), felt(40.0, at, met)).passed


def test_pads_on_what_they_hold_meet_nothing() -> None:
    assert only(ForcePeak(), felt(40.0, 45, good())).limit == 60.0


@pytest.mark.parametrize(
    ("step", "most"),
    [
        (guarded(3.0), 25.0), (guarded(17.0), 25.0), (guarded(30.0), 37.5), (inserted(20.0), 25.0), (inserted(32.0), 32.0),
        (Parallel(((inserted(32.0),), (Wait(1.0),))), 32.0), (Wait(1.0, origin="2.PickingUp/rest"), 25.0),
    ],
)  # fmt: skip
def test_a_task_presses_as_its_own_motions_end(step: AnyStep, most: float) -> None:
    forces = task_forces(moving(good(), step))
    assert forces["2.PickingUp"].most == most and not forces["2.PickingUp"].declared
    assert forces["4.ParkingArms"].most == 25.0, "another task's motions are not its own"


def test_what_a_task_declares_is_above_its_motions() -> None:
    base = good()
    own = replace(base.allowances["2.PickingUp"], force=12.0)
    forces = task_forces(moving(replace(base, allowances={**base.allowances, "2.PickingUp": own}), inserted(32.0)))
    assert forces["2.PickingUp"] == (12.0, "of 2.PickingUp", True)


def test_a_force_of_its_own_holds_where_nothing_is_touched_too() -> None:
    base = felt(30.0, 55, touching(range(COUNT), without=lambda t: "shelf" in (t.a, t.b)))
    assert only(ForcePeak(), base).limit == pytest.approx(ANY) and only(ForcePeak(), base).origin == "3.Placing/PuttingDown"


def test_a_load_may_be_heavier_than_it_is_believed_to_be() -> None:
    at = TAKEN + 10
    light = touching(range(at - 1, at + 2), Touch("block", "cup", 5.0, 0.0))
    things = tuple(replace(t, mass=15.0) if t.name == "block" else t for t in light.world.things)
    heavy = replace(light, world=replace(light.world, things=things))
    things = tuple(replace(t, mass=None) if t.name == "block" else t for t in light.world.things)
    nothing = replace(light, world=replace(light.world, things=things))
    for one, most in ((light, ANY + 0.2 * 0.2 * 9.81), (heavy, ANY + 0.2 * 15.0 * 9.81), (nothing, ANY)):
        assert only(ForcePeak(), felt(most - 0.01, at, one)).passed and not only(ForcePeak(), felt(most + 0.01, at, one)).passed


def of(kind: str, name: str, world: World) -> World:
    return replace(world, things=tuple(replace(t, type=kind) if t.name == name else t for t in world.things))


@pytest.mark.parametrize(("newtons", "passes"), [(17.2, True), (17.3, False)])
def test_what_is_fragile_is_pressed_as_little_as_it_bears(newtons: float, passes: bool) -> None:
    pressed = felt(newtons, 85, touching(range(83, 88), ON_TOP))
    assert only(ForcePeak(), pressed).passed
    found = only(ForcePeak(), replace(pressed, world=of("soma:Glass", "block", pressed.world)))
    assert found.passed is passes and "block (soma:Glass) is a cram:FragileObject" in found.reason
    assert only(ForcePeak(), replace(pressed, world=of("soma:Glass", "cup", pressed.world))).passed, "nobody touches that"


def test_where_the_programs_limit_is_lower_that_holds() -> None:
    pressed = felt(22.0, OPENED + 15, touching(range(83, 88), ON_TOP))
    gentle = replace(pressed, program=replace(pressed.program, force_limit=20.0, force_limit_of="scenario"))
    assert not only(ForcePeak(), gentle).passed and only(ForcePeak(), gentle).limit == 20.0
