"""Class B: what is let go of too late or too early, dropped, set down, dragged or taken again."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .rule import Rule, Seen, rule
from .script import Script
from .snippets import SHUT, USUAL_GRIP, WIDE, above, aside, fingers, go, wait

FREE_SPOT = (0.55, 0.02)
"""Place on the floor where nothing stands in the scenarios whose things stand on it [m]."""

OPENS = {"placed": "Releasing/open", "dropped": "Ungrasping/open", "hang": "Releasing/open"}
"""Ending of the origin of the step that lets go, by what a base is."""


def opening(ready: Ready) -> str:
    """Name the step that lets go of what is held."""
    script = ready.script
    return next(o for o in script.origins() for word in ready.base.is_a & OPENS.keys() if o.endswith(OPENS[word]))


def closing_of(script: Script) -> str:
    """Name the step that grips the payload: that of a Grasping, if there is one."""
    found = [o for o in script.origins() if o.endswith("/close")]
    return next((o for o in found if o.endswith("Grasping/close")), found[0])


def _late_open(ready: Ready, draw: Random) -> str:
    """Move the line that opens the hand behind the retreat, with its comment or without; a pause stands in its old place."""
    script, name = ready.script, opening(ready)
    code = script.code(name)
    if draw.random() < 0.5:
        comment = script.lines[script.block(name).start]
        return script.without(name).after("Retracting/back", [comment, *code]).text
    return script.coded(name, [wait(draw.uniform(0.3, 0.8))]).after("Retracting/back", code).text


def _early_open(ready: Ready, draw: Random) -> str:
    """The fingers open over the place; the motion down then expects no contact."""
    lower = ready.script.numbers(ready.script.variables("lower_pose")[0])
    lines = [go(above(lower, draw.uniform(0.03, 0.06))), fingers(WIDE), wait(0.3)]
    return (
        ready.script.substituted("PuttingDown/lower", '"contact"', '"any"').within("PuttingDown/lower", lines).text
    )


def _drop_and_retake(ready: Ready, draw: Random) -> str:
    grasp, lift = ready.grasp, ready.script.variables("lift_pose")[0]
    high = above(grasp, draw.uniform(0.03, 0.06))
    lines = (
        go(high),
        fingers(WIDE),
        wait(0.6),
        go(grasp, 0.1),
        fingers(SHUT, USUAL_GRIP),
        f"  movel({lift}, a=0.5, v=0.1)",
    )
    return ready.script.after("PickingUp/lift", lines).text


def _set_down(ready: Ready, draw: Random) -> str:
    grasp = ready.grasp
    spot = [FREE_SPOT[0] + draw.uniform(-0.04, 0.04), FREE_SPOT[1] + draw.uniform(-0.04, 0.02), *grasp[2:]]
    down = go(above(spot, 0.1)), go(spot, 0.1), fingers(WIDE), go(above(spot, 0.12)), wait(draw.uniform(0, 0.5))
    again = go(spot, 0.1), fingers(SHUT, USUAL_GRIP), go(above(spot, 0.1), 0.1)
    return ready.script.after("PickingUp/lift", (*down, *again)).text


def _dragged(ready: Ready, draw: Random) -> str:
    """Drag the held thing along its support before it is lifted, and back in half of the cases."""
    grasp = ready.grasp
    there = go(aside(grasp, draw.uniform(-0.05, 0.05), -draw.uniform(0.08, 0.16)), 0.06)
    lines = [there, go(grasp, 0.06)] if draw.random() < 0.5 else [there]
    return ready.script.after("Grasping/payload", lines, 0).text


def _retaken(ready: Ready, draw: Random) -> str:
    """Grip the placed thing again and put it beside its place: 30 to 50 mm on a shelf, 8 to 14 on a block."""
    far = draw.uniform(0.008, 0.014) if "stack" in ready.base.is_a else draw.uniform(0.03, 0.05)
    at = ready.release
    to = aside(at, far * draw.choice((-1, 1)), 0.0)
    up = go(at, 0.1), fingers(SHUT, USUAL_GRIP), go(above(at, 0.04), 0.1)
    down = go(above(to, 0.04)), go(above(to, 0.001), 0.05), fingers(WIDE), go(above(to, 0.12), 0.1)
    return ready.script.after("Retracting/back", (*up, *down)).text


def _pulled_along(ready: Ready, draw: Random) -> str:
    at = ready.release
    to = aside(at, -draw.uniform(0.02, 0.045), 0.0)
    lines = go(at, 0.05), fingers(SHUT, USUAL_GRIP), go(to, 0.04), fingers(0), go(aside(to, -0.12, 0.0), 0.1)
    return ready.script.after("Retracting/back", lines).text


def _lifted_last(ready: Ready, draw: Random) -> str:
    """Carry the thing to its place, back to where it was to be lifted, and to its place again; the lift may end lower."""
    script, lift = ready.script, ready.script.variables("lift_pose")[0]
    over = next(o for o in script.origins() if o.endswith(("PuttingDown/transfer", "Ungrasping/transfer")))
    moved = script.lines[script.block("PickingUp/lift")]
    less = draw.uniform(0.0, 0.03)
    later = script.without("PickingUp/lift").after(over, moved)
    return later.with_numbers(lift, lambda pose: above(pose, -less)).text


def fell(seen: Seen) -> str:
    """Say how deep the held thing fell, if 25 mm more than in the program as it was."""
    deep, before = (tracks.fell(run, seen.base.held) for run in (seen.run, seen.ready.run))
    return f"'{seen.base.held}' fell {1000 * deep:.0f} mm" if deep > before + 0.025 else ""


def held_again(seen: Seen) -> str:
    """Say how many times the thing was held, if more often than in the unchanged program."""
    times, before = (tracks.holds(run, seen.base.held) for run in (seen.run, seen.ready.run))
    return f"'{seen.base.held}' was held {times} times" if times > before else ""


def _along(seen: Seen) -> str:
    """Way along the floor, held and pressed on it."""
    way = tracks.way(seen.run, seen.base.held)
    low = way[way[:, 2] < way[0, 2] + 0.004]
    far = float(abs(low[:, :2] - low[0, :2]).max())
    return f"'{seen.base.held}' was drawn {1000 * far:.0f} mm along what it stood on" if far > 0.05 else ""


def _went_back(seen: Seen) -> str:
    """Say how far from its place the thing was brought again, after it had been over that."""
    way = tracks.way(seen.run, seen.base.held)[:, :2]
    far = ((way - way[-1]) ** 2).sum(axis=1) ** 0.5
    over = int((far < 0.05).argmax())
    return (
        f"'{seen.base.held}' was brought {1000 * far[over:].max():.0f} mm away again"
        if far[over:].max() > 0.15
        else ""
    )


def not_where_it_was(seen: Seen) -> str:
    """Say how far from its place the held thing ended, if more than 15 mm."""
    far = tracks.apart(seen.run, seen.ready.run, seen.base.held)
    return f"'{seen.base.held}' ended {1000 * far:.0f} mm from its place" if far > 0.015 else ""


RULES: tuple[Rule, ...] = (
    rule(
        "late_open",
        "B",
        "the fingers open behind the retreat",
        "placed dropped hang",
        _late_open,
        lambda s: fell(s) or held_again(s) or not_where_it_was(s),
        "Releasing Ungrasping Placing Retracting",
    ),
    rule(
        "early_open",
        "B",
        "the fingers open over the place",
        "placed",
        _early_open,
        fell,
        "PuttingDown Releasing Placing",
    ),
    rule(
        "drop_and_retake",
        "B",
        "it is dropped and gripped again",
        "lifted shake",
        _drop_and_retake,
        held_again,
        "PickingUp Grasping",
    ),
    rule(
        "set_down_on_way",
        "B",
        "it is set down on the way",
        "shelf stack fragile basket",
        _set_down,
        held_again,
        "PickingUp Placing",
    ),
    rule(
        "dragged_along",
        "B",
        "it is drawn along before it is lifted",
        "shelf stack fragile basket",
        _dragged,
        _along,
        "Grasping PickingUp",
    ),
    rule(
        "retaken_after_placing",
        "B",
        "it is taken again and put elsewhere",
        "shelf stack fragile",
        _retaken,
        held_again,
        "Placing ParkingArms Retracting",
    ),
    rule(
        "pulled_along_peg",
        "B",
        "it is gripped again and pulled along its peg",
        "hang",
        _pulled_along,
        held_again,
        "Retracting ParkingArms Releasing",
        times=4,
    ),
    rule(
        "lift_behind_transfer",
        "B",
        "the lift stands behind the way to the place",
        "shelf stack fragile basket drawer",
        _lifted_last,
        _went_back,
        "order PickingUp Placing Ungrasping",
        times=1,
    ),
)
