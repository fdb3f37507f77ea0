"""Sealed harmless edits: judged once, at the end, as the sealed corruptions are; whoever changes a validator does not look in here."""

from __future__ import annotations

import re
from random import Random

from msgspec.structs import replace

from .bases import Ready
from .harmless import SAME
from .rule import Rule, rule
from .script import STEP
from .snippets import above, go, wait


def _folded(ready: Ready, draw: Random) -> str:
    """A pose stands where it is used, not in a variable."""
    script = ready.script
    variable = draw.choice(script.variables("(approach|lift|lower|back)_pose"))
    line = next(line for line in script.lines if line.startswith(f"  global {variable} = "))
    text = script.text.replace(line + "\n", "")
    return re.sub(rf"\b{variable}\b", line.split(" = ")[1], text)


def _longer_retreat(ready: Ready, draw: Random) -> str:
    far = draw.uniform(0.01, 0.03)
    return ready.script.with_numbers(ready.script.variables("back_pose")[-1], lambda pose: above(pose, far)).text


def _via(ready: Ready, draw: Random) -> str:
    """The lift goes on by 20 to 50 mm, and the way on begins there."""
    lift = ready.script.numbers(ready.script.variables("lift_pose")[0])
    return ready.script.after("PickingUp/lift", [go(above(lift, draw.uniform(0.02, 0.05)), 0.1)]).text


def _payload_later(ready: Ready, draw: Random) -> str:
    """The payload is told behind the wait, or the wait behind the payload: lines that do not depend on each other."""
    code = ready.script.code("Grasping/payload", 0)
    return ready.script.coded("Grasping/payload", [wait(draw.uniform(0.1, 0.4)), *code], 0).text


def _step_comment_removed(ready: Ready, draw: Random) -> str:
    """Delete a step's comment; its code then stands under the comment before."""
    lines = ready.script.lines
    places = [k for k, line in enumerate(lines) if STEP.match(line) and not lines[k - 1].startswith("  # ----")]
    k = draw.choice(places)
    return ready.script.spliced(slice(k, k + 1), ()).text


HARMLESS: tuple[Rule, ...] = (
    rule(
        "folded",
        "H",
        "a pose stands where it is used",
        "shelf drawer basket fetch door lid",
        _folded,
        SAME,
        times=1,
    ),
    rule(
        "longer_retreat", "H", "the hand retreats farther", "shelf stack lid basket", _longer_retreat, SAME, times=1
    ),
    rule("via_point", "H", "the way has a further point", "shelf stack basket", _via, SAME, times=1),
    rule(
        "payload_later", "H", "the payload is told later", "stack fragile drawer lid", _payload_later, SAME, times=1
    ),
    rule(
        "step_comment_removed",
        "H",
        "a step's comment is gone",
        "shelf knob fetch",
        _step_comment_removed,
        SAME,
        times=1,
    ),
)

RULES: tuple[Rule, ...] = tuple(replace(r, sealed=True) for r in HARMLESS)
