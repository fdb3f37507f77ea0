"""Class B: things before a grip or after a release are dragged, turned, tipped or shoved by fingers that stand around them."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .harmless import as_before
from .order import closing_of, not_where_it_was
from .rule import Rule, Seen, rule
from .snippets import Pose, above, aside, fingers, go, leaning, wait

PLACED = "shelf stack fragile goals"
"""Bases in which something is put down onto a surface."""

GAP = 0.015
"""Distance between an open finger and what it let go of: half of what 80 mm are wider than 50 mm [m]."""

NEAR = 81
"""Position of the fingers at 58 mm, less than the diagonal of what they let go of [0 to 255]."""


def _across(ready: Ready, far: float) -> tuple[float, float]:
    """Part of a way along the line between the pads [m]: x and y."""
    axis = tracks.closing_axis(ready.run, tracks.release(ready.run, ready.base.held))
    return far * axis[0], far * axis[1]


def _when(draw: Random) -> str:
    """Name a step of Releasing: before the payload is told, or after it."""
    return draw.choice(("Releasing/open", "Releasing/payload"))


def _dragged(ready: Ready, draw: Random) -> str:
    """Move the hand aside, and back in half of the cases, so that one finger takes the thing along."""
    at, far = ready.release, GAP + draw.uniform(0.02, 0.04)
    out = go(aside(at, *_across(ready, far * draw.choice((-1, 1)))), draw.uniform(0.05, 0.15))
    return ready.script.after(_when(draw), [out, go(at, 0.1)] if draw.random() < 0.5 else [out]).text


def _turned(ready: Ready, draw: Random) -> str:
    """Bring the fingers nearer and turn the hand about the vertical, so that they turn the thing."""
    at = ready.release
    angle = draw.choice((-1, 1)) * draw.uniform(0.9, 1.2)
    steps = [go(leaning(at, angle * k / 4, (0, 0, 1)), 0.1) for k in range(1, 5)]
    return ready.script.after(_when(draw), [fingers(NEAR), *steps]).text


def _tipped(ready: Ready, draw: Random) -> str:
    """The hand rises and pushes at the top, until the thing falls over or has been moved."""
    high = above(ready.release, draw.uniform(0.02, 0.03))
    out = aside(high, *_across(ready, (GAP + draw.uniform(0.03, 0.05)) * draw.choice((-1, 1))))
    return ready.script.after(_when(draw), [go(high, 0.1), go(out, 0.1), go(above(out, 0.12), 0.1)]).text


def _opened_moving(ready: Ready, draw: Random) -> str:
    """A thread lets go while the hand goes aside, with it or up to 0.3 s later."""
    script, at = ready.script, ready.release
    opens = script.code("Releasing/open")
    out = go(aside(at, *_across(ready, (GAP + draw.uniform(0.02, 0.04)) * draw.choice((-1, 1)))), 0.1)
    late = f"    sleep({draw.choice((0.0, draw.uniform(0.1, 0.3))):.2f})"
    body = "  thread helper():", late, *("  " + line for line in opens), "  end"
    started = script.coded("Releasing/open", ["  global helper_thread = run helper()", out, wait(0.5)])
    k = next(k for k, line in enumerate(started.lines) if line.startswith("  thread watchdog"))
    return started.spliced(slice(k, k), [*body, ""]).text


def _dragged_first(ready: Ready, draw: Random) -> str:
    """Take the thing along with open fingers before they close on it, and lift it from there."""
    at, far = ready.grasp, GAP + draw.uniform(0.025, 0.045)
    axis = tracks.closing_axis(ready.run, int(tracks.held(ready.run, ready.base.held).argmax()))
    there = aside(at, *(far * draw.choice((-1, 1)) * n for n in axis[:2]))
    place = draw.choice(("after", "within"))
    if place == "after":
        return ready.script.after("Grasping/approach", [go(there, 0.06)]).text
    return ready.script.within(closing_of(ready.script), [go(there, 0.06)]).text


def _leaves_flat(ready: Ready, draw: Random) -> str:
    """Move the hand away level, along the released thing, and up beside it."""
    at, (x, y) = ready.release, _across(ready, draw.choice((-1, 1)) * draw.uniform(0.1, 0.12))
    out = aside(at, -y, x)
    return ready.script.within("Retracting/back", [go(out, 0.1), go(above(out, 0.1), 0.1)]).text


def _stirs(ready: Ready, draw: Random) -> str:
    """Move the open hand to and fro, as far as the fingers stay off the released thing."""
    at: Pose = ready.release
    far = draw.uniform(0.004, 0.008)
    steps = [go(aside(at, *_across(ready, d)), 0.05) for d in (far, -far)]
    turns = [go(leaning(at, d, (0, 0, 1)), 0.05) for d in (0.04, -0.04)]
    return ready.script.after("Releasing/payload", [*steps, go(at, 0.05), *turns]).text


def _nudged(ready: Ready, draw: Random) -> str:
    """Shift the released thing with a finger by about two millimetres."""
    at, far = ready.release, GAP + draw.uniform(0.001, 0.003)
    lines = [go(aside(at, *_across(ready, far * draw.choice((-1, 1)))), 0.03), go(at, 0.05)]
    return ready.script.after("Releasing/payload", lines).text


def _opens_less(ready: Ready, draw: Random) -> str:
    """The fingers open no farther than they have to."""
    return ready.script.substituted("Releasing/open", r"move_gripper\(15,", f"move_gripper({draw.randint(25, 55)},").text


def _spun(seen: Seen) -> str:
    by = tracks.spun(seen.run, seen.ready.run, seen.base.held)
    return f"'{seen.base.held}' ended turned by {by:.0f} deg" if by > 12 else ""


def _shifted(seen: Seen) -> str:
    """Say how far the fingers moved the thing after its release, where it stays or comes back."""
    way = tracks.way(seen.run, seen.base.held)[tracks.release(seen.ready.run, seen.base.held) - tracks.SETTLED + 5 :]
    far = float(((way - way[0]) ** 2).sum(axis=1).max() ** 0.5)
    return f"'{seen.base.held}' was moved by {1000 * far:.0f} mm after its release" if far > 0.015 else ""


def _toppled(seen: Seen) -> str:
    lean = tracks.turned(seen.run, seen.base.held)
    return f"'{seen.base.held}' ended leaning by {lean:.0f} deg" if lean > 30 else _shifted(seen)


def _drawn(seen: Seen) -> str:
    """Say how far the thing was moved before it was held."""
    first = int(tracks.held(seen.run, seen.base.held).argmax())
    way = seen.run.poses[seen.base.held][tracks.SETTLED : first + 1, :2]
    far = float(((way - way[0]) ** 2).sum(axis=1).max() ** 0.5)
    return f"'{seen.base.held}' was drawn {1000 * far:.0f} mm before it was held" if far > 0.02 else ""


ABOUT = "Releasing Retracting Placing release"

RULES: tuple[Rule, ...] = (
    rule("dragged_let_go", "B", "a finger takes along what was let go of", PLACED, _dragged, _shifted, ABOUT),
    rule("turned_let_go", "B", "open fingers turn what they let go of", "shelf fragile goals", _turned, _spun, ABOUT),
    rule("tipped_let_go", "B", "a finger pushes at the top of what was let go of", "shelf fragile goals", _tipped, _toppled, ABOUT),
    rule("opened_moving", "B", "the fingers open while the hand goes aside", "shelf fragile goals", _opened_moving,
         not_where_it_was, ABOUT),
    rule("dragged_first", "B", "open fingers take it along before they close", "shelf stack fragile basket goals",
         _dragged_first, _drawn, "Grasping held"),
    rule("leaves_flat", "H", "the hand leaves level, along what it let go of", "shelf fragile goals", _leaves_flat,
         as_before(0.008), times=1),
    rule("stirs", "H", "the open hand stirs around what it let go of", PLACED, _stirs, as_before(0.008), times=1),
    rule("nudged", "H", "a finger shifts what was let go of by 2 mm", "shelf fragile goals", _nudged, as_before(0.008), times=1),
    rule("opens_less", "H", "the fingers open less far", "shelf fragile goals", _opens_less, as_before(0.008), times=1),
)  # fmt: skip
