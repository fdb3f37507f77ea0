"""Messages between cramlite and a robot process, one JSON object a line (docs/how-to/drive_a_robot.md).

All lengths are metres, angles radians, times seconds, forces newtons; poses are of the tool centre point in the arm's base frame.
"""

from __future__ import annotations

import math
from typing import Literal, TypeVar

from msgspec import DecodeError, json

from cramlite.model import Joints, Value
from cramlite.plugin import UserError

PROTOCOL = 1
"""Version of this protocol; a process of another one is refused."""
Six = tuple[float, float, float, float, float, float]
Seven = tuple[float, float, float, float, float, float, float]


class State(Value, kw_only=True):
    """State of the robot at the end of a control period.

    Args:
        joints: encoders, base to flange [rad].
        opening: distance between the fingers [m].
        wrench: of the environment on the tool at the TCP, base axes, without the weight of the hand [N, Nm]; None where it feels
            nothing.
        stop: why the robot goes no further, as a clause; "" while it does.
        say: a line for the log.
        poses: of what can be moved, by name, in the world: position [m], quaternion (w, x, y, z); None where nobody reads them.
        goal: another one that is asked for, as predicates with their arguments; () where none is any more.
        sentence: another task that is asked for, in words; "" for none.
    """

    joints: Joints
    opening: float
    wrench: Six | None = None
    stop: str = ""
    say: str = ""
    poses: dict[str, Seven] | None = None
    goal: tuple[tuple[str, ...], ...] | None = None
    sentence: str = ""


class Hello(State, kw_only=True):
    """Answer to the first request: the description of the robot, with its first state.

    Args:
        protocol: version of the protocol that it speaks.
        robot: type, as cramlite's robots have it.
        actions: what it takes: joint positions, or deltas of the end effector from where it is.
        rate: actions in a second [Hz].
        lag: how long it stays behind what it is told while it moves [s]; actions are that much ahead. Of a critically damped spring of
            natural frequency w that holds an action for its period: 2 / w less half the period.
        inertia: how far it stays behind what it is told while it speeds up, for each m/s2 or rad/s2 [s2]; 1 / w^2 of such a spring.
            0 for what follows otherwise; deltas hold a spring more stiffly to its path.
        most: largest delta that it takes at once, translation [m] and rotation [rad]; None for no limit.
        tolerance: how near to a target it comes to rest, translation [m] and rotation [rad].
        fingers: how near they come to an opening [m]; None for 1.2 % of their stroke.
        closed: what they still are apart when they have closed on nothing [m]: what keeps them wider is held, however thin; None for
            ``fingers``.
        hesitation: how long they may stand still before they move [s]; those that rest longer have been stopped.
        settling: how long its force takes to settle when the arm has stopped [s]; before a tare it stands still for as long.
    """

    protocol: int
    robot: str
    actions: Literal["joints", "deltas"]
    rate: float
    lag: float = 0.0
    most: tuple[float, float] | None = None
    inertia: float = 0.0
    tolerance: tuple[float, float] = (0.002, 0.01)
    fingers: float | None = None
    closed: float | None = None
    hesitation: float = 0.08
    settling: float = 0.3


class AskHello(Value, tag_field="ask", tag="hello", kw_only=True):
    """First message to the process: the version of the protocol that cramlite speaks, and the type of
    robot that the program is for."""

    robot: str
    protocol: int = PROTOCOL


class Action(Value, tag_field="ask", tag="step", kw_only=True, omit_defaults=True):
    """Message that commands arm and fingers for one control period, with ``joints`` or ``delta``.

    Args:
        joints: where the arm shall be at the end of this period [rad].
        delta: the same as a translation and a rotation vector of the TCP from where the robot is, base axes [m, rad].
        opening: where the fingers shall be at the end of this period, anything between closed and open [m].
        grip: what they may press with [N].
    """

    opening: float
    grip: float
    joints: Joints | None = None
    delta: Six | None = None


class AskEnd(Value, tag_field="ask", tag="end"):
    """Last message to the process: the run is over, whatever its outcome, and the process ends."""


Said = TypeVar("Said", bound=State)


def encoded(ask: AskHello | Action | AskEnd) -> bytes:
    """Write a message as one line."""
    return json.encode(ask) + b"\n"


def understood(line: bytes, kind: type[Said], joints: int) -> Said:
    """Decode a message from a line that the robot process wrote.

    Args:
        joints: of the robot.

    Raises:
        UserError: it is no such message, or its numbers are none; a clause.
    """
    try:
        said = json.decode(line, type=kind)
    except (DecodeError, UnicodeDecodeError) as error:
        raise UserError(f"answered {_shown(line)}, which is no {kind.__name__.lower()} message: {error}") from None
    numbers = (*said.joints, said.opening, *(said.wrench or ()))
    if not all(map(math.isfinite, numbers)):
        raise UserError(f"answered {_shown(line)}, in which a number is not finite")
    if len(said.joints) != joints:
        raise UserError(f"answered with {len(said.joints)} joints; the robot has {joints}")
    return said


def _shown(line: bytes, most: int = 80) -> str:
    text = line.decode(errors="replace").strip()
    return repr(text if len(text) <= most else text[:most] + "...")
