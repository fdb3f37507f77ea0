"""Class D: grips and presses that are stronger than what is handled allows, or than anybody asked for."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .order import closing_of
from .rule import Rule, Seen, rule
from .snippets import above, pressed

FRAGILE = 30.0
"""Most that a finger may press the thing of the base "fragile" with, as its scenario says [N]."""


def _strong_grip(ready: Ready, draw: Random) -> str:
    grip = draw.randint(70, 255)
    return ready.script.substituted(closing_of(ready.script), r"\(255, 157, \d+", f"(255, 157, {grip}").text


def _pressed_after(ready: Ready, draw: Random) -> str:
    """Closed fingers press from above on what has been put down."""
    at = tracks.end(ready.run, ready.base.held)
    lines = pressed(above([*at, *ready.release[3:]], 0.02), draw.uniform(25, 50), 0.12)
    return ready.script.after("Retracting/back", lines).text


def _put_hard(ready: Ready, draw: Random) -> str:
    """The motion down goes on until 30 to 50 N."""
    old, new = r"0\.03, 0\.01, 3\.0, 9\.0", f"0.03, 0.01, {draw.uniform(30, 50):.1f}, 9.0"
    return ready.script.substituted("PuttingDown/lower", old, new).text


def _too_strong(seen: Seen) -> str:
    force = max(tracks.press(seen.run, f"effector/{side}", seen.base.held).max() for side in ("left", "right"))
    return f"'{seen.base.held}' was gripped with {force:.0f} N" if force > 1.3 * FRAGILE else ""


def pressed_down(seen: Seen) -> str:
    """Say how hard the hand pressed on things that it had not grasped, if with 15 N or more."""
    loose = ~tracks.held(seen.run, seen.base.held)
    force = (tracks.press(seen.run, "effector", seen.base.held) * loose)[
        tracks.release(seen.run, seen.base.held) + 1 :
    ].max(initial=0)
    return f"'{seen.base.held}' was pressed with {force:.0f} N" if force > 15 else ""


def _put_down_hard(seen: Seen) -> str:
    force, before = (tracks.press(run, seen.base.held, seen.base.place).max() for run in (seen.run, seen.ready.run))
    return f"'{seen.base.held}' was put down with {force:.0f} N" if force > before + 15 else ""


RULES: tuple[Rule, ...] = (
    rule(
        "grip_too_strong",
        "D",
        "the fingers press a fragile thing hard",
        "fragile",
        _strong_grip,
        _too_strong,
        "grip N",
        times=5,
    ),
    rule(
        "press_after_release",
        "D",
        "the closed hand presses on what was put down",
        "placed",
        _pressed_after,
        pressed_down,
        "N Retracting ParkingArms",
    ),
    rule(
        "hard_put_down",
        "D",
        "it is pressed on its place with ten times the force",
        "placed",
        _put_hard,
        _put_down_hard,
        "N PuttingDown",
    ),
)
