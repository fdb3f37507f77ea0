"""Contract checks of declarations other than task types, as ``cramlite.testing`` offers them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any
from xml.etree import ElementTree

from msgspec.structs import replace

from ..base.errors import UserError
from ..interpretation.timeline import Predicate
from ..model.geometry import Pose
from ..model.program.program import Code, Program, Section
from ..model.program.steps import (
    CompliantSlide,
    ForceExtract,
    ForceInsert,
    ForceMove,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
    walk,
)
from ..model.robot import Robot
from ..model.run.verdict import COSTS
from ..model.world.world import RobotMount, World
from ..plugin.catalogue import Knowledge
from ..plugin.expert import Expert
from ..plugin.protocols import Backend, Validator
from ..plugin.registry import Registry


def sample_robot(backend: str = "") -> Robot:
    """Return an installed robot, if possible one whose native language is that of a backend."""
    robots = Knowledge(Registry()).robots
    native = [r for _, r in sorted(robots.items()) if r.backend == backend]
    return native[0] if native else robots[min(robots)]


def sample_program(robot: Robot | None = None) -> Program:
    """Return a sample program for a robot, with one step of every kind that an arm and its gripper execute.

    It is what a backend must be able to write, not to be run.
    """
    robot = robot or sample_robot()
    home, there = robot.home, Pose((0.4, 0.1, 0.3), (0.0, 1.0, 0.0, 0.0))
    free = (True, True, False, False, False, False)
    steps = (
        MoveJoints((home,), 1.0, 1.4, origin="1.Reaching/transfer", comment="to the start"),
        MoveLinear(there, 0.1, 0.5, home, origin="1.Reaching/approach", comment="straight on"),
        SetGripper(robot.gripper.opening[0], 0.05, robot.gripper.force[0], origin="1.Reaching/close"),
        SetPayload(0.9, (0.0, 0.0, 0.05), origin="2.Holding/payload"),
        ZeroSensor(origin="2.Holding/tare"),
        Wait(0.5, origin="2.Holding/hold"),
        MoveUntilContact((0.0, 0.0, -1.0), 0.01, 3.0, 0.05, 10.0, "any", home, origin="3.Placing/touch"),
        ForceMove((there,), there, free, (0.0,) * 6, (0.02,) * 6, 0.02, 25.0, 10.0, home, origin="3.Placing/along"),
        SpiralSearch(there, 3.0, 0.001, 0.005, 0.01, 0.002, 25.0, 20.0, home, origin="3.Placing/search"),
        ForceInsert(there, 8.0, 0.02, 0.02, 25.0, 10.0, home, origin="3.Placing/insert"),
        ForceExtract(there, 8.0, (0.0, 0.0), 0.02, 0.02, 25.0, 10.0, home, origin="3.Placing/extract"),
        CompliantSlide((there,), there, 3.0, 0.02, 0.5, 25.0, 10.0, home, origin="3.Placing/slide"),
    )
    sections = (
        Section("1.Reaching", "reach", 0, 3),
        Section("2.Holding", "hold", 3, 6),
        Section("3.Placing", "place", 6, 12),
    )
    return Program("sample", "arm", robot.type, robot.gripper.tcp, home, steps, sections)


def check_expert(expert: Expert) -> None:
    """Check that an expert declares inputs, outputs and the outputs' domains.

    Raises:
        AssertionError: with what is wrong, as all checks here.
    """
    name = expert.name
    assert name and expert.summary, f"expert '{name}': name and summary are for people; give both"
    assert expert.outputs, f"expert '{name}' makes nothing"
    assert expert.scope in ("view", "object", "scene"), f"expert '{name}': no scope '{expert.scope}'"
    assert not set(expert.inputs) & set(expert.outputs), f"expert '{name}' needs what it makes"
    strangers = set(expert.domains) - set(expert.outputs)
    assert not strangers, f"expert '{name}': it declares a domain for {sorted(strangers)}, which is none of its outputs"
    assert expert.cost_ms > 0, f"expert '{name}': cost_ms must be the measured time of one run, above 0 ms; it is {expert.cost_ms}"
    for parameter in expert.parameters:
        assert parameter.source, f"expert '{name}': parameter '{parameter.name}' does not say where its default comes from"


def check_predicate(predicate: Predicate) -> None:
    """Check that a predicate has a name for rules, a sentence for people, and a function that takes its arguments.

    Raises:
        AssertionError: it lacks one of them; says which.
    """
    import inspect

    name = predicate.name
    assert re.fullmatch(r"[a-z][a-z0-9_]*", name), f"predicate '{name}': rules cannot write this name; one such as 'is_light' is needed"
    assert predicate.doc, f"predicate '{name}' has no sentence for people (doc)"
    assert predicate.phases, f"predicate '{name}' has no phase in which rules may use it"
    signature = inspect.signature(predicate.function)
    try:
        signature.bind(*[None] * (predicate.arity + 1))
    except TypeError as error:
        raise AssertionError(
            f"predicate '{name}' of arity {predicate.arity} is called with the phase and {predicate.arity} arguments, "
            f"but its function is {predicate.function.__name__}{signature}"
        ) from error


def check_validator(validator: Validator) -> None:
    """Check that a validator has a name, a cost class that says when it is asked, and a check."""
    assert validator.name, "a validator needs a name; findings carry it"
    assert validator.cost in COSTS, (
        f"validator '{validator.name}': no cost '{validator.cost}'; one of {', '.join(COSTS)}"
    )
    assert callable(getattr(validator, "check", None)), f"validator '{validator.name}' has no method check(candidate)"


def check_backend(backend: Backend) -> None:
    """Check that a backend writes plain motions, always as the same text, and that lines of the text name the
    steps they come from.

    It is asked for a robot whose native language it is, or, where there is none, for any that it takes. Steps that it
    refuses by their names are left out; those that feel may be refused, plain moves may not.
    """
    assert backend.name and isinstance(backend.executable, bool), "a backend needs a name and says 'executable'"
    program, robot, code = _written(backend)
    assert isinstance(code, Code), f"backend '{backend.name}' must give a Code, not {type(code).__name__}"
    assert code.text.strip(), f"backend '{backend.name}' wrote nothing"
    assert code == backend.emit(program, robot), f"backend '{backend.name}' wrote two texts for one program"
    assert code.suffix.startswith("."), f"backend '{backend.name}': '{code.suffix}' is no suffix such as '.txt'"
    known = {s.origin for s in walk(program.steps)} | {s.task for s in program.sections}
    lines = len(code.text.splitlines())
    for line, origin in code.origins.items():
        assert 1 <= line <= lines, f"backend '{backend.name}': 'origins' has a line {line}, but the text has the lines 1 to {lines}"
        assert origin in known, f"backend '{backend.name}': line {line} comes from '{origin}', which is no step"


def _written(backend: Backend) -> tuple[Program, Robot, Code]:
    """Return the sample program, and its text for the first robot for which the backend writes it, with that
    robot."""
    said = ""
    robots = Knowledge(Registry()).robots.values()
    for robot in sorted(robots, key=lambda r: (r.backend != backend.name, r.type)):
        program = sample_program(robot)
        while {MoveJoints, MoveLinear} <= {type(s) for s in program.steps}:
            try:
                return program, robot, backend.emit(program, robot)
            except UserError as error:
                said = said or f"for '{robot.type}': {error}"
                left = tuple(s for s in program.steps if s.origin not in str(error))
            if len(left) == len(program.steps):
                break
            program = replace(program, steps=left, sections=(Section("0.Sample", "what is left", 0, len(left)),))
    raise AssertionError(f"backend '{backend.name}' writes no program {said}")


def check_robot(robot: Robot) -> None:
    """Check that a robot's numbers agree with each other and with its model, and that the simulator can load
    the model.

    Raises:
        AssertionError: they do not, the model lacks a joint, site, actuator, sensor or pad, or does not compile; says which.
    """
    _check_numbers(robot)
    model = ElementTree.fromstring(robot.mjcf())
    named = {(e.tag, e.get("name", "")) for e in model.iter()}
    wanted = [("joint", j) for j in robot.joints] + [("site", s) for s in ("flange", "tcp")]
    missing = [f"{tag} '{name}'" for tag, name in wanted if (tag, name) not in named]
    others = {
        name for tag, name in named if tag not in ("joint", "body")
    }  # actuators and sensors have tags of many kinds
    drives = robot.gripper.linkage.actuators if robot.gripper.linkage else ("gripper",)
    driven = (*robot.joints, *drives, *(("ft_force", "ft_torque") if robot.sensor else ()))
    missing += [f"actuator or sensor '{name}'" for name in driven if name not in others]
    assert not missing, f"robot '{robot.type}': its model has no {', '.join(missing)}"
    for side in ("left_pad", "right_pad"):
        assert any(t == "geom" and n.startswith(side) for t, n in named), f"robot '{robot.type}': no geom '{side}*'"
    world = World((), (RobotMount("arm", robot.type),))
    try:
        Knowledge(Registry()).simulator.check(world, {robot.type: robot})
    except UserError as error:
        raise AssertionError(f"robot '{robot.type}': {error}") from error


def _check_numbers(robot: Robot) -> None:
    n, said = len(robot.joints), f"robot '{robot.type}'"
    for name in ("limits", "velocity", "acceleration", "home"):
        assert len(getattr(robot, name)) == n, f"{said}: {n} joints, but {len(getattr(robot, name))} values of '{name}'"
    assert robot.dh is None or len(robot.dh) == n, f"{said}: {n} joints, but {len(robot.dh or ())} rows of 'dh'"
    for joint, (low, high), home in zip(robot.joints, robot.limits, robot.home, strict=True):
        assert low < high, f"{said}: the lower limit of '{joint}', {low}, is not below the upper one, {high}"
        assert low <= home <= high, f"{said}: home of '{joint}' is {home}, outside {low} to {high}"
    assert min(robot.velocity) > 0 and min(robot.acceleration) > 0, f"{said}: speeds and accelerations must be larger than 0"
    assert robot.reach > 0 and robot.payload > 0, f"{said}: reach and payload must be larger than 0"
    assert robot.gripper.opening[0] < robot.gripper.opening[1], f"{said}: the gripper does not open"


CHECKS: Mapping[str, Callable[[Any], None]] = {
    "experts": check_expert,
    "predicates": check_predicate,
    "validators": check_validator,
    "backends": check_backend,
    "robots": check_robot,
}
"""Name of a hook -> contract check of each object that a plugin declares under it."""


def check_declared(hook: str, items: Iterable[object]) -> None:
    """Check each object that a plugin declares under a hook against its contract."""
    for item in items:
        CHECKS[hook](item)
