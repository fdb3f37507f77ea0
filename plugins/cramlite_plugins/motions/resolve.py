"""Motion designators become program steps: planned, checked, timed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from cramlite import (
    Answers,
    Belief,
    Context,
    Estimate,
    ForceMove,
    Grounding,
    Held,
    Motion,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Place,
    Pose,
    SetGripper,
    SetPayload,
    Unresolvable,
    Wait,
    ZeroSensor,
    hookimpl,
)  # fmt: skip

Found = Iterator[Grounding]
SPEED, ACCELERATION = 1.05, 1.4  # leading axis of movej: URScript's own defaults [rad/s, rad/s2]
LINE_SPEED, LINE_ACCELERATION = (
    0.10,
    0.5,
)  # of movel [m/s, m/s2]: a tenth of URScript's default 1.2 m/s2 and 0.25 m/s halved
SAME = 0.001, 0.01  # a pose is reached already within this [m, rad]
COMPLIANT_SPEED = 0.02  # of compliant axes [m/s]; faster oscillates against a stiff peg in simulation
PADS_SPEED = 0.10  # of the gripper's pads [m/s]: mid-range of the 2F-85's 20 to 150 mm/s
GRAVITY = 9.81
GOALS = 6  # nearest inverse solutions that a transfer may end at
COARSE = 0.025, 0.1  # steps of the quick look whether a line can follow [m, rad]; the line itself is checked finely


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    kinds: Mapping[str, Callable[[Motion, Belief, Context], Found]] = {
        "transfer": _transfer, "linear": _linear, "gripper": _gripper, "zero_sensor": _zero, "payload": _payload,
        "force_path": _force_path, "until_contact": _until_contact, "hold": _wait,
    }  # fmt: skip
    kind = kinds.get(motion.kind)
    return kind(motion, belief, context) if kind else None


def _place(motion: Motion, context: Context) -> Place:
    assert motion.to is not None
    return context.bindings[motion.to.name]  # type: ignore[no-any-return]


def _because(motion: Motion, context: Context) -> tuple[str, ...]:
    """A motion to a place fails because of that place, and of the grasp that it is made with."""
    grasps = tuple(k for k in context.bindings if k.startswith("grasp("))
    return ((motion.to.name,) if motion.to else ()) + grasps


def _transfer(motion: Motion, belief: Belief, context: Context) -> Found:
    """Joint-space motion to the stand-off of a place, once per inverse branch that can go on from there."""
    from cramlite_plugins.experts.reach import make_scene, tcp

    from .kinematics import inverse
    from .planner import Refusal, plan

    place, here = _place(motion, context), tcp(belief, context)
    if _near(here, place.before) or _near(here, place.pose):
        yield Grounding((), "the arm is there already", key="there")
        return
    home = motion.to is not None and motion.to.relation == "home"
    scene, attempt = make_scene(belief, context), 0
    goals: list[Any] = [context.robot.home]
    if not home:
        free = (q for q in inverse(context.robot, place.before, seed=belief.joints) if scene.free(q))
        goals = list(islice((q for q in free if _goes_on(q, place, context)), GOALS))
    while goals:
        found = plan(scene, belief.joints, goals, seed=context.seed + attempt, samples=context.samples)
        if isinstance(found, Refusal):
            raise Unresolvable(
                f"no path to {motion.to}: {found.reason}", _because(motion, context) if not attempt else ()
            )
        step = MoveJoints(found.points[1:], SPEED, ACCELERATION, origin=motion.name, comment=motion.reason)
        reason = f"{len(found.points) - 1} segments, {found.duration:.1f} s, {found.samples} samples, clearance kept"
        yield Grounding(
            (step,),
            reason,
            attempt + found.duration / 100,
            belief.moved(found.points[-1]),
            key=f"{attempt}:{found.points[-1]}",
        )
        goals, attempt = [g for g in goals if math.dist(g, found.points[-1]) > 0.1], attempt + 1
    if not attempt:
        raise Unresolvable(
            f"no inverse solution at the stand-off of {motion.to} leads straight on to it", _because(motion, context)
        )


def _goes_on(joints: Any, place: Place, context: Context) -> bool:
    """Whether the arm can go straight from the stand-off to the place on the same branch."""
    from .linear import straight
    from .planner import Refusal

    if _near(place.before, place.pose):
        return True
    return not isinstance(
        straight(None, context.robot, joints, [place.pose], step_m=COARSE[0], step_rad=COARSE[1]), Refusal
    )


def _near(a: Pose, b: Pose) -> bool:
    metres, radians = a.distance(b)
    return metres < SAME[0] and radians < SAME[1]


def _line(motion: Motion, belief: Belief, context: Context, targets: list[Pose]) -> Any:
    """Checked joint positions along straight lines, or Unresolvable."""
    from cramlite_plugins.experts.reach import make_scene, touched

    from .linear import straight
    from .planner import Refusal

    scene = make_scene(belief, context, touched(motion.may_touch, context), clearance=0.0)
    found = straight(scene, context.robot, belief.joints, targets)
    if isinstance(found, Refusal):
        raise Unresolvable(f"no straight line to {motion.to}: {found.reason}")
    return found.points


def _linear(motion: Motion, belief: Belief, context: Context) -> Found:
    from cramlite_plugins.experts.reach import tcp

    place = _place(motion, context)
    target = place.before if motion.parameters.get("stage") == "before" else place.pose
    if _near(tcp(belief, context), target):
        yield Grounding((), "the tool is there already", key="there")
        return
    points = _line(motion, belief, context, [target])
    speed = float(motion.parameters.get("speed_m_s", LINE_SPEED))
    step = MoveLinear(target, speed, LINE_ACCELERATION, points[-1], origin=motion.name, comment=motion.reason)
    length = tcp(belief, context).distance(target)[0]
    yield Grounding(
        (step,), f"straight {1000 * length:.0f} mm, free of collision", 0.0, belief.moved(points[-1]), key="line"
    )


def _gripper(motion: Motion, belief: Belief, context: Context) -> Found:
    gripper = context.robot.gripper
    to, force = motion.parameters["to"], float(motion.parameters.get("force_n", gripper.force[0]))
    expect = motion.parameters.get("expect", "any")
    if to == "closed":
        place = _place(motion, context)
        width = place.values.get("width_m", 0.0)
        step = SetGripper(
            gripper.opening[0],
            PADS_SPEED,
            min(max(force, gripper.force[0]), gripper.force[1]),
            expect,
            origin=motion.name,
            comment=motion.reason,
        )
        after = belief.grasped(_hold(place, belief, context, width))
        yield Grounding((step,), f"close on {1000 * width:.0f} mm with {step.force:.0f} N", 0.0, after, key="close")
        return
    fixed = {"open": gripper.opening[1], "shut": gripper.opening[0]}
    opening = fixed[to] if to in fixed else _place(motion, context).opening or gripper.opening[1]
    after = _let_go(motion, belief, context, opening) if belief.held else replace(belief, opening=opening)
    if belief.held is None and abs(belief.opening - opening) < 1e-6:
        yield Grounding((), f"open {1000 * opening:.0f} mm already", key="there")
        return
    step = SetGripper(opening, PADS_SPEED, gripper.force[0], expect, origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"open to {1000 * opening:.0f} mm", 0.0, after, key="open")


def _hold(place: Place, belief: Belief, context: Context, width: float) -> Held:
    from cramlite_plugins.experts.reach import tcp

    return Held(place.thing, tcp(belief, context).inverse() * belief.pose(place.thing), width)


def _let_go(motion: Motion, belief: Belief, context: Context, opening: float) -> Belief:
    """Released things are expected where they are, or, over a container, on its floor."""
    from cramlite_plugins.experts.set_down import lowest
    from cramlite_plugins.experts.reach import held_pose

    assert belief.held is not None
    pose, thing = held_pose(belief, context), belief.world.thing(belief.held.thing)
    container = motion.to.of if motion.to and motion.to.relation == "in" else None
    if container:
        owner = belief.thing(str(context.bindings[container]))
        floor = belief.pose(owner.name).position[2]
        pose = Pose((*pose.position[:2], floor - lowest(thing, pose)), pose.quaternion)
    estimate = Estimate(belief.base() * pose, 0.1 if container else 0.005, f"predicted: let go by {motion.name}")
    return belief.released(estimate, opening)


def _payload(motion: Motion, belief: Belief, context: Context) -> Found:
    gripper = context.robot.gripper
    mass, moment = gripper.mass, gripper.mass * np.array([0.0, 0.0, gripper.tcp.position[2] / 2])
    if belief.held:
        load = belief.world.thing(belief.held.thing).mass or 0.0
        moment = moment + load * np.array((gripper.tcp * belief.held.tcp_to_thing).position)
        mass += load
    center = (float(moment[0] / mass), float(moment[1] / mass), float(moment[2] / mass))
    step = SetPayload(mass, center, origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"{mass:.2f} kg on the flange", key=f"{mass:.3f}")


def _zero(motion: Motion, belief: Belief, context: Context) -> Found:
    if context.robot.sensor is None:
        raise Unresolvable(f"robot '{context.robot.type}' has no force-torque sensor, which '{motion.name}' needs")
    yield Grounding(
        (ZeroSensor(origin=motion.name, comment=motion.reason),), "tare the sensor standing still", key="zero"
    )


def _wait(motion: Motion, belief: Belief, context: Context) -> Found:
    step = Wait(float(motion.parameters["duration_s"]), origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"{step.duration:.1f} s", key="wait")


def _force_path(motion: Motion, belief: Belief, context: Context) -> Found:
    """Along the corners of a place's path; sideways the arm gives way, and carries what it holds."""
    place = _place(motion, context)
    points = _line(motion, belief, context, list(place.path))
    longest = max(
        np.diff([p.position for p in place.path], axis=0, prepend=[_start(belief, context)]),
        key=lambda v: float(np.linalg.norm(v)),
    )
    frame = Pose.from_axes((0, 0, 0), longest, _sideways(longest))
    load = (belief.world.thing(belief.held.thing).mass or 0.0) * GRAVITY if belief.held else 0.0
    press = float(motion.parameters.get("press_n", 0.0))
    wanted = frame.inverse().turn((0.0, 0.0, load - press))
    length = sum(
        np.linalg.norm(np.diff([p.position for p in place.path], axis=0, prepend=[_start(belief, context)]), axis=1)
    )
    speed = float(motion.parameters["speed_m_s"])
    step = ForceMove(
        place.path, frame, (True, True, False, False, False, False), (float(wanted[0]), float(wanted[1]), 0.0, 0.0, 0.0, 0.0),
        (COMPLIANT_SPEED, COMPLIANT_SPEED, 0.15, 0.35, 0.35, 0.35), speed, float(motion.parameters["force_limit_n"]),
        timeout=math.ceil(2 * length / speed + 3), joints=points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = (
        f"{1000 * length:.0f} mm at {1000 * speed:.0f} mm/s, sideways compliant, abort over {step.force_limit:.0f} N"
    )
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="force path")


def _start(belief: Belief, context: Context) -> tuple[float, float, float]:
    from cramlite_plugins.experts.reach import tcp

    return tcp(belief, context).position


def _sideways(axis: Any) -> Any:
    """A direction that is not along the axis: the vertical, unless the axis is vertical."""
    return (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 * float(np.linalg.norm(axis)) else (1.0, 0.0, 0.0)


def _until_contact(motion: Motion, belief: Belief, context: Context) -> Found:
    """From the stand-off to the place and up to a little beyond it, until something is felt."""
    from cramlite_plugins.experts.reach import tcp

    place, here = _place(motion, context), tcp(belief, context)
    way = np.array(place.pose.position) - np.array(here.position)
    distance = float(np.linalg.norm(way)) + 0.03
    direction = way / np.linalg.norm(way)
    points = _line(motion, belief, context, [place.pose])
    step = MoveUntilContact(
        tuple(direction), float(motion.parameters["speed_m_s"]), float(motion.parameters["force_n"]), distance,
        timeout=math.ceil(2 * distance / float(motion.parameters["speed_m_s"]) + 3), joints=points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"at most {1000 * distance:.0f} mm at {1000 * step.speed:.0f} mm/s until {step.force:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="until contact")
