"""Faults: things that go wrong with a cell or its controller, before a program starts or while it runs."""

from __future__ import annotations

from ..base.value import Value
from ..base.word import Word
from .geometry import Vector3


class FaultKind(Word):
    """Kind of a fault."""

    MISSING = "missing", "a thing is not there"
    MOVED = "moved", "a thing stands elsewhere than the program expects"
    PAYLOAD = "payload", "the flange bears more than the program tells"
    TOOL = "tool", "the tool is mounted elsewhere than the program tells"
    SENSOR = "sensor", "the force sensor's zero is off"
    STOP = "protective stop", "the controller stops the arm"
    CONNECTION = "connection", "clients lose the controller, and are not let in for a while"


AT_START = frozenset({FaultKind.MISSING, FaultKind.MOVED, FaultKind.PAYLOAD, FaultKind.TOOL, FaultKind.SENSOR})
"""Kinds that are there before a program starts; the others have a time."""


class Fault(Value):
    """Fault of a run.

    Args:
        kind: what goes wrong.
        thing: that it is about, where it is about one.
        by: how far a thing, or the tool in the flange's frame, is off [m]; of a sensor's zero [N].
        mass: that the flange bears beside what the program tells [kg].
        after: when it happens, from the program's start [s]; 0 for what is so from the start.
        lasts: how long clients are not let in [s].
    """

    kind: FaultKind
    thing: str = ""
    by: Vector3 = (0.0, 0.0, 0.0)
    mass: float = 0.0
    after: float = 0.0
    lasts: float = 0.0

    def __str__(self) -> str:
        """Return what goes wrong, as a clause."""
        by = ", ".join(f"{v:+g}" for v in self.by)
        match self.kind:
            case FaultKind.MISSING:
                return f"'{self.thing}' is missing"
            case FaultKind.MOVED:
                return f"'{self.thing}' is moved by {by} m"
            case FaultKind.PAYLOAD:
                return f"the flange bears {self.mass:+g} kg more than is told"
            case FaultKind.TOOL:
                return f"the tool is mounted {by} m off"
            case FaultKind.SENSOR:
                return f"the force sensor's zero is off by {by} N"
            case FaultKind.STOP:
                return f"a protective stop at {self.after:g} s"
        return f"no connection from {self.after:g} s on for {self.lasts:g} s"
