"""Every validator refuses something that no other does: a run or a program that is good, but for one thing.

Runs are written by hand (``short_runs``) and read by the detection that also reads demonstrations; all validators are asked of each.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers.edited import engine
from helpers.short_runs import COUNT, HANDOVERS, LEFT, LINES, OPENED, candidate, good, posed, shifted, touching, track
from msgspec.structs import replace

from cramlite.engine.proof.proof import findings_of
from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Action, Floats, MoveJoints, Object, Pose, Rollout, SetGripper, Touch, World
from cramlite.planning.goal_literals import literals_of_goals
from cramlite.plugin import Candidate
from cramlite_plugins.objects.vessels import bowl, jug
from cramlite_plugins.robots.ur5e import UR5E


def ran(of: Candidate) -> Rollout:
    assert of.rollout is not None
    return of.rollout


def refused(made: Candidate) -> set[str]:
    """The validators that object to a candidate, each asked by itself: those of its program and those of its run."""
    knowledge, rollout = engine().knowledge, ran(made)
    episode = knowledge.episodes.detect(rollout, "p")
    episode = replace(episode, extras={**episode.extras, "park": np.array(UR5E.home)})
    read = replace(made, episode=episode, rules=tuple(knowledge.rules))
    asked = {v.name: findings_of(read, knowledge, rollout=v.cost == "rollout", only=[v.name]) for v in knowledge.validators}
    return {name for name, findings in asked.items() if any(not f.passed for f in findings)}


def swept() -> Candidate:
    """A joint jumps by 0.5 rad for a sample."""
    joints = ran(good()).joints.copy()
    joints[40, 1] += 0.5
    return good(joints=joints)


def stretched() -> Candidate:
    """The arm passes through where it lies straight, and must keep a distance from that."""
    share = np.interp(range(COUNT), [0, 40, 50, COUNT - 10], [1.0, 0.0, 0.0, 1.0])[:, None]
    made = good(joints=share * UR5E.home)
    return replace(made, robot=replace(made.robot, conditioning=0.05))


def felt(newtons: float) -> Floats:
    force = np.zeros(COUNT)
    force[40] = newtons
    return force


def weakly_held() -> Candidate:
    """The fingers are told to close with 1 N, which does not carry the block; they close further when they lost it."""
    opening = ran(good()).opening.copy()
    opening[OPENED - 1 : OPENED + 2] = 0.0
    made = replace(good(opening=opening), robot=replace(UR5E, gripper=replace(UR5E.gripper, force=(1.0, 235.0))))
    return stepping(made, SetGripper(0.0, 0.05, 1.0, origin="1.Grasping/close"))


def stepping(made: Candidate, *steps: MoveJoints | SetGripper) -> Candidate:
    return replace(made, program=replace(made.program, steps=steps))


def moving(*joints: float) -> Candidate:
    """The program has one motion, to those joint positions."""
    return stepping(good(), MoveJoints((joints,), 1.0, 1.4, origin="2.PickingUp/lift"))


def wanting(goal: str) -> Candidate:
    made, knowledge = good(), engine().knowledge
    return replace(made, goal=literals_of_goals([goal], symbolic_world(made.world, knowledge.taxonomy), knowledge))


def contained(in_bowl: int, in_jug: int, **parameters: float) -> Candidate:
    """A run at whose end some of 20 grains are in a bowl, some in a jug, and the rest beside both."""
    made, old = good(), ran(good())
    full, empty = jug("jug", Pose((0.2, 0.5, 0.051)), grains=20), bowl("bowl", Pose((0.2, 0.8, 0.026)))
    grains = np.tile(np.array(full.pose.position), (COUNT, 20, 1)).astype(float)
    grains[-1, : 20 - in_jug] = empty.pose.position
    grains[-1, in_bowl : 20 - in_jug] = (0.0, 0.9, 0.0)
    world = World((*old.world.things, full, empty), old.world.robots)
    poses = {**old.poses, **{t.name: track((0, t.pose.position)) for t in (full, empty)}}
    poured = candidate(replace(old, world=world, poses=poses, grains={"jug": grains}))
    roles = {"Source": Object("s", entity="jug"), "Destination": Object("d", entity="bowl")}
    return replace(poured, actions=(*made.actions, Action("5.Pouring", "soma:Pouring", roles, parameters=parameters)))


def taken_for_another() -> Candidate:
    """The block is a jug where the program ran."""
    old = ran(good())
    things = tuple(replace(t, type="cram:Jug") if t.name == "block" else t for t in old.world.things)
    return replace(good(world=replace(old.world, things=things)), world=old.world)


def not_parked() -> Candidate:
    """The arm ends elsewhere than at its park position."""
    joints = ran(good()).joints + np.linspace(0.0, 0.5, COUNT)[:, None] * [1, 0, 0, 0, 0, 0]
    return good(joints=joints)


def hurried() -> Candidate:
    """The hand goes up by 0.2 m in a sample, after it let go."""
    hand = ran(good()).poses["effector"].copy()
    hand[90:, 2] += 0.2
    return posed(effector=hand)


def fragile() -> Candidate:
    """The gripper is told to press a block with 235 N that bears 80 N."""
    grip = np.where(ran(good()).opening < 0.08, 235.0, 0.0)
    made = good(grip=grip)
    things = tuple(replace(t, max_grip_force=80.0) if t.name == "block" else t for t in made.world.things)
    return replace(made, world=replace(made.world, things=things))


def unwatched() -> Candidate:
    """The text lacks the start check of the one that it was edited from."""
    made = good()
    assert made.code is not None
    checked = made.code.text + "\n  check_start(start, 0.01)\n  # ---- 1.Grasping ----\n"
    return replace(made, proven=replace(made.code, text=checked))


def let_go_elsewhere() -> Candidate:
    """The plan lets go of the block as it lifts it."""
    return replace(good(), handovers=(HANDOVERS[0], replace(HANDOVERS[1], by="2.PickingUp/lift")))


def out_of_order() -> Candidate:
    """The program parks the fingers before it lifts them."""
    fingers = [SetGripper(0.085, 0.05, 20.0, origin=origin) for origin in ("4.ParkingArms/move", "2.PickingUp/lift")]
    return stepping(good(), *fingers)


REFUSES: dict[str, tuple[Callable[[], Candidate], set[str]]] = {
    "bystanders": (lambda: shifted((0.02, 0, 0), "cup", 40), set()),
    "poured": (lambda: contained(0, 20), {"task_rules"}),
    "spilled": (lambda: contained(12, 0, share=0.5), {"task_rules"}),
    "goal": (lambda: wanting("block on floor"), set()),
    "grip_strength": (weakly_held, set()),
    "joint_limits": (lambda: moving(0.0, 0.0, 0.0, 0.0, 0.0, 7.0), {"program_safety", "steps"}),
    "joint_speeds": (swept, set()),
    "singularities": (stretched, set()),
    "execution": (
        lambda: good(outcome="halted", reason="no contact", lines=np.where(np.arange(COUNT) < 89, LINES, 0.0)),
        set(),
    ),
    "collision": (lambda: touching(range(40, 45), Touch("cup", LEFT, 9.0, 0.0)), set()),
    "force_peak": (lambda: good(force=felt(61.0)), set()),
    "commanded_force": (lambda: good(commanded=felt(61.0)), set()),
    "grasp_slip": (lambda: shifted((0, 0, -0.014), "block", 40, OPENED), set()),
    "end_state": (lambda: touching(range(COUNT - 1, COUNT), without=lambda t: {t.a, t.b} == {"block", "shelf"}), set()),
    "task_rules": (not_parked, set()),
    "recognised": (taken_for_another, set()),
    "program_safety": (lambda: moving(0.0, 0.0, 0.0, 0.0, 0.0, float("nan")), {"steps"}),
    "tool_speed": (hurried, set()),
    "payload": (lambda: good(payload=np.full(COUNT, 4.0)), set()),
    "grip_limits": (fragile, set()),
    "safeguards": (unwatched, set()),
    "tracks": (let_go_elsewhere, set()),
    "steps": (out_of_order, set()),
}
"""Validator -> what it refuses, and who else does: no code of a pouring ran, joint limits are among the rules of every program, and a
motion to where no arm comes is not carried out."""


def test_the_run_as_it_is_is_refused_by_none() -> None:
    assert refused(good()) == set()
    assert refused(contained(20, 0)) == {"task_rules"}  # a run in which nothing was poured


def test_every_validator_is_asked_here() -> None:
    assert {v.name for v in engine().knowledge.validators} == REFUSES.keys()


@pytest.mark.parametrize("name", REFUSES)
def test_every_validator_refuses_what_is_its_own(name: str) -> None:
    made, others = REFUSES[name]
    assert refused(made()) == {name, *others}
