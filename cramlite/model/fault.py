"""Faults: things that go wrong with a cell or its controller, before a program starts or while it runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..base.value import Value
from ..base.word import Word
from .geometry import Vector3


class FaultKind(Word):
    """Kind of a fault that is simulated on purpose, such as a moved thing or slipping fingers."""

    MISSING = "missing", "a thing is not there, or is taken away"
    MOVED = "moved", "a thing stands elsewhere than the program expects, or is moved while it runs"
    ADDED = "added", "a thing that nobody knew of comes into the scene"
    FALLEN = "fallen", "a thing falls over"
    PAYLOAD = "payload", "the flange bears more than the program tells"
    TOOL = "tool", "the tool is mounted elsewhere than the program tells"
    SENSOR = "sensor", "the force sensor's zero is off"
    GRIP_LOST = "grip lost", "the fingers open by themselves, and close again when the fault is over"
    SLIP = "slip", "the fingers press with a share of what they are told"
    CLOSES_SHORT = "closes short", "the fingers come no nearer to one another"
    STICKING = "sticking", "a joint of a thing takes a force to be moved at all"
    FRICTION = "friction", "all surfaces have a share of their friction"
    FROZEN = "frozen", "readings stay as they are for a while"
    LOST = "lost", "there are no readings for a while"
    STOP = "protective stop", "the controller stops the arm"
    CONNECTION = "connection", "clients lose the controller, and are not let in for a while"
    KILLED = "killed", "the program ends without a word; the arm stays where it is"
    GOAL = "goal", "another goal is asked for"
    CANCELLED = "cancelled", "the task is cancelled"


AT_START = frozenset({FaultKind.MISSING, FaultKind.MOVED, FaultKind.PAYLOAD, FaultKind.TOOL, FaultKind.SENSOR})
"""Kinds of faults that are present before a program starts, unless they have a trigger. All other kinds occur while the program runs."""


class Trigger(Value):
    """Trigger of a fault, whose conditions must all hold at one moment.

    Args:
        line: text that a line of the program has: from when it is reached; "" for any.
        force: that the program feels, at least [N]; 0 for any.
        near: thing whose origin the tool centre point comes as near to as ``within``; "" for none.
        within: see ``near`` [m].
        carried_over: whether the fault is left over from an earlier program; a later one need not have the line.
    """

    line: str = ""
    force: float = 0.0
    near: str = ""
    within: float = 0.0
    carried_over: bool = False

    def __str__(self) -> str:
        """Return the conditions of the trigger in words; "" if the fault begins at once."""
        said = [f"at '{self.line}'"] if self.line else []
        said += [f"at {self.force:g} N"] if self.force else []
        said += [f"{self.within:g} m from '{self.near}'"] if self.near else []
        return " and ".join(said)


class Fault(Value):
    """Fault that is simulated in a run on purpose: what goes wrong, when, and for how long.

    Args:
        kind: what goes wrong.
        thing: that it is about, where it is about one.
        by: how far a thing, or the tool in the flange's frame, is off [m]; of a sensor's zero [N].
        mass: that the flange bears beside what the program tells [kg].
        after: when it happens, from the program's start, or from its trigger, on [s]; 0 for at once.
        lasts: how long it lasts [s]; 0 for the rest of the run, or where it is over at once.
        share: of the force or friction that is left, 0 to 1.
        most: how near the fingers come [m]; what a joint takes [N, Nm].
        goal: sentences of the goal that is asked for then.
        trigger: None for the program's start.
    """

    kind: FaultKind
    thing: str = ""
    by: Vector3 = (0.0, 0.0, 0.0)
    mass: float = 0.0
    after: float = 0.0
    lasts: float = 0.0
    share: float = 1.0
    most: float = 0.0
    goal: tuple[str, ...] = ()
    trigger: Trigger | None = None

    @property
    def from_start(self) -> bool:
        """Whether the fault is present before the program starts."""
        return self.kind in AT_START and self.trigger is None and not self.after

    def __str__(self) -> str:
        """Describe the fault in words, with its time and trigger."""
        when = str(self.trigger) if self.trigger else ""
        timed = self.kind in (FaultKind.STOP, FaultKind.CONNECTION)
        if self.after and not timed:
            when = f"{self.after:g} s after {when}" if when else f"at {self.after:g} s"
        return " ".join(filter(None, (_SAID[self.kind](self), when)))


def _vector(fault: Fault) -> str:
    return ", ".join(f"{v:+g}" for v in fault.by)


_SAID: Mapping[FaultKind, Callable[[Fault], str]] = {
    FaultKind.MISSING: lambda f: f"'{f.thing}' is missing",
    FaultKind.MOVED: lambda f: f"'{f.thing}' is moved by {_vector(f)} m",
    FaultKind.ADDED: lambda f: f"'{f.thing}' appears",
    FaultKind.FALLEN: lambda f: f"'{f.thing}' falls over",
    FaultKind.PAYLOAD: lambda f: f"the flange bears {f.mass:+g} kg more than the program states",
    FaultKind.TOOL: lambda f: f"the tool is mounted {_vector(f)} m from its nominal place",
    FaultKind.SENSOR: lambda f: f"the force sensor's zero is off by {_vector(f)} N",
    FaultKind.GRIP_LOST: lambda f: f"the fingers open for {f.lasts:g} s",
    FaultKind.SLIP: lambda f: f"the fingers press with {f.share:g} of their force for {f.lasts:g} s",
    FaultKind.CLOSES_SHORT: lambda f: f"the fingers come no nearer to each other than {f.most:g} m",
    FaultKind.STICKING: lambda f: f"'{f.thing}' takes {f.most:g} N or Nm to be moved",
    FaultKind.FRICTION: lambda f: f"all friction is {f.share:g} of what it was",
    FaultKind.FROZEN: lambda f: f"readings freeze for {f.lasts:g} s",
    FaultKind.LOST: lambda f: f"there are no readings for {f.lasts:g} s",
    FaultKind.STOP: lambda f: f"a protective stop at {f.after:g} s",
    FaultKind.CONNECTION: lambda f: f"the controller takes no connection from {f.after:g} s on for {f.lasts:g} s",
    FaultKind.KILLED: lambda f: "the program is killed",
    FaultKind.GOAL: lambda f: f"the goal becomes {' and '.join(f.goal)}",
    FaultKind.CANCELLED: lambda f: "the task is cancelled",
}
