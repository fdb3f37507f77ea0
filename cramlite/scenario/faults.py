"""Faults as files and tests write them, and worlds in which things are wrong from the start."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any

from msgspec.structs import replace
from pydantic import Field, ValidationError, model_validator

from ..base.errors import UserError, nearest
from ..base.quantities import Force, Length, Mass, Time
from ..base.spec import Spec
from ..model.fault import AT_START, Fault, FaultKind
from ..model.geometry import Pose
from ..model.world import World

Vector = tuple[Length, Length, Length]


class FaultSpec(Spec):
    """Fault as it is written: one key says what goes wrong, and of what; the others how.

    Args:
        missing, moved: name of a thing.
        payload: that the flange bears beside what is told [kg].
        tool: how far the tool is mounted off, in the flange's frame [m].
        sensor: what the force sensor's zero is off, in its axes [N].
        protective_stop: when the controller stops the arm [s].
        connection: when clients lose the controller [s].
        by: how far a thing is moved [m].
        lasts: how long clients are not let in [s].
    """

    missing: str | None = None
    moved: str | None = None
    payload: Mass | None = None
    tool: Vector | None = None
    sensor: tuple[Force, Force, Force] | None = None
    protective_stop: Annotated[Time, Field(ge=0)] | None = None
    connection: Annotated[Time, Field(ge=0)] | None = None
    by: Vector | None = None
    lasts: Annotated[Time, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> FaultSpec:
        named = [k for k in _KINDS if getattr(self, k) is not None]
        if len(named) != 1:
            raise ValueError(f"it says {', '.join(named) or 'none'} of {', '.join(_KINDS)}; it has exactly one of them")
        if (self.by is None) == (self.moved is not None):
            raise ValueError("'moved' goes with 'by': how far, such as by: [30 mm, 0, 0]")
        if (self.lasts is None) == (self.connection is not None):
            raise ValueError("'connection' goes with 'lasts': how long clients are not let in, such as lasts: 2 s")
        return self

    def fault(self) -> Fault:
        """Return the fault."""
        (kind,) = (k for k in _KINDS if getattr(self, k) is not None)
        return _KINDS[kind](self)


_KINDS: Mapping[str, Callable[[Any], Fault]] = {
    "missing": lambda s: Fault(FaultKind.MISSING, s.missing),
    "moved": lambda s: Fault(FaultKind.MOVED, s.moved, s.by),
    "payload": lambda s: Fault(FaultKind.PAYLOAD, mass=s.payload),
    "tool": lambda s: Fault(FaultKind.TOOL, by=s.tool),
    "sensor": lambda s: Fault(FaultKind.SENSOR, by=s.sensor),
    "protective_stop": lambda s: Fault(FaultKind.STOP, after=s.protective_stop),
    "connection": lambda s: Fault(FaultKind.CONNECTION, after=s.connection, lasts=s.lasts),
}
"""Key of a file -> the fault."""


def read_fault(written: Mapping[str, Any], where: str) -> Fault:
    """Read a fault.

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
            f"{where}: this is no fault: {said.replace('Value error, ', '')}. It has one of {', '.join(_KINDS)}."
        ) from None


def faulty(world: World, faults: Iterable[Fault]) -> World:
    """Return a world with faults: those from the start are applied, later ones are kept for the simulator.

    Raises:
        UserError: a fault is about a thing that the world does not have.
    """
    for fault in faults:
        world = _faulty(world, fault) if fault.kind in AT_START else replace(world, faults=(*world.faults, fault))
    return world


def _faulty(world: World, fault: Fault) -> World:
    names = [t.name for t in world.things]
    off = world.disturbance
    if fault.thing and fault.thing not in names:
        raise UserError(
            f"A fault is about '{fault.thing}', which is no thing of this world; {nearest(fault.thing, names)}."
        )
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
