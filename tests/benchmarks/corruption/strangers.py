"""Class A: what no task names is gripped, carried or put in the way. The hand comes back, and the program goes on as it was."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from . import tracks
from .bases import Ready
from .rule import Edit, Rule, Seen, rule
from .script import Script
from .snippets import Lines, aside, excursion, go, moved, put, taken

Visit = Callable[[Ready, Random], Lines]

HARMED = 0.03
"""Way of a stranger that counts as harm [m]: six times the limit by default for what no task names."""


def at_some_time(ready: Ready, draw: Random, lines: Lines) -> str:
    """Insert an excursion before the first motion, or, where the arm parks, before or after the last one."""
    script = ready.script
    if "parked" not in ready.base.is_a or draw.random() < 0.5:
        return script.within(script.origins()[0], excursion(lines)).text
    if "placed" in ready.base.is_a and draw.random() < 0.5:
        return script.after("Retracting/back", excursion(lines)).text
    return script.after("ParkingArms/park", excursion(lines)).text


def visiting(visit: Visit) -> Edit:
    """Make an edit of lines that are written for a stranger."""
    return lambda ready, draw: at_some_time(ready, draw, visit(ready, draw))


def _carried(ready: Ready, draw: Random) -> Lines:
    at = ready.rest(ready.base.stranger)
    return moved(at, aside(at, -draw.uniform(0.06, 0.11), draw.uniform(-0.03, 0.04)), lift=draw.uniform(0.06, 0.14))


def _dropped(ready: Ready, draw: Random) -> Lines:
    at = ready.rest(ready.base.stranger)
    height = draw.uniform(0.1, 0.3)
    return moved(at, aside(at, -draw.uniform(0, 0.06), 0.0), lift=height, by=height)


def _and_back(ready: Ready, draw: Random) -> Lines:
    at = ready.rest(ready.base.stranger)
    return *taken(at), go([*at[:2], at[2] + draw.uniform(0.05, 0.15)], 0.1), *put(at)


def _onto_the_place(ready: Ready, draw: Random) -> str:
    at, place = ready.rest(ready.base.stranger), ready.rest(ready.base.place)
    corner = [place[0] - draw.uniform(0.07, 0.095), place[1] - draw.uniform(0.07, 0.095), place[2] + at[2] + 0.005]
    return at_some_time(ready, draw, moved(at, corner, lift=0.3))


def _support_moved(ready: Ready, draw: Random) -> str:
    at = ready.rest(ready.base.place)
    lines = moved(at, aside(at, draw.uniform(0.009, 0.02), -draw.uniform(0, 0.01)), lift=0.05)
    return ready.script.within(ready.script.origins()[0], excursion(lines)).text


def _wrong_thing(ready: Ready, draw: Random) -> str:
    """Send the hand to the stranger instead of the other thing; the rest of the program is unchanged."""
    at = ready.rest(ready.base.stranger)
    script = ready.script.after("Grasping/transfer", [go([*at[:2], at[2] + 0.15])], 0)
    for name, height in (("approach", draw.uniform(-0.005, 0.005)), ("lift", 0.1)):
        script = _sent(script, name, [*at[:2], at[2] + height])
    return script.text


def _sent(script: Script, name: str, at: list[float]) -> Script:
    variable = next(v for v in script.variables(f"{name}_pose") if "grasp" in v or "picking" in v)
    return script.with_numbers(variable, lambda pose: [*at, *pose[3:]])


def stranger_moved(seen: Seen) -> str:
    """Say how far the stranger came, if that is far."""
    far = tracks.moved(seen.run, seen.base.stranger)
    return f"'{seen.base.stranger}' was moved by {1000 * far:.0f} mm" if far > HARMED else ""


def stranger_fell(seen: Seen) -> str:
    """Say how deep the stranger fell, if that is deep."""
    deep = tracks.fell(seen.run, seen.base.stranger)
    return f"'{seen.base.stranger}' fell {1000 * deep:.0f} mm" if deep > HARMED else ""


def _support_shifted(seen: Seen) -> str:
    far = tracks.moved(seen.run, seen.base.place)
    return f"'{seen.base.place}' was moved by {1000 * far:.0f} mm" if far > 0.006 else ""


RULES: tuple[Rule, ...] = (
    rule(
        "stranger_carried",
        "A",
        "what no task names is taken and put elsewhere",
        "stranger",
        visiting(_carried),
        stranger_moved,
    ),
    rule(
        "stranger_dropped",
        "A",
        "what no task names is lifted and let go of",
        "stranger",
        visiting(_dropped),
        stranger_fell,
        times=1,
    ),
    rule(
        "stranger_and_back",
        "A",
        "what no task names is lifted and put back",
        "stranger",
        visiting(_and_back),
        stranger_moved,
        times=1,
    ),
    rule(
        "stranger_onto_place",
        "A",
        "it is put where the other is to go",
        "shelf fragile",
        _onto_the_place,
        stranger_moved,
    ),
    rule(
        "support_moved",
        "A",
        "the lower block is gripped and shifted first",
        "stack",
        _support_moved,
        _support_shifted,
        "lower",
        times=4,
    ),
    rule(
        "wrong_thing",
        "A",
        "the stranger is taken for the other",
        "lifted",
        _wrong_thing,
        stranger_moved,
        "Grasping",
        times=1,
    ),
)
