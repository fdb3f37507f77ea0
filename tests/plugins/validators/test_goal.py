"""The goal is judged on the run's end, literal by literal: things rest in physics, and the run's tracks are bent where it must fail."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Finding, Plan, Pose, RobotMount, Rollout, Thing, World
from cramlite.planning.goal_literals import literals_of_goals
from cramlite.plugin import Candidate
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.objects.controls import knob
from cramlite_plugins.simulation.objects.furniture import cabinet, drawer
from cramlite_plugins.simulation.objects.products_and_fixtures import basket, block, hanger, hung, product, table
from cramlite_plugins.simulation.objects.vessels import bottle, bowl, jug
from cramlite_plugins.simulation.recording.recorder import Recorder
from cramlite_plugins.validators.goal import Goal

KNOWLEDGE = Engine().knowledge
FLOOR = table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02))


def settled(*things: Thing, seconds: float = 1.0) -> Rollout:
    """A world that is left alone: how things lie after a second and a half."""
    compiled = compile_world(World((FLOOR, *things), ()), {}, hand=True)
    data, recorder = compiled.data(), Recorder(compiled, "hand")
    for _ in range(500):
        mujoco.mj_step(compiled.model, data)
    data.time = 0.0
    while data.time < seconds:
        mujoco.mj_step(compiled.model, data)
        recorder.observe(data)
    return recorder.rollout()


def judged(rollout: Rollout, *says: str) -> tuple[Finding, ...]:
    scene = symbolic_world(rollout.world, KNOWLEDGE.taxonomy)
    nothing: Any = None
    world = replace(rollout.world, robots=(RobotMount("arm", "ur5e"),))
    candidate = Candidate(
        Plan("p", (), ()), nothing, None, {}, nothing, (), nothing, world, (), KNOWLEDGE.taxonomy, rollout,
        KNOWLEDGE.episodes.detect(rollout, "run"), literals_of_goals(says, scene, KNOWLEDGE),
    )  # fmt: skip
    return tuple(Goal().check(candidate))


def moved(rollout: Rollout, by: tuple[float, float, float], *things: str) -> Rollout:
    """The same run, in which some things are carried along in its first third."""
    share = np.clip(3 * rollout.times / rollout.times[-1], 0.0, 1.0)[:, None]
    poses = {n: np.hstack([p[:, :3] + share * np.array(by), p[:, 3:]]) if n in things else p for n, p in rollout.poses.items()}
    return replace(rollout, poses=poses)


IN = (basket("basket", Pose((0.4, 0.3, 0.0))), block("tin", Pose((0.4, 0.3, 0.05))))
TWO = (block("tin", Pose((0.5, 0.1, 0.031))), block("cup", Pose((0.5, -0.05, 0.031))))


@pytest.mark.parametrize(
    ("things", "holds", "fails"),
    [
        (IN, "tin in basket", "tin on floor"),
        (TWO, "tin on floor", "tin held"),
        (TWO, "tin on floor left of cup", "tin on floor right of cup"),
        (TWO, "tin on floor near cup", "tin on floor behind cup"),
        (TWO, "tin off cup", "tin off floor"),
        ((cabinet("c", Pose((0.7, 0, 0.3))), drawer("d", Pose((0.7, 0, 0.3)), "c", opened=0.12)), "d open", "d closed"),
        ((cabinet("c", Pose((0.7, 0, 0.3))), drawer("d", Pose((0.7, 0, 0.3)), "c")), "d closed", "d open"),
    ],
)
def test_what_holds_at_the_end_is_reached_and_its_contrary_is_not(things: tuple[Thing, ...], holds: str, fails: str) -> None:
    reached, missed = judged(settled(*things), holds, fails)
    assert reached.passed and holds in reached.reason
    assert not missed.passed and f"'{fails}' is not reached" in missed.reason


def test_without_a_goal_nothing_is_said() -> None:
    assert judged(settled(*TWO)) == ()


def test_a_drawer_that_is_almost_open_is_not() -> None:
    carcass = cabinet("c", Pose((0.7, 0, 0.3)))
    for opened, enough in ((0.038, False), (0.042, True)):  # 20 % of 0.2 m are open
        (finding,) = judged(settled(carcass, drawer("d", Pose((0.7, 0, 0.3)), "c", opened=opened)), "d open")
        assert finding.passed is enough and f"open by {opened / 0.002:.0f} %" in finding.reason


def test_what_is_in_a_container_is_measured_where_that_then_is() -> None:
    still = settled(*IN)
    away = (0.0, -0.6, 0.0)
    assert judged(moved(still, away, "tin", "basket"), "tin in basket")[0].passed
    for left in ("tin", "basket"):
        (finding,) = judged(moved(still, away, left), "tin in basket")
        assert not finding.passed and "in the frame of 'basket'" in finding.reason


def test_what_lies_across_the_rim_is_over_the_basket_and_not_in_it() -> None:
    plank = block("plank", Pose((0.4, 0.3, 0.17)), size=(0.5, 0.04, 0.03))
    (finding,) = judged(settled(basket("basket", Pose((0.4, 0.3, 0.0)), size=(0.4, 0.3, 0.15)), plank), "plank in basket")
    assert finding.passed  # its middle is 15 mm over the rim: low enough to be in
    higher = moved(settled(IN[0], plank), (0, 0, 0.05), "plank")
    (finding,) = judged(higher, "plank in basket")
    assert not finding.passed and "'in_cavity(plank, basket)' does not hold" in finding.reason


def test_what_was_there_a_moment_ago_or_still_moves_is_not_there() -> None:
    still = settled(*IN)
    late = still.times > still.times[-1] - 0.2
    poses = {**still.poses, "tin": still.poses["tin"] + np.outer(late, (0.0, 0.0, 1.0, 0, 0, 0, 0))}
    (gone,) = judged(replace(still, poses=poses), "tin in basket")
    assert not gone.passed and "it held from" in gone.reason
    for speed, rests in ((0.03, True), (0.06, False)):
        slid = still.poses["tin"] + np.outer(still.times * speed, (1.0, 0, 0, 0, 0, 0, 0))
        (finding,) = judged(replace(still, poses={**still.poses, "tin": slid}), "tin in basket")
        assert finding.passed is rests and ("at rest" in finding.reason) is not rests


def test_a_thing_hangs_where_its_hole_is_on_the_peg() -> None:
    hook = hanger("hook", Pose((0.87, 0, 0.45)))
    box = product("box", Pose(), size=(0.06, 0.05, 0.10), hole_diameter=0.009)
    hangs, stands = (settled(hook, replace(box, pose=p)) for p in (hung(box, hook, depth=0.07), Pose((0.4, 0.2, 0.06))))
    assert judged(hangs, "box on hook")[0].passed
    assert not judged(stands, "box on hook")[0].passed and judged(stands, "box off hook")[0].passed


def test_poured_is_what_has_arrived_for_the_most_part() -> None:
    rollout = settled(jug("jug", Pose((0.4, 0.3, 0.1)), grains=20), bowl("bowl", Pose((0.6, -0.2, 0.06))), seconds=0.7)
    assert not judged(rollout, "jug poured into bowl")[0].passed  # nothing was poured

    def arrived(count: int) -> Finding:
        grains = rollout.grains["jug"].copy()
        grains[:, :count] = rollout.poses["bowl"][:, None, :3]
        carried = tuple(tuple(t for t in touches if "jug" not in t.a + t.b) for touches in rollout.touches)
        return judged(replace(rollout, grains={"jug": grains}, touches=carried), "jug poured into bowl")[0]

    assert arrived(18).passed, arrived(18).reason
    assert not arrived(17).passed and "17 of 20 grains" in arrived(17).reason


def turned(rollout: Rollout, thing: str, axis: tuple[float, float, float], degrees: float) -> Rollout:
    """The same run, in which a thing stands turned about an axis of the world all the time."""
    turn = Pose.from_rotvec((0, 0, 0), tuple(np.radians(degrees) * np.array(axis)))
    rows = [[*r[:3], *(turn * Pose((0, 0, 0), tuple(r[3:]))).quaternion] for r in rollout.poses[thing]]
    return replace(rollout, poses={**rollout.poses, thing: np.array(rows)})


TILTS = ((9.0, True), (11.0, False), (90.0, False))
"""Just inside what is upright, just outside, and lying [deg]."""


def test_upright_is_within_ten_degrees() -> None:
    still = settled(bottle("bottle", Pose((0.4, 0.0, 0.086))))
    for degrees, stands in TILTS:
        upright, denied = judged(turned(still, "bottle", (1, 0, 0), degrees), "bottle upright", "not bottle upright")
        assert upright.passed is stands and denied.passed is not stands, degrees
        (down,) = judged(turned(still, "bottle", (1, 0, 0), 180 + degrees), "bottle upside down")
        assert down.passed is stands and ("is not reached" in down.reason) is not stands


def test_facing_is_within_fifteen_degrees_seen_from_above() -> None:
    box, jar = product("box", Pose((0.4, 0.0, 0.085))), block("jar", Pose((0.4, -0.3, 0.04)))  # its front is -y
    still = settled(box, jar)
    for degrees, faces in ((0.0, True), (14.0, True), (16.0, False), (180.0, False)):
        (finding,) = judged(turned(still, "box", (0, 0, 1), degrees), "box facing jar")
        assert finding.passed is faces, (degrees, finding.reason)


def test_an_amount_is_met_within_a_twentieth_of_the_range() -> None:
    carcass = cabinet("c", Pose((0.7, 0, 0.3)))
    for opened, enough in ((0.12, True), (0.129, True), (0.112, True), (0.132, False), (0.108, False)):
        (finding,) = judged(settled(carcass, drawer("d", Pose((0.7, 0, 0.3)), "c", opened=opened)), "d open by 120 mm")
        assert finding.passed is enough, (opened, finding.reason)


def test_a_knob_is_on_from_a_fifth_of_its_range() -> None:
    for share, on in ((0.0, False), (0.19, False), (0.21, True), (1.0, True)):
        run = settled(knob("k", Pose((0.7, 0, 0.3)), turn=1.5, turned=1.5 * share))
        finding, denied, off = judged(run, "k turned on", "not k turned on", "k turned off")
        assert finding.passed is on and denied.passed is not on and off.passed is (share == 0.0)


def test_what_is_denied_must_not_hold() -> None:
    still = settled(*IN)
    out, inside = judged(still, "not tin on floor", "not tin in basket")
    assert out.passed and not inside.passed and "not in_cavity(tin, basket)" in inside.reason
