"""Faults in scenario files and tests, and their application to a world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

import yaml
from msgspec.structs import replace
from pydantic import Field, ValidationError, model_validator

from ..base.errors import UserError, nearest
from ..base.quantities import Force, Length, Mass, Time
from ..base.spec import Spec
from ..model.fault import Fault, FaultKind, Trigger
from ..model.geometry import Pose
from ..model.world.world import World

Vector = tuple[Length, Length, Length]


class FaultSpec(Spec):
    """Fault in a file: the one key that names its kind, with its thing or number, and keys that say how and
    when.

    Args:
        missing, moved, added, fallen, sticking: name of a thing.
        payload: that the flange bears beside what is told [kg].
        tool: how far the tool is mounted off, in the flange's frame [m].
        sensor: what the force sensor's zero is off, in its axes [N].
        grip_lost: how long the fingers stay open [s].
        slip: share of their force with which the fingers press.
        closes_short: how near the fingers come [m].
        friction: share of their friction that surfaces have.
        readings: "frozen" or "lost".
        protective_stop: when the controller stops the arm [s].
        connection: when clients lose the controller [s].
        killed, cancelled: true.
        goal: another one, in sentences.
        by: how far a thing is moved, or from where the scenario has it [m].
        takes: force or torque that a sticking joint takes [N, Nm].
        lasts: how long it lasts [s].
        after: how long after its trigger, or after the program's start, it happens [s].
        line: text of the program line with which it happens.
        force: that must be felt [N].
        near, within: thing that the tool comes near to, and how near [m].
    """

    missing: str | None = None
    moved: str | None = None
    added: str | None = None
    fallen: str | None = None
    sticking: str | None = None
    payload: Mass | None = None
    tool: Vector | None = None
    sensor: tuple[Force, Force, Force] | None = None
    grip_lost: Time | None = Field(None, gt=0)
    slip: float | None = Field(None, ge=0, lt=1)
    closes_short: Length | None = Field(None, gt=0)
    friction: float | None = Field(None, ge=0, le=3)
    readings: Literal["frozen", "lost"] | None = None
    protective_stop: Time | None = Field(None, ge=0)
    connection: Time | None = Field(None, ge=0)
    killed: Literal[True] | None = None
    cancelled: Literal[True] | None = None
    goal: tuple[str, ...] | None = Field(None, min_length=1)
    by: Vector | None = None
    takes: Force | None = Field(None, gt=0)
    lasts: Time | None = Field(None, gt=0)
    after: Time = Field(0.0, ge=0)
    line: str = ""
    force: Force = Field(0.0, ge=0)
    near: str = ""
    within: Length | None = Field(None, gt=0)

    @model_validator(mode="after")
    def _one_kind(self) -> FaultSpec:
        named = [k for k in _KINDS if getattr(self, k) is not None]
        if len(named) != 1:
            raise ValueError(f"the fault has {', '.join(named) or 'none'} of the keys {', '.join(_KINDS)}, and needs exactly one of them")
        (kind,) = named
        for key, (must, may, what) in _GO_WITH.items():
            given = getattr(self, key) is not None
            if given and kind not in (*must, *may):
                raise ValueError(f"'{key}' may stand beside {', '.join(f'{k!r}' for k in (*must, *may))}, not beside '{kind}'")
            if not given and kind in must:
                raise ValueError(f"'{kind}' needs '{key}': {what}")
        if bool(self.near) != (self.within is not None):
            raise ValueError("'near' needs 'within', and 'within' needs 'near': how near the tool comes, such as within: 0.18 m")
        if kind in _NO_TRIGGER and (self.trigger() is not None or self.after):
            raise ValueError(f"'{kind}' takes neither a trigger nor 'after': the fault begins {_NO_TRIGGER[kind]}")
        return self

    def trigger(self) -> Trigger | None:
        """Return the condition that starts the fault; None if only time does."""
        if not (self.line or self.force or self.near):
            return None
        return Trigger(self.line, self.force, self.near, self.within or 0.0)

    def fault(self) -> Fault:
        """Return the fault that this entry of a scenario describes."""
        (kind,) = (k for k in _KINDS if getattr(self, k) is not None)
        found = _KINDS[kind](self)
        return replace(found, after=found.after or self.after, trigger=self.trigger())


_GO_WITH: Mapping[str, tuple[tuple[str, ...], tuple[str, ...], str]] = {
    "by": (("moved",), ("added",), "how far, such as by: [30 mm, 0, 0]"),
    "takes": (("sticking",), (), "the force that its joint takes, such as takes: 60 N"),
    "lasts": (("connection", "slip", "readings"), (), "how long, such as lasts: 2 s"),
}
"""Additional keys of a fault: the kinds of fault that need the key, the kinds that may have it, and a phrase that explains it."""
_NO_TRIGGER = dict.fromkeys(("protective_stop", "connection"), "at its time") | dict.fromkeys(("tool", "sensor"), "at the start")
_KINDS: Mapping[str, Callable[[Any], Fault]] = {
    "missing": lambda s: Fault(FaultKind.MISSING, s.missing),
    "moved": lambda s: Fault(FaultKind.MOVED, s.moved, s.by),
    "added": lambda s: Fault(FaultKind.ADDED, s.added, s.by or (0.0, 0.0, 0.0)),
    "fallen": lambda s: Fault(FaultKind.FALLEN, s.fallen),
    "sticking": lambda s: Fault(FaultKind.STICKING, s.sticking, most=s.takes),
    "payload": lambda s: Fault(FaultKind.PAYLOAD, mass=s.payload),
    "tool": lambda s: Fault(FaultKind.TOOL, by=s.tool),
    "sensor": lambda s: Fault(FaultKind.SENSOR, by=s.sensor),
    "grip_lost": lambda s: Fault(FaultKind.GRIP_LOST, lasts=s.grip_lost),
    "slip": lambda s: Fault(FaultKind.SLIP, share=s.slip, lasts=s.lasts),
    "closes_short": lambda s: Fault(FaultKind.CLOSES_SHORT, most=s.closes_short),
    "friction": lambda s: Fault(FaultKind.FRICTION, share=s.friction),
    "readings": lambda s: Fault(FaultKind.FROZEN if s.readings == "frozen" else FaultKind.LOST, lasts=s.lasts),
    "protective_stop": lambda s: Fault(FaultKind.STOP, after=s.protective_stop),
    "connection": lambda s: Fault(FaultKind.CONNECTION, after=s.connection, lasts=s.lasts),
    "killed": lambda s: Fault(FaultKind.KILLED),
    "cancelled": lambda s: Fault(FaultKind.CANCELLED),
    "goal": lambda s: Fault(FaultKind.GOAL, goal=s.goal),
}
"""Function that makes the fault, by the key that names the kind of fault in a scenario file."""


def read_fault_text(text: str) -> Fault:
    """Read a fault from a command line: "moved: block, by: [60 mm, 0, 0], line: Grasping".

    Raises:
        UserError: it is none.
    """
    try:
        written = yaml.safe_load("{" + text + "}")
    except yaml.YAMLError as error:
        raise UserError(f"--fault '{text}': this is no list of 'key: value': {' '.join(str(error).split())}.") from None
    return read_fault(written, f"--fault '{text}'")


def read_fault(written: Mapping[str, Any], where: str) -> Fault:
    """Read a fault from the mapping of a file.

    Args:
        where: it is written, for the message.

    Raises:
        UserError: it is none; says what would be right.
    """
    try:
        return FaultSpec.model_validate(written).fault()
    except ValidationError as error:
        said = "; ".join(f"{'.'.join(map(str, e['loc']))}: {e['msg']}".removeprefix(": ") for e in error.errors()[:2])
        raise UserError(
            f"{where}: this cannot be read as a fault: {said.replace('Value error, ', '')}. A fault has exactly one of {', '.join(_KINDS)}."
        ) from None


def faulty(world: World, faults: Iterable[Fault]) -> World:
    """Return a world with faults: those present from the start are applied, later ones are kept for the
    simulator.

    Raises:
        UserError: a fault is about a thing that the world does not have, or that does not do what it says.
    """
    for fault in faults:
        _check(world, fault)
        world = _faulty(world, fault) if fault.from_start else replace(world, faults=(*world.faults, fault))
    return world


def foreseen(faults: Iterable[Fault], world: World) -> World:
    """Return the world as it is believed, without the things that faults will add."""
    unknown = {f.thing for f in faults if f.kind is FaultKind.ADDED}
    return replace(world, things=tuple(t for t in world.things if t.name not in unknown))


LASTING = frozenset({FaultKind.STICKING, FaultKind.FRICTION, FaultKind.CLOSES_SHORT})
"""Kinds of fault that are still present in the next run."""


def left_over(faults: Iterable[Fault], happened: Iterable[str], seconds: float) -> tuple[Fault, ...]:
    """Return the faults that remain after a run: those that last, and those that did not happen yet.

    Args:
        happened: those that happened in the run, as text.
        seconds: that it took.
    """
    done, found = set(happened), []
    for fault in faults:
        if str(fault) not in done:
            trigger = replace(fault.trigger, carried_over=True) if fault.trigger else None
            found.append(replace(fault, trigger=trigger, after=fault.after if trigger else max(0.0, fault.after - seconds)))
        elif fault.kind in LASTING:
            found.append(replace(fault, trigger=None, after=0.0))
    return tuple(found)


UNTIMED = frozenset({FaultKind.TOOL, FaultKind.SENSOR})
"""Kinds of fault that must be present from the start, because the simulation cannot begin them while a program runs."""
_PUT = (FaultKind.MISSING, FaultKind.MOVED, FaultKind.ADDED, FaultKind.FALLEN)


def _check(world: World, fault: Fault) -> None:
    names = [t.name for t in world.things]
    if fault.kind in UNTIMED and not fault.from_start:
        raise UserError(f"A fault says that {fault}; such a fault is present from the start, and has neither trigger nor time.")
    for name in filter(None, (fault.thing, fault.trigger.near if fault.trigger else "")):
        if name not in names:
            raise UserError(f"A fault is about '{name}', which is no thing of this world; {nearest(name, names)}.")
    if not fault.thing or fault.from_start:
        return
    thing = world.thing(fault.thing)
    if fault.kind is FaultKind.STICKING and thing.joint is None:
        raise UserError(f"A fault says that '{thing.name}' sticks, but it is on no joint.")
    if fault.kind in _PUT and thing.furniture:
        raise UserError(f"A fault moves '{thing.name}' while the program runs; only loose things can be moved then.")


def _faulty(world: World, fault: Fault) -> World:
    off = world.disturbance
    match fault.kind:
        case FaultKind.MISSING:
            return replace(world, things=tuple(t for t in world.things if t.name != fault.thing))
        case FaultKind.MOVED:
            pose = world.thing(fault.thing).pose
            return world.moved({fault.thing: Pose(fault.by) * pose})
        case FaultKind.PAYLOAD:
            return replace(world, disturbance=replace(off, flange_mass=off.flange_mass + fault.mass))
        case FaultKind.TOOL:
            return replace(world, disturbance=replace(off, tool=fault.by))
    return replace(world, disturbance=replace(off, force_bias=fault.by))
