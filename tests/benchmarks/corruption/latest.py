"""Rules of the latest set: sequences, waypoints and openings that change the effect of a program, and harmless ones that
resemble them.

They were written and committed before any validator was asked, from the tasks' meaning alone.
"""

from __future__ import annotations

from random import Random

import numpy as np

from . import tracks
from .bases import Ready
from .harmless import SAME
from .meanings import not_caught
from .order import closing_of, fell, not_where_it_was
from .rule import Rule, Seen, rule
from .sealed import stranger_touched
from .snippets import SHUT, above, aside, excursion, fingers, go, wait
from .strangers import at_some_time

QUICK = "shelf basket drawer push"
"""Bases that run in seconds, one of each kind."""

TOOL_SPEED = 1.5
"""Highest speed of the tool in the robot's safety settings as delivered [m/s]."""


def _retreat_slanted(ready: Ready, draw: Random) -> str:
    """Move the hand away sideways and hardly upwards, so that a finger takes the released thing along."""
    axis = tracks.closing_axis(ready.run, tracks.release(ready.run, ready.base.held))
    far, side = draw.uniform(0.07, 0.1), draw.choice((-1, 1))
    out = aside(above(ready.release, draw.uniform(0.01, 0.02)), side * far * axis[0], side * far * axis[1])
    script = ready.script
    retreat = next(o for o in script.origins() if o.endswith("Retracting/back"))
    return script.coded(retreat, [go(out, 0.1), go(above(out, 0.12), 0.1)]).text


def _pour_cut_short(ready: Ready, draw: Random) -> str:
    """The tilt ends early and nobody waits for the flow."""
    script = ready.script
    tilt = script.code("Pouring/tilt")
    kept = tilt[: round(len(tilt) * draw.uniform(0.2, 0.45))]
    return script.coded("Pouring/tilt", kept).coded("Pouring/flow", [wait(0.05)]).text


def _raced(ready: Ready, draw: Random) -> str:
    """One move with the hand through free space is asked for at twice the robot's speed or more."""
    name = next(o for o in reversed(ready.script.origins()) if o.endswith(("/transfer", "/park")))
    new = f"a={draw.uniform(25, 40):.1f}, v={draw.uniform(6.0, 9.0):.2f}"
    return ready.script.substituted(name, r"a=1\.4, v=1\.05", new).text


def _push_askew(ready: Ready, draw: Random) -> str:
    """The end of the push is told 25 to 35 mm to a side."""
    far = draw.choice((-1, 1)) * draw.uniform(0.025, 0.035)
    names = ready.script.variables("(push|back)_pose")
    script = ready.script
    for name in names:
        script = script.with_numbers(name, lambda pose: aside(pose, 0.0, far))
    return script.text


def _hand_full(ready: Ready, draw: Random) -> str:
    """Grip and lift the tin first, and open the drawer with the same hand then."""
    script = ready.script
    opening, grip, lift = (script.lines[script.section(n)] for n in (1, 2, 3))
    place = slice(script.section(1).start, script.section(3).stop)
    script = script.spliced(place, (*grip, *lift, *opening))
    height = draw.uniform(0.0, 0.05)
    return script.with_numbers(script.variables("lift_pose")[0], lambda pose: above(pose, height)).text


def _opened_again(ready: Ready, draw: Random) -> str:
    """Open the shut drawer once more at last, by a part of its way or all of it."""
    script = ready.script
    part = draw.uniform(0.4, 1.0)
    at, end = (script.numbers(script.variables(f"opening_1_{n}_pose")[0]) for n in ("approach", "pull"))
    there = [a + part * (b - a) for a, b in zip(at, end, strict=True)]
    code = [line for n in ("open", "transfer", "approach", "close", "pull", "release") for line in
            script.code(f"1.Opening/{n}")]  # fmt: skip
    pose = ", ".join(f"{n:.6f}" for n in there)
    lines = [line.replace("motion_1", "motion_9").replace("opening_1_pull_pose", f"p[{pose}]") for line in code]
    back = go([there[0] - 0.08, *there[1:]], 0.1)
    return script.after("6.Closing/back", [*lines, back]).text


def _opens_against(ready: Ready, draw: Random) -> str:
    """Bring closed fingers down beside a thing that no task names, and shove it by opening them."""
    at = aside(ready.rest(ready.base.stranger), 0.0, -draw.uniform(0.045, 0.05))
    lines = fingers(SHUT), go(above(at, 0.15)), go(at, 0.1), fingers(0), wait(0.3), go(above(at, 0.15), 0.1)
    return at_some_time(ready, draw, lines)


def _pressed_to_stop(ready: Ready, draw: Random) -> str:
    """The shut drawer is pressed to its stop with four times the force or more."""
    force = draw.uniform(40, 50)
    return ready.script.substituted("Closing/press", r"0\.015, 10\.0, 12\.0", f"0.015, {force:.1f}, 12.0").text


def _pressed_on_stranger(ready: Ready, draw: Random) -> str:
    """Press the held thing down on a thing that no task names, on the way to its place."""
    over = above(ready.rest(ready.base.stranger), draw.uniform(0.13, 0.15))
    force = draw.uniform(8, 15)
    down = f'  move_until_contact([0.0, 0.0, -1.0], 0.100, 0.02, {force:.1f}, 15.0, "any", "press")'
    return ready.script.after("PickingUp/lift", excursion([go(over), down, go(over, 0.1)])).text


def _grip_off(ready: Ready, draw: Random) -> str:
    """The pose of the grasp is told 25 mm along the line between the pads: a finger comes down where the thing is."""
    axis = tracks.closing_axis(ready.run, int(tracks.held(ready.run, ready.base.held).argmax()))
    far = draw.choice((-1, 1)) * draw.uniform(0.023, 0.027)
    script = ready.script
    name = script.variables(r"grasping_\d_approach_pose")[0]
    lines = [go(aside(above(script.numbers(name), 0.1), far * axis[0], far * axis[1]), 0.2)]
    script = script.after(closing_of(script).replace("/close", "/transfer"), lines)
    return script.with_numbers(name, lambda pose: aside(pose, far * axis[0], far * axis[1])).text


def _retreat_in_two(ready: Ready, draw: Random) -> str:
    """The hand goes straight up in two moves, with a rest between them."""
    script, up = ready.script, draw.uniform(0.03, 0.09)
    retreat = next(o for o in script.origins() if o.endswith("Retracting/back"))
    return script.within(retreat, [go(above(ready.release, up), 0.08), wait(draw.uniform(0.1, 0.4))]).text


def _flows_longer(ready: Ready, draw: Random) -> str:
    return ready.script.coded("Pouring/flow", [wait(draw.uniform(1.5, 3.0))]).text


def _quicker(ready: Ready, draw: Random) -> str:
    """One move through free space is a little quicker, well within the robot's limits."""
    name = next(o for o in reversed(ready.script.origins()) if o.endswith(("/transfer", "/park")))
    return ready.script.substituted(name, r"v=1\.05", f"v={draw.uniform(1.1, 1.2):.3f}").text


def _opens_beside(ready: Ready, draw: Random) -> str:
    """Bring the fingers down beside a thing that no task names, and open them where they do not reach it."""
    at = aside(ready.rest(ready.base.stranger), 0.0, -draw.uniform(0.11, 0.13))
    lines = fingers(SHUT), go(above(at, 0.15)), go(at, 0.1), fingers(0), wait(0.3), go(above(at, 0.15), 0.1)
    return at_some_time(ready, draw, lines)


def _pressed_less(ready: Ready, draw: Random) -> str:
    new = f"0.015, {draw.uniform(7.0, 9.5):.1f}, 12.0"
    return ready.script.substituted("Closing/press", r"0\.015, 10\.0, 12\.0", new).text


def _after_release(seen: Seen) -> str:
    """Say how far the thing went after its first release, if that is far, or that it fell over."""
    last = tracks.release(seen.ready.run, seen.base.held)
    way = tracks.way(seen.run, seen.base.held)[last - tracks.SETTLED + 5 :]
    far = float(np.linalg.norm(way - way[0], axis=1).max())
    return f"'{seen.base.held}' was moved by {1000 * far:.0f} mm after its release" if far > 0.015 else ""


def _too_fast(seen: Seen) -> str:
    """Say how fast the tool was, if faster than it may be."""
    tool, before = tracks.speed(seen.run), tracks.speed(seen.ready.run)
    return f"the tool went at {tool:.2f} m/s" if tool > TOOL_SPEED and tool > 1.2 * before else ""


def _askew(seen: Seen) -> str:
    angle = tracks.spun(seen.run, seen.ready.run, seen.base.held)
    turned = f"'{seen.base.held}' ended turned by {angle:.0f} deg" if angle > 12 else ""
    return turned or not_where_it_was(seen)


def _open_at_last(seen: Seen) -> str:
    left = abs(tracks.value(seen.run, "drawer") - tracks.value(seen.ready.run, "drawer"))
    return f"'drawer' was left open by {1000 * left:.0f} mm" if left > 0.03 else ""


def _drawer_pressed(seen: Seen) -> str:
    force, before = (float(tracks.press(r, "effector", "drawer").max()) for r in (seen.run, seen.ready.run))
    return f"'drawer' was pressed with {force:.0f} N" if force > 25 and force > 1.3 * before else ""


def _stranger_pressed(seen: Seen) -> str:
    force = float(tracks.press(seen.run, seen.base.held, seen.base.stranger).max())
    return f"'{seen.base.stranger}' was pressed with {force:.0f} N" if force > 5 else ""


def _hit_by_finger(seen: Seen) -> str:
    """Say with which force the hand hit the thing before it held it."""
    held = int(tracks.held(seen.run, seen.base.held).argmax()) or len(seen.run.times)
    force = float(tracks.press(seen.run, "effector", seen.base.held)[: max(held - 10, 1)].max())
    return f"'{seen.base.held}' was hit with {force:.0f} N" if force > 15 else ""


def _not_too_fast(seen: Seen) -> str:
    return _too_fast(seen) or SAME(seen)


RULES: tuple[Rule, ...] = (
    rule("retreat_slanted", "B", "the retreat takes along what was let go of", "shelf stack", _retreat_slanted,
         _after_release, "Retracting Placing Releasing"),
    rule("pour_cut_short", "E", "the vessel is turned back before all has left", "pour", _pour_cut_short, not_caught,
         "Pouring bowl"),
    rule("raced", "D", "one move is faster than the robot may be", QUICK, _raced, _too_fast, "speed m/s rad/s", times=1),
    rule("push_askew", "E", "the push ends 25 mm to a side", "push", _push_askew, _askew, "Pushing"),
    rule("hand_full", "B", "a full hand opens the drawer", "drawer", _hand_full, fell, "Opening PickingUp order"),
    rule("opened_again", "B", "what was shut is opened again", "drawer", _opened_again, _open_at_last,
         "drawer Closing"),
    rule("opens_against", "A", "opening fingers shove what no task names", QUICK, _opens_against, stranger_touched,
         "bystander", times=1),
    rule("pressed_to_stop", "D", "the drawer is pressed to its stop, hard", "drawer", _pressed_to_stop,
         _drawer_pressed, "Closing drawer N"),
    rule("pressed_on_stranger", "A", "what is held is pressed upon what no task names", "shelf basket drawer",
         _pressed_on_stranger, _stranger_pressed, "PickingUp", times=1),
    rule("grip_off", "B", "a finger comes down upon what is to be gripped", "shelf basket drawer", _grip_off,
         _hit_by_finger, "Grasping", times=1),
    rule("retreat_in_two", "H", "the retreat makes a stop", "shelf basket drawer", _retreat_in_two, SAME, times=1),
    rule("flows_longer", "H", "it pours longer", "pour", _flows_longer, SAME, times=1),
    rule("quicker", "H", "one move is a little quicker", QUICK, _quicker, _not_too_fast, times=1),
    rule("opens_beside", "H", "fingers open beside what no task names", QUICK, _opens_beside, SAME, times=1),
    rule("pressed_less", "H", "the drawer is pressed with less force", "drawer", _pressed_less, SAME, times=1),
)  # fmt: skip
