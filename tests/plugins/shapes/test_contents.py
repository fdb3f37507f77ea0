"""What vessels hold: grains in simulation are counted where they are, and volumes say what fits."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Belief, Filling, Floats, Pose, RobotMount, Rollout, Thing, World, initial_belief
from cramlite.model.run.rollout import load_rollout, save_rollout
from cramlite.plugin import UserError
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.locations.parameters import Tilting
from cramlite_plugins.locations.pour import radius, tilted
from cramlite_plugins.objects.products_and_fixtures import basket, block, table
from cramlite_plugins.objects.vessels import bowl, jug
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.bounds import lowest
from cramlite_plugins.shapes.contents import are_in_cavity, bulk, pouring_obstacle, volume, where
from cramlite_plugins.simulation.model.compile import Compiled, compile_world
from cramlite_plugins.simulation.recording.recorder import Recorder

FLOOR = table("floor", Pose())
JUG, BOWL = jug("jug", Pose((0.5, 0.2, 0.051)), grains=6), bowl("bowl", Pose((0.5, -0.2, 0.026)))


def _belief(*things: Thing) -> Belief:
    return initial_belief(World((FLOOR, *things), (RobotMount("arm", "ur5e"),)), "arm", UR5E.home, 0.085)


def _row(thing: Thing) -> Floats:
    return np.array([[*thing.pose.position, *thing.pose.quaternion]])


@pytest.mark.parametrize("vessel", [JUG, jug("j", Pose((0, 0, 0), (0.9, 0.3, 0.1, 0.2)), grains=40), BOWL], ids=str)
def test_a_filling_begins_inside(vessel: Thing) -> None:
    from cramlite_plugins.simulation.model.grains import layout

    full = vessel if vessel.filling else replace(vessel, filling=Filling(30, 0.005, 0.001))
    centres = np.array([layout(full)])
    assert centres.shape[1] == (full.filling.count if full.filling else 0)
    assert are_in_cavity(full, _row(full), centres).all()
    apart = np.linalg.norm(centres[0][:, None] - centres[0][None], axis=2) + np.eye(centres.shape[1])
    assert apart.min() >= 2 * (full.filling.radius if full.filling else 0.0)


def test_what_does_not_fit_or_has_no_cavity_is_refused_with_numbers() -> None:
    from cramlite_plugins.simulation.model.grains import layout

    with pytest.raises(UserError, match=r"jug.*500 balls of 10 mm do not fit into its cavity of 290 ml; \d+ do"):
        layout(jug("jug", Pose(), grains=500))
    with pytest.raises(UserError, match="no cram:Cavity"):
        layout(replace(block("b", Pose()), filling=Filling(1, 0.005, 0.001)))
    with pytest.raises(UserError, match=r"40 balls of 10 mm do not fit onto its surface of 100 x 80 mm; \d+ do"):
        layout(table("t", Pose(), (0.1, 0.08, 0.02), grains=40))


def test_grains_lie_scattered_on_a_plate() -> None:
    from cramlite_plugins.simulation.model.grains import layout

    plate = table("plate", Pose((0.4, 0.1, 0.2), (0.9, 0.0, 0.0, 0.3)), (0.2, 0.2, 0.02), grains=24)
    centres = plate.pose.inverse().apply(layout(plate))
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(24)
    assert apart.min() == pytest.approx(0.02) and centres[:, 2] == pytest.approx(0.005)


@examples(40)
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_inside_is_the_same_for_a_box_and_by_hand(x: float, y: float, z: float) -> None:
    thing = basket("b", Pose((0.3, 0.1, 0.2), (0.8, 0.0, 0.0, 0.6)), (0.12, 0.10, 0.08), 0.01)
    point = np.array([[thing.pose.apply((x, y, z))]])
    assert are_in_cavity(thing, _row(thing), point).item() == (abs(x) <= 0.05 and abs(y) <= 0.04 and 0.01 <= z <= 0.08)


def test_volumes_decide_what_overflows() -> None:
    cavity = BOWL.feature("cram:Cavity")
    assert cavity is not None and volume(cavity) == pytest.approx(math.pi * 0.064**2 * 0.044)
    assert JUG.filling is not None and bulk(JUG.filling) == pytest.approx(6 * 0.5236e-6 / 0.55, rel=1e-3)
    assert not pouring_obstacle(_belief(JUG, BOWL), "jug", "bowl")
    many = replace(BOWL, filling=Filling(590, 0.005, 0.001))
    assert pouring_obstacle(_belief(JUG, many), "jug", "bowl") == (
        "'bowl' would overflow: it holds 562 of 566 ml, and 6 ml are in 'jug'"
    )
    assert "'bowl' is empty" in pouring_obstacle(_belief(JUG, BOWL), "bowl", "jug")
    after = _belief(JUG, BOWL).related(("contains", "bowl", "jug"))
    assert pouring_obstacle(after, "jug", "bowl") == "'jug' is empty; its contents were poured into 'bowl'"


def _run(turned: float) -> tuple[Compiled, Rollout]:
    """The jug over the bowl, upright or turned over, let go for half a second; nothing holds it but its pose."""
    pose = Pose.from_rotvec((0.5, -0.2, 0.25), (turned, 0.0, 0.0))
    world = World((FLOOR, replace(JUG, pose=pose, mass=None), BOWL), (RobotMount("arm", "ur5e"),))
    compiled = compile_world(world, {"ur5e": UR5E})
    data, recorder = compiled.data(), Recorder(compiled)
    for _ in range(250):
        mujoco.mj_step(compiled.model, data)
        recorder.observe(data)
    return compiled, recorder.rollout()


def test_what_falls_out_of_one_vessel_is_counted_in_the_other(tmp_path: object) -> None:
    _, rollout = _run(math.pi)
    counts = where(rollout, "jug")
    assert (counts["jug"][0], counts["bowl"][0]) == (6, 0)
    assert (counts["jug"][-1], counts["bowl"][-1]) == (0, 6)
    states = detect(rollout, "e").of("state", ["soma:ContainmentState"])
    assert [s.roles["container"] for s in states] == ["jug", "bowl"]
    assert {s.roles["content"] for s in states} == {"contents_of_jug"}
    assert states[0].end <= states[1].start


def test_an_upright_vessel_keeps_what_is_in_it() -> None:
    _, rollout = _run(0.0)
    assert where(rollout, "jug")["jug"][-1] == 6
    assert [s.roles["container"] for s in detect(rollout, "e").of("state", ["soma:ContainmentState"])] == ["jug"]


def test_a_run_with_grains_is_read_back_as_it_was(tmp_path: object) -> None:
    _, rollout = _run(0.0)
    from pathlib import Path

    path = Path(str(tmp_path)) / "run.npz"
    save_rollout(rollout, path)
    assert np.array_equal(load_rollout(path, rollout.world).grains["jug"], rollout.grains["jug"])


def test_grains_are_no_part_of_planning_and_touch_nothing_in_the_record() -> None:
    compiled, rollout = _run(0.0)
    planning = compile_world(compiled.world, {"ur5e": UR5E}, planning=True)
    assert planning.things["jug"].grains == () and len(compiled.things["jug"].grains) == 6
    assert not any("grain" in t.a + t.b for touches in rollout.touches for t in touches)


@examples(30)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(0.5, 2.4), st.floats(0.01, 0.1))
def test_the_lip_stays_over_one_point_and_nothing_dips_below_the_rim(
    lip: float, heading: float, tilt: float, height: float
) -> None:
    cavity, opening = JUG.feature("cram:Cavity"), BOWL.feature("cram:Cavity")
    assert cavity is not None and opening is not None
    target = BOWL.pose * opening.pose
    edge = cavity.pose.apply((radius(cavity, lip) * math.cos(lip), radius(cavity, lip) * math.sin(lip), 0.0))
    poses = list(tilted(JUG, lip, heading, target, opening, Tilting(tilt, height)))
    points = np.array([p.apply(edge) for p in poses])
    assert np.ptp(points[:, :2], axis=0) == pytest.approx([0, 0], abs=1e-6)
    assert all(p.position[2] + lowest(JUG, p) >= target.position[2] + 0.0149 - 1e-9 for p in poses) or height < 0.015
    assert points[-1, 2] - target.position[2] >= height - 1e-9
    assert math.acos(np.clip(poses[-1].rotate((0, 0, 1))[2], -1, 1)) == pytest.approx(tilt, abs=1e-6)
    assert float(poses[-1].rotate((0, 0, 1))[:2] @ (math.cos(heading), math.sin(heading))) > 0
