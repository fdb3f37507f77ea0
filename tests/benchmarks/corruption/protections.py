"""Class N: protections that a text switches off, and states in which it leaves the arm; motions are unchanged.

What these edits do is no harm in the run itself: an oracle only asks that the thing ended where it did.
"""

from __future__ import annotations

import re
from random import Random

from . import tracks
from .bases import Ready
from .order import closing_of, opening
from .rule import Edit, Oracle, Rule, Seen, rule

URSCRIPT = "shelf stack basket push"
"""Quick bases in URScript."""

GRIPPED = "shelf stack basket fragile"
"""Quick ones in which something is gripped."""


def _replaced(old: str, new: str) -> Edit:
    """Make an edit of a line of the text, by a regular expression that must be there."""

    def edit(ready: Ready, draw: Random) -> str:
        text, count = re.subn(old, new, ready.text, count=1, flags=re.MULTILINE)
        if not count:
            raise ValueError(f"'{old}' is not in the text")
        return text

    return edit


def _unexpected(ready: Ready, draw: Random) -> str:
    """Let the fingers not ask whether there is anything between them."""
    return ready.script.substituted(closing_of(ready.script), '"object"', '"any"').text


def _light(ready: Ready, draw: Random) -> str:
    """Tell the arm after the grasp that the hand is empty."""
    empty = re.findall(r"^  set_target_payload\(.*\)", ready.text, flags=re.MULTILINE)[0]
    return ready.script.coded("Grasping/payload", [empty]).text


def _kept(ready: Ready, draw: Random) -> str:
    """What the hand bore is still told after the release, or 3 kg are."""
    told = ready.script.code("Grasping/payload")[0] if draw.random() < 0.5 else _heavy()
    return ready.script.coded(opening(ready).rsplit("/", 1)[0] + "/payload", [told]).text


def _heavy() -> str:
    return "  set_target_payload(3.0, [0.0, 0.0, 0.09])"


def _untared(ready: Ready, draw: Random) -> str:
    return ready.script.coded("PuttingDown/tare", ["  sleep(0.3)"]).text


def _soft(ready: Ready, draw: Random) -> str:
    """The arm goes home with one axis that gives way."""
    axes = draw.choice(("0, 0, 1, 0, 0, 0", "0, 1, 0, 0, 0, 0"))
    limits = "[0.1, 0.1, 0.1, 0.2, 0.2, 0.2]"
    frame = "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
    line = f"  force_mode({frame}, [{axes}], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 2, {limits})"
    return ready.script.after("ParkingArms/park", [line, "  sleep(0.5)"]).text


def _free(ready: Ready, draw: Random) -> str:
    return ready.script.after("ParkingArms/park", ["  freedrive_mode()", "  sleep(0.5)"]).text


def _as_if(clause: str) -> Oracle:
    """Make an oracle of a harm that is in the text alone: the clause, if the thing came as far as before."""

    def oracle(seen: Seen) -> str:
        return clause if tracks.apart(seen.run, seen.ready.run, seen.base.held) < 0.02 else ""

    return oracle


RULES: tuple[Rule, ...] = (
    rule(
        "watchdog_killed", "N", "nobody watches the force", URSCRIPT,
        _replaced(r"(^  global watchdog_thread = run watchdog\(\))", r"\1\n  kill watchdog_thread"),
        _as_if("the force was not watched"), "watchdog force", times=1,
    ),
    rule(
        "limit_raised", "N", "the program's force limit is eight times as high", URSCRIPT,
        _replaced(r"force_limit = [1-9][\d.]*", "force_limit = 500.0"),
        _as_if("the force may be 500 N"), "force limit", times=1,
    ),
    rule(
        "start_unchecked", "N", "the program starts wherever the arm is", URSCRIPT,
        _replaced(r"^  check_start\(.*\)\n", ""), _as_if("the start was not checked"), "start", times=1,
    ),
    rule(
        "abort_goes_on", "N", "an abort writes its reason and goes on", URSCRIPT,
        _replaced(r'(textmsg\("cramlite abort: ", reason\)\n)    halt\n', r"\1"),
        _as_if("an abort did not halt"), "abort halt", times=1,
    ),
    rule(
        "failures_caught", "N", "failures are caught and forgotten", URSCRIPT,
        _replaced(r"^  global catching = False", "  global catching = True"),
        _as_if("failures were forgotten"), "fail catch", times=1,
    ),
    rule(
        "grip_unchecked", "N", "the hand does not ask whether it holds anything", GRIPPED,
        _unexpected, _as_if("an empty grip would not have been noticed"), "Grasping object", times=1,
    ),
    rule(
        "payload_untold", "N", "the payload is not told", GRIPPED,
        _light, _as_if("the payload was not told"), "payload Grasping kg", times=1,
    ),
    rule(
        "payload_kept", "N", "a payload is told that is no longer there", GRIPPED,
        _kept, _as_if("a payload was told that was not there"), "payload kg Releasing Ungrasping", times=2,
    ),
    rule(
        "untared", "N", "the sensor is not tared before it feels", "shelf stack fragile",
        _untared, _as_if("the sensor was not tared"), "tare PuttingDown", times=1,
    ),
    rule(
        "force_mode_left_on", "N", "an axis is left to give way at the end", "shelf stack basket",
        _soft, _as_if("the arm was left soft"), "force_mode ParkingArms", times=1,
    ),
    rule(
        "freedrive_left_on", "N", "the arm is left to whoever pushes it", "shelf stack basket",
        _free, _as_if("the arm was left free"), "freedrive ParkingArms", times=1,
    ),
)  # fmt: skip
