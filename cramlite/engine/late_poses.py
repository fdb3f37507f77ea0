"""Parametric programs, which ask for a thing's pose when they run, and adapt their motions to that pose.

A thing is late from the first task that is about it until it is held and the next free motion begins: what the arm does in
between is meant relative to the thing, and moves along with it. Free motions are not bent: the arm goes to where it was
planned to go, and from there straight to where the thing really is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from msgspec.structs import replace

from ..base.errors import UserError
from ..model.geometry import Pose
from ..model.program.program import LatePose, Program, Section
from ..model.program.steps import (
    AnyStep,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    SetGripper,
    SetPayload,
    Wait,
    ZeroSensor,
)
from ..model.robot import Robot
from ..model.world.world import World
from ..plugin.protocols import Candidate

Tolerance = tuple[float, float]
CORRECTION = (0.1, 0.5)  # speed and acceleration of the way from the planned place to the real one [m/s, m/s2]
FOLLOWING = MoveLinear | MoveUntilContact
UNMOVED = SetGripper | SetPayload | Wait | ZeroSensor


def parametric(candidate: Candidate, late: Mapping[str, Tolerance]) -> Candidate:
    """Make a program ask at run time for the poses of things that are known only then (late things), and follow them.

    Args:
        late: thing -> how far from the planned pose the program must still work [m, rad].

    Raises:
        UserError: nothing grasps a late thing, or what is done to it cannot follow it.
    """
    program = candidate.program
    for thing, tolerance in late.items():
        planned = next((s.pose for s in program.snapshots if s.thing == thing), None)
        if planned is None:
            raise UserError(f"late: '{thing}': no task of the program is about this thing, so its pose need not be asked for.")
        about = {a.name for a in candidate.actions if any(o.entity == thing for o in a.roles.values())}
        program = _following(program, candidate.robot, thing, about)
        program = replace(
            program,
            late=(*program.late, LatePose(thing, planned, tolerance)),
            snapshots=tuple(s for s in program.snapshots if s.thing != thing),
        )
    return replace(candidate, program=program)


def _following(program: Program, robot: Robot, thing: str, about: set[str]) -> Program:
    """Rewrite the steps about a thing so that they follow the thing's pose, which the program asks for when it runs.

    These are the steps from the first task about the thing to the first free motion that carries it.
    """
    steps: list[AnyStep] = []
    firsts = {s.first: s for s in program.sections}
    sections: list[Section] = []
    begun = held = done = False
    for k, step in enumerate(program.steps):
        if k in firsts:
            sections.append(replace(firsts[k], first=len(steps)))
            begun = begun or firsts[k].task in about
        done = done or (held and isinstance(step, MoveJoints))
        steps += _relative(step, robot, program, thing) if begun and not done else [step]
        held = held or (begun and isinstance(step, SetGripper) and step.expect == "object")
    if not held:
        raise UserError(f"late: '{thing}' is never grasped by the program: only a grasped thing can have a late pose.")
    ends = [*(s.first for s in sections[1:]), len(steps)]
    placed = tuple(replace(s, last=end) for s, end in zip(sections, ends, strict=True))
    return replace(program, steps=tuple(steps), sections=placed)


def _relative(step: AnyStep, robot: Robot, program: Program, thing: str) -> list[AnyStep]:
    if isinstance(step, UNMOVED):
        return [step]
    if isinstance(step, FOLLOWING):
        return [replace(step, relative=thing)]
    if isinstance(step, MoveJoints) and robot.dh is not None:
        place = flange(robot, step.path[-1]) * program.tcp
        said = f"correction from the planned pose of '{thing}' to its present one"
        speed, acceleration = CORRECTION
        return [step, MoveLinear(place, speed, acceleration, step.path[-1], origin=step.origin, comment=said, relative=thing)]
    raise UserError(
        f"late: '{thing}': {step.origin}: {type(step).__name__} cannot follow a thing whose pose is only known when the program runs."
    )


def flange(robot: Robot, q: tuple[float, ...]) -> Pose:
    """Return the flange's pose in the base frame at joint angles [rad]: ``Robot.root``, times Rz(q) Tz(d)
    Tx(a) Rx(alpha) of each joint."""
    pose = robot.root
    for (a, d, alpha), angle in zip(robot.dh or (), q, strict=True):
        turn = Pose((0, 0, d), (math.cos(angle / 2), 0, 0, math.sin(angle / 2)))
        pose = pose * turn * Pose((a, 0, 0), (math.cos(alpha / 2), math.sin(alpha / 2), 0, 0))
    return pose


def worlds_at_tolerance(world: World, program: Program) -> Iterator[tuple[str, World]]:
    """Generate worlds at the limits of the tolerance: each late thing (one whose pose is asked for at run
    time) displaced and turned as far as declared.

    Args:
        world: as it was believed to be when the program was planned.
    """
    for late in program.late:
        far, turn = late.tolerance
        for x, y, sense in ((far, 0.0, 1.0), (0.0, far, -1.0), (-far, 0.0, 1.0), (0.0, -far, -1.0)):
            believed, half = world.thing(late.thing).pose, sense * turn / 2
            px, py, pz = believed.position
            about = Pose((0.0, 0.0, 0.0), (math.cos(half), 0.0, 0.0, math.sin(half)))
            turned = Pose((px + x, py + y, pz), (about * Pose((0.0, 0.0, 0.0), believed.quaternion)).quaternion)
            said = f"'{late.thing}' {1000 * x:+.0f}, {1000 * y:+.0f} mm and {math.degrees(sense * turn):+.0f} deg from its planned pose"
            yield said, world.moved({late.thing: turned})
