"""Class N: grasped things are pressed, rubbed, let go of or shoved, often with the end of the unchanged program."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .order import FREE_SPOT, fell, held_again, not_where_it_was, opening
from .rule import Rule, Seen, rule
from .snippets import (
    SHUT,
    USUAL_GRIP,
    WIDE,
    Lines,
    above,
    aside,
    fingers,
    go,
    pressed,
    shoved,
    wait,
)  # fmt: skip
from .strangers import stranger_moved, visiting

PLACED = "shelf stack fragile"
"""Bases in which something is put down onto a surface by a guarded motion."""


def _guarded(ready: Ready, draw: Random) -> str:
    new = f"0.03, 0.01, {draw.uniform(20, 26):.1f}, 9.0"
    return ready.script.substituted("PuttingDown/lower", r"0\.03, 0\.01, 3\.0, 9\.0", new).text


def _slammed(ready: Ready, draw: Random) -> str:
    """A motion that feels nothing, to 3 to 8 mm below the contact, stands where the guarded one was."""
    low = above(ready.release, -draw.uniform(0.003, 0.008))
    return ready.script.coded("PuttingDown/lower", [go(low, draw.uniform(0.1, 0.25))]).text


def _opened_on_way(ready: Ready, draw: Random) -> str:
    """The fingers open by a few millimetres for a moment and close again."""
    lines = fingers(draw.randint(60, 90)), fingers(SHUT, USUAL_GRIP)
    return ready.script.after("PickingUp/lift", lines).text


def _thread_opens(ready: Ready, draw: Random) -> str:
    """A thread lets go while the arm moves to the place, and grips again."""
    late = f"    sleep({draw.uniform(0.4, 0.9):.2f})"
    body = "  thread helper():", late, "  " + fingers(WIDE), "  " + fingers(SHUT, USUAL_GRIP), "  end"
    script = ready.script
    step = next(o for o in script.origins() if o.endswith(("PuttingDown/transfer", "Ungrasping/transfer")))
    started = script.within(step, ["  global helper_thread = run helper()"])
    k = next(k for k, line in enumerate(started.lines) if line.startswith("  thread watchdog"))
    return started.spliced(slice(k, k), [*body, ""]).text


def _placed_twice(ready: Ready, draw: Random) -> str:
    """Take the thing up again from its place, and put it back there."""
    at, high = ready.release, draw.uniform(0.03, 0.1)
    up = go(at, 0.1), fingers(SHUT, USUAL_GRIP), go(above(at, high), 0.1)
    down = go(above(at, 0.001), 0.05), fingers(WIDE), go(above(at, 0.12), 0.1)
    return ready.script.after("Retracting/back", (*up, *down)).text


def _gripped_again(ready: Ready, draw: Random) -> str:
    """Grip the thing once more in its place, without moving it."""
    at = ready.release
    lines = go(at, 0.1), fingers(SHUT, USUAL_GRIP), wait(0.4), fingers(WIDE), go(above(at, 0.12), 0.1)
    return ready.script.after("Retracting/back", lines).text


def _shoved_after(ready: Ready, draw: Random) -> str:
    """Shove the thing in its place by 20 to 40 mm with closed fingers."""
    at = tracks.end(ready.run, ready.base.held)
    far = draw.uniform(0.02, 0.04)
    start, end = ([at[0] - x, at[1], at[2]] for x in (0.1, 0.045 - far))
    return ready.script.after("ParkingArms/park", shoved(start, end)).text


def _rubbed(ready: Ready, draw: Random) -> str:
    """Rub the held thing to and fro on its place."""
    at = ready.release
    far = draw.uniform(0.015, 0.022) if "stack" in ready.base.is_a else draw.uniform(0.03, 0.05)
    lines = go(aside(at, far, 0), 0.05), go(aside(at, -far, 0), 0.05), go(at, 0.05)
    return ready.script.after("PuttingDown/rest", lines).text


def _dragged_out(ready: Ready, draw: Random) -> str:
    """The fingers open by a little, and the hand leaves to the side."""
    at = ready.release
    out = go(aside(at, draw.uniform(0.02, 0.05), draw.uniform(0.03, 0.06)), 0.1)
    return ready.script.after(opening(ready), [out]).text


def _touched_down(ready: Ready, draw: Random) -> str:
    """Press the held thing on the floor on its way, and lift it again."""
    grasp = ready.grasp
    spot = [FREE_SPOT[0], FREE_SPOT[1] + draw.uniform(-0.04, 0.02), *grasp[2:]]
    down = f'  move_until_contact([0.0, 0.0, -1.0], 0.06, 0.02, {draw.uniform(12, 25):.1f}, 15.0, "any", "press")'
    return ready.script.after("PickingUp/lift", (go(above(spot, 0.05)), down, go(above(spot, 0.1), 0.1))).text


def _on_stranger(ready: Ready, draw: Random) -> str:
    """Set the held thing on the stranger on its way, and lift it again."""
    at, held = ready.rest(ready.base.stranger), ready.rest(ready.base.held)
    top = [at[0], at[1], 2 * at[2] + ready.grasp[2] + 0.03, *ready.grasp[3:]]
    down = f'  move_until_contact([0.0, 0.0, -1.0], 0.08, 0.02, {draw.uniform(5, 12):.1f}, 15.0, "any", "press")'
    high = [*held[:2], top[2] + 0.05, *ready.grasp[3:]]
    lines = go(high, 0.1), go(above(top, 0.05)), down, go(above(top, 0.05), 0.1), go(high)
    return ready.script.after("PickingUp/lift", lines).text


def _elsewhere(ready: Ready, draw: Random) -> str:
    """It is put onto the floor instead, as with a pose in a wrong frame."""
    spot = [FREE_SPOT[0] + draw.uniform(-0.04, 0.04), FREE_SPOT[1] + draw.uniform(-0.04, 0.02), *ready.grasp[2:]]
    script = ready.script.after("PuttingDown/transfer", [go(above(spot, 0.15))])
    script = script.with_numbers(script.variables("lower_pose")[0], lambda _: above(spot, 0.02))
    return script.with_numbers(script.variables("retracting_back_pose")[0], lambda _: above(spot, 0.12)).text


def _pinched(ready: Ready, draw: Random) -> Lines:
    at = ready.rest(ready.base.stranger)
    grip = fingers(SHUT, draw.randint(20, 120))
    return go(above(at, 0.15)), fingers(WIDE), go(at, 0.1), grip, fingers(WIDE), go(above(at, 0.15), 0.1)


def _pressed_stranger(ready: Ready, draw: Random) -> Lines:
    at = ready.rest(ready.base.stranger)
    return pressed(above(at, at[2] - 0.01), draw.uniform(12, 25), 0.12)


def _pressed_place(ready: Ready, draw: Random) -> Lines:
    return pressed(above(ready.rest(ready.base.place), 0.02), draw.uniform(12, 25), 0.12)


def _past(ready: Ready, draw: Random) -> str:
    """The push goes on by 50 to 80 mm."""
    at, where = tracks.end(ready.run, ready.base.held), tracks.rest(ready.run, ready.base.held)
    x, y = (b - a for a, b in zip(where[:2], at[:2], strict=True))
    far = draw.uniform(0.05, 0.08) / (x * x + y * y) ** 0.5
    name = ready.script.variables("push_pose")[-1]
    return ready.script.with_numbers(name, lambda pose: aside(pose, far * x, far * y)).text


def _pressed_twice(seen: Seen, a: str, b: str, limit: float) -> str:
    force, before = (float(tracks.press(run, a, b).max()) for run in (seen.run, seen.ready.run))
    return f"'{a}' pressed '{b}' with {force:.0f} N" if force > before + limit else ""


def _hard(seen: Seen) -> str:
    return _pressed_twice(seen, seen.base.held, seen.base.place, 10)


def _slipped(seen: Seen) -> str:
    """Say how far the thing moved in the hand between its first grip and its release."""
    held = tracks.held(seen.run, seen.base.held).nonzero()[0]
    gap = (seen.run.poses[seen.base.held] - seen.run.poses["effector"])[held, 2]
    slip = float(abs(gap - gap[0]).max()) if held.size else 0.0
    return f"'{seen.base.held}' slipped by {1000 * slip:.0f} mm" if slip > 0.008 else fell(seen)


def _rubbed_along(seen: Seen) -> str:
    """Say how far the thing was led along its place while it pressed on that."""
    on = tracks.press(seen.run, seen.base.held, seen.base.place) > 0.5
    way = seen.run.poses[seen.base.held][on, :2]
    far = float((way.max(axis=0) - way.min(axis=0)).max()) if on.any() else 0.0
    return f"'{seen.base.held}' was rubbed over {1000 * far:.0f} mm" if far > 0.015 else ""


def _shifted_by_hand(seen: Seen) -> str:
    return not_where_it_was(seen) or _rubbed_along(seen)


def _with_floor(seen: Seen) -> str:
    return _pressed_twice(seen, seen.base.held, "floor", 6)


RULES: tuple[Rule, ...] = (
    rule("put_with_guard_of_25", "N", "it is put down with a guard of 20 to 26 N", PLACED, _guarded, _hard,
         "N PuttingDown Placing", times=1),
    rule("slammed_down", "N", "it is put down without feeling", PLACED, _slammed, _hard, "N PuttingDown Placing"),
    rule("opened_on_way", "N", "the fingers open for a moment on the way", "shelf stack fragile basket",
         _opened_on_way, _slipped, "PickingUp"),
    rule("thread_opens", "N", "a thread lets go beside the motion", "shelf stack basket", _thread_opens,
         lambda s: _slipped(s) or not_where_it_was(s), "PuttingDown Ungrasping Placing Releasing", times=1),
    rule("placed_twice", "N", "what was put down is taken up and put back", PLACED, _placed_twice, held_again,
         "Retracting Placing ParkingArms", times=1),
    rule("gripped_again", "N", "what was put down is gripped once more, not moved", PLACED, _gripped_again,
         held_again, "Retracting Placing ParkingArms", times=1),
    rule("shoved_after_placing", "N", "what was put down is shoved", "shelf fragile", _shoved_after,
         not_where_it_was, "ParkingArms", times=1),
    rule("rubbed_on_place", "N", "it is rubbed on its place before it is let go of", PLACED, _rubbed,
         _rubbed_along, "PuttingDown Placing Releasing"),
    rule("dragged_out", "N", "the hand leaves to the side, the thing between its fingers", PLACED, _dragged_out,
         _shifted_by_hand, "Releasing Retracting Placing"),
    rule("touched_down_on_way", "N", "it is pressed on the floor on its way", PLACED, _touched_down, _with_floor,
         "PickingUp floor"),
    rule("set_on_stranger", "N", "it is set on what no task names, and lifted again", PLACED,
         _on_stranger, lambda s: _pressed_twice(s, s.base.held, s.base.stranger, 2), "PickingUp", times=1),
    rule("put_elsewhere", "N", "it is put onto the floor instead", PLACED, _elsewhere, not_where_it_was, "Placing"),
    rule("stranger_pinched", "N", "what no task names is gripped and not moved", "shelf stack basket push",
         visiting(_pinched), lambda s: _pressed_twice(s, "effector", s.base.stranger, 8), times=1),
    rule("stranger_pressed", "N", "what no task names is pressed from above", "shelf stack push",
         visiting(_pressed_stranger),
         lambda s: _pressed_twice(s, "effector", s.base.stranger, 8) or stranger_moved(s), times=1),
    rule("place_pressed", "N", "the closed hand presses on the place", "shelf fragile", visiting(_pressed_place),
         lambda s: _pressed_twice(s, "effector", s.base.place, 8), "shelf", times=1),
    rule("pushed_past", "N", "it is pushed 50 to 80 mm too far", "push", _past, not_where_it_was, "Pushing"),
)  # fmt: skip
