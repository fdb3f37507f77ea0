"""Force of a grip at its borders: what just suffices and what just does not, each with its numbers."""

from __future__ import annotations

import math
from functools import cache

import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Filling, Gripper, Held, Pose, RobotMount, World
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.motions.grip_force import GripLoad, grip_force, grip_of, load
from cramlite_plugins.objects.furniture import drawer
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.robotiq_2f85 import GRIPPER
from cramlite_plugins.robots.ur5e import UR5E

PUSH = 2.5 * 25.0
"""What a motion in contact may push by before it stops, 25 N, with the margin [N]."""
RADIUS = math.hypot(*GRIPPER.pad) / 4


@cache
def context() -> Context:
    strong = replace(UR5E, payload=50.0)
    return Context(strong, RobotMount("arm", "ur5e"), {}, Engine().knowledge.taxonomy)


def grip(mass: float, friction: float = 0.9, lever: float = 0.0, *, bears: float | None = None, gripper: Gripper = GRIPPER) -> GripLoad:
    """A block between pads of the same friction, which is that of the pair."""
    thing = replace(block("block", Pose(), mass=mass), max_grip_force=bears)
    return GripLoad(thing, mass, friction, friction, lever, gripper)


def force(of: GripLoad, asked: float = 0.0) -> tuple[float, str]:
    return grip_force(of, asked, context(), ("it",), ("1.Grasping",))


def refused(of: GripLoad, asked: float = 0.0) -> Unresolvable:
    with pytest.raises(Unresolvable) as caught:
        force(of, asked)
    return caught.value


def test_what_is_too_heavy_for_the_arm_is_refused_before_its_grip() -> None:
    no = refused(grip(49.5))
    assert no.reason == "50.42 kg on the flange, gripper included, > 50 kg that 'ur5e' carries"
    assert no.numbers == pytest.approx({"load_kg": 49.5 + GRIPPER.mass, "payload_kg": 50.0})


# What a grip needs


def test_the_least_is_what_the_weight_takes_with_the_arms_acceleration_and_a_margin() -> None:
    one = grip(1.0, 0.5)
    assert one.friction == pytest.approx(0.5) and one.least == pytest.approx(2.5 * (9.81 + 1.2) / (2 * 0.5))
    assert grip(2.0, 0.5).least == pytest.approx(2 * one.least) and grip(1.0, 0.25).least == pytest.approx(2 * one.least)


def test_without_friction_no_force_holds_what_weighs_and_any_what_does_not() -> None:
    assert grip(0.01, 0.0).least == grip(0.01, 0.0).wanted == math.inf
    assert grip(0.0, 0.0).least == grip(0.0, 0.0).wanted == 0.0


@pytest.mark.parametrize("lever", [0.0, RADIUS, 0.05])
def test_wanted_is_also_what_the_weights_moment_and_a_push_take(lever: float) -> None:
    one = grip(1.0, 0.5, lever)
    assert one.wanted == math.ceil(one.least * (1 + lever / RADIUS) + PUSH / (2 * 0.5))


def test_a_grip_is_said_with_its_weight_and_both_frictions() -> None:
    assert str(replace(grip(1.5), pads=0.9, surface=0.05)) == "1.5 kg (14.7 N) on friction 0.0947 (pads 0.9, 'block' 0.05)"


def test_the_centre_of_mass_is_off_the_line_between_the_pads_by_its_way_across_them() -> None:
    world = World((block("block", Pose(), mass=0.5),))
    assert grip_of(Held("block", Pose((0.03, 0.5, 0.04)), 0.06), world, GRIPPER).lever == pytest.approx(0.05)


def test_what_is_on_it_and_in_it_hangs_on_the_pads_too() -> None:
    tray, cup = block("tray", Pose(), mass=0.5), replace(block("cup", Pose(), mass=0.25), filling=Filling(10, 0.005, 0.01))
    world = World((tray, cup, replace(block("air", Pose()), mass=None), drawer("rail", Pose(), "cabinet")))
    assert (load(tray), load(cup), load(world.thing("air")), load(world.thing("rail"))) == pytest.approx((0.5, 0.35, 0.0, 0.0))
    assert grip_of(Held("tray", Pose(), 0.06), world, GRIPPER).mass == pytest.approx(0.5)
    assert grip_of(Held("tray", Pose(), 0.06, carries=("cup",)), world, GRIPPER).mass == pytest.approx(0.85)
    assert grip_of(Held("rail", Pose(), 0.06, carries=("cup",)), world, GRIPPER).mass == 0.0  # the rail bears what is in it


# What it gets


def test_what_is_wanted_is_given_and_said_for_what() -> None:
    one = grip(0.5, 0.6)
    assert force(one) == (one.wanted, f"grip {one.wanted:g} N for {one}")


def test_the_gripper_gives_its_least_where_less_is_wanted() -> None:
    light = replace(grip(0.01), gripper=replace(GRIPPER, force=(50.0, 235.0)))
    assert light.wanted < 50.0 and force(light)[0] == 50.0 and force(replace(light, gripper=GRIPPER))[0] == light.wanted


def heaviest(limit: float, friction: float = 0.9) -> float:
    """The mass whose least force is a limit [kg]."""
    return limit * 2 * friction / (2.5 * (9.81 + 1.2))


@pytest.mark.parametrize(("share", "held"), [(0.999, True), (1.001, False)])
def test_the_least_is_what_the_gripper_can_press_at_most(share: float, held: bool) -> None:
    one = grip(share * heaviest(235.0))
    if held:
        assert force(one) == (235.0, f"grip 235 N instead of {one.wanted:g} N, the most of gripper 'robotiq_2f85' for {one}")
    else:
        assert refused(one).reason == (
            f"{one} needs 235 N on each pad, with a margin of 2.5 and 1.2 m/s2 of the arm, > 235 N, the most of gripper 'robotiq_2f85'"
        )


def test_a_refusal_has_its_numbers_and_what_it_depends_on() -> None:
    one = grip(20.0)
    no = refused(one)
    assert set(no.because) == {"it", "1.Grasping"}
    assert no.numbers == pytest.approx({"weight_N": 9.81 * 20, "friction": 0.9, "limit_N": 235.0, "needed_N": one.least})
    slippery = refused(grip(1.0, 0.0))
    assert slippery.reason.startswith("no grip force holds 1 kg (9.8 N) on friction 0")
    assert slippery.numbers == pytest.approx({"weight_N": 9.81, "friction": 0.0, "limit_N": 235.0})


@pytest.mark.parametrize(("share", "held"), [(0.999, True), (1.001, False)])
def test_what_the_thing_bears_comes_before_what_the_gripper_can(share: float, held: bool) -> None:
    one = grip(share * heaviest(50.0), bears=50.0)
    if held:
        assert force(one)[0] == 50.0 and "N, the max_grip_force of 'block'" in force(one)[1]
    else:
        assert "> 50 N, the max_grip_force of 'block'" in refused(one).reason
    assert force(replace(one, thing=replace(one.thing, max_grip_force=500.0)))[0] > 50.0


def test_a_thing_that_bears_just_what_its_weight_needs_is_held() -> None:
    need = grip(5.0).least
    assert force(grip(5.0, bears=need))[0] == need
    assert "on each pad" in refused(grip(5.0, bears=math.nextafter(need, 0.0))).reason


@pytest.mark.parametrize(("bears", "held"), [(20.0, True), (19.9, False)])
def test_what_bears_less_than_the_gripper_presses_at_least_is_not_gripped(bears: float, held: bool) -> None:
    one = grip(0.1, bears=bears)
    if held:
        assert force(one)[0] == 20.0
    else:
        assert refused(one).reason == f"the gripper presses with 20 N at least, more than {bears:g} N: the max_grip_force of 'block'"
        assert refused(one).numbers == {"least_N": 20.0, "limit_N": bears} and set(refused(one).because) == {"it", "1.Grasping"}


def test_what_an_ontology_says_of_its_class_is_a_limit_too() -> None:
    glass = grip(1.0, bears=200.0)
    fragile = replace(glass, thing=replace(glass.thing, type="soma:Glass"))
    limit, why = force(fragile)
    assert limit < force(glass)[0] and "instead of" in why and "soma:Glass" in why
    assert force(replace(fragile, thing=replace(fragile.thing, max_grip_force=limit - 1.0)))[0] == limit - 1.0


# What was asked for


@pytest.mark.parametrize(("asked", "given"), [(20.0, True), (235.0, True), (19.9, False), (235.1, False)])
def test_a_force_that_is_asked_for_is_one_that_the_gripper_has(asked: float, given: bool) -> None:
    one = grip(0.1)
    if given:
        assert force(one, asked) == (asked, "")
    else:
        no = refused(one, asked)
        assert no.reason == f"a grip force of {asked:g} N is outside 20 .. 235 N of gripper 'robotiq_2f85'"
        assert no.because == ("1.Grasping",) and no.numbers == {"force_N": asked, "least_N": 20.0, "most_N": 235.0}


def test_a_force_that_is_asked_for_is_given_though_more_is_needed_and_no_more_than_the_thing_bears() -> None:
    heavy = grip(20.0)
    assert force(heavy, 100.0)[0] == 100.0
    soft = grip(0.1, bears=50.0)
    assert force(soft, 50.0) == (50.0, "") and force(soft, 51.0) == (50.0, "grip 50 N instead of 51 N, the max_grip_force of 'block'")


@pytest.mark.parametrize(("share", "doubted"), [(0.999, False), (1.001, True)])
def test_a_force_that_does_not_carry_the_weight_is_doubted(share: float, doubted: bool) -> None:
    """50 N on each of two pads carry 2 x 50 x 0.9 = 90 N."""
    weightless = replace(grip(1.0, 0.0), mass=0.0)
    assert force(weightless, 50.0) == (50.0, "")
    one = grip(share * 90.0 / 9.81)
    assert force(one, 50.0) == (50.0, f"grip 50 N, which carries 90.0 N: doubtful for {one}" if doubted else "")
