"""Class E: a goal that is all but reached: beside, half, at the edge, or undone again."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .order import not_where_it_was
from .rule import Rule, Seen, rule
from .script import Script
from .snippets import above, aside, go


def put_aside(script: Script, x: float, y: float) -> Script:
    """Shift the place at which a thing is put down; the hand goes there through the old place."""
    lower = script.numbers(script.variables("lower_pose")[0])
    shifted = script.after("PuttingDown/transfer", [go(aside(above(lower, 0.05), x, y), 0.1)])
    for ending in ("lower_pose", r"placing_(\d_)?retracting_back_pose"):
        shifted = shifted.with_numbers(shifted.variables(ending)[0], lambda pose: aside(pose, x, y))
    return shifted


def _towards(draw: Random, far: float) -> tuple[float, float]:
    return draw.choice(((far, 0.0), (-far, 0.0), (0.0, far), (0.0, -far)))


def _lid_beside(ready: Ready, draw: Random) -> str:
    return put_aside(ready.script, *_towards(draw, draw.uniform(0.03, 0.07))).text


def _at_the_edge(ready: Ready, draw: Random) -> str:
    """The centre of mass is up to 2 mm inside of the edge, which is 35 mm from the middle, or outside."""
    return put_aside(ready.script, *_towards(draw, draw.uniform(0.0332, 0.038))).text


def _and_back(ready: Ready, draw: Random) -> str:
    """After the push the hand goes round the block and pushes it back by half of the way or more."""
    at, where = tracks.end(ready.run, ready.base.held), tracks.rest(ready.run, ready.base.held)
    x, y = (b - a for a, b in zip(where[:2], at[:2], strict=True))
    far = (x * x + y * y) ** 0.5
    attitude = ready.script.numbers(ready.script.variables("push_pose")[0])[3:]
    ahead = [at[0] + 0.09 * x / far, at[1] + 0.09 * y / far, 0.05, *attitude]
    share = 0.045 - far * draw.uniform(0.5, 1.0)
    behind = [at[0] + share * x / far, at[1] + share * y / far, 0.05, *attitude]
    up = go(above([*at[:2], 0.05, *attitude], 0.12), 0.1)
    lines = up, go(above(ahead, 0.09)), go(ahead, 0.1), go(behind, 0.05), go(above(behind, 0.09), 0.1)
    return ready.script.after(draw.choice(("Pushing/push", "Retracting/back")), lines).text


def _half_shut(ready: Ready, draw: Random) -> str:
    """Push the drawer by a part of its way, and not to its stop."""
    script, less = ready.script, draw.uniform(0.05, 0.14)
    shut = script.with_numbers(script.variables("push_pose")[0], lambda pose: aside(pose, -less, 0.0))
    return shut.coded("Closing/press", ["  sleep(0.3)"]).text


def _poured_beside(ready: Ready, draw: Random) -> str:
    """Turn the arm about its base by 12 to 20 deg while it pours."""
    script, turn = ready.script, draw.choice((-1, 1)) * draw.uniform(0.2, 0.35)
    for name in script.variables(r"pouring_3_(transfer|tilt|back)_joints(_\d+)?"):
        script = script.with_numbers(name, lambda joints: [joints[0] + turn, *joints[1:]])
    return script.text


def _at_the_tip(ready: Ready, draw: Random) -> str:
    """The hole is pushed on by 8 to 20 mm instead of 70."""
    depth = f"8.0, {draw.uniform(0.008, 0.02):.4f}, 0.02"
    return ready.script.spliced(
        *_line(ready.script, "force_insert(insert_hole_onto_peg_3_push_frame", r"8.0, 0.070392, 0.02", depth)
    ).text


def _line(script: Script, start: str, old: str, new: str) -> tuple[slice, list[str]]:
    k = next(k for k, line in enumerate(script.lines) if start in line)
    return slice(k, k + 1), [script.lines[k].replace(old, new)]


def off_the_middle(seen: Seen) -> str:
    """Say how far beside the middle of its place a thing ended, if more than 20 mm."""
    a, b = tracks.end(seen.run, seen.base.held), tracks.end(seen.run, seen.base.place)
    far = ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
    return (
        f"'{seen.base.held}' ended {1000 * far:.0f} mm beside the middle of '{seen.base.place}'"
        if far > 0.02
        else ""
    )


def _went_back(seen: Seen) -> str:
    way = tracks.way(seen.run, seen.base.held)[:, :2]
    far = ((way - way[0]) ** 2).sum(axis=1) ** 0.5
    back = float(far.max() - far[-1])
    return f"'{seen.base.held}' came back by {1000 * back:.0f} mm" if back > 0.01 else ""


def still_open(seen: Seen) -> str:
    """Say how far from its stop a joint was left that should be shut."""
    left = abs(tracks.value(seen.run, "drawer") - tracks.value(seen.ready.run, "drawer"))
    return f"'drawer' stayed open by {1000 * left:.0f} mm" if left > 0.03 else ""


def not_caught(seen: Seen) -> str:
    """Say how many balls are not in the bowl, if more than one of ten."""
    count = seen.run.grains[seen.base.held].shape[1]
    there = tracks.caught(seen.run, seen.base.held, seen.base.place)
    return f"{count - there} of {count} balls are not in '{seen.base.place}'" if there < 0.9 * count else ""


def _over_the_edge(seen: Seen) -> str:
    """Say where the thing ended, if its middle is no more than 2 mm inside of the lower block's edge."""
    a, b = tracks.end(seen.run, seen.base.held), tracks.end(seen.run, seen.base.place)
    far = max(abs(a[0] - b[0]), abs(a[1] - b[1]))
    return (
        f"'{seen.base.held}' ended {1000 * far:.0f} mm beside the middle of '{seen.base.place}'"
        if far > 0.033
        else ""
    )


RULES: tuple[Rule, ...] = (
    rule(
        "lid_beside",
        "E",
        "the lid is let go of beside the pot's middle",
        "lid",
        _lid_beside,
        off_the_middle,
        "pot Placing",
        times=6,
    ),
    rule(
        "pushed_and_back",
        "E",
        "what was pushed is pushed back",
        "push",
        _and_back,
        _went_back,
        "Pushing Retracting",
        times=5,
    ),
    rule(
        "stack_at_edge",
        "E",
        "the centre of mass is over the edge of the lower block",
        "stack",
        _at_the_edge,
        _over_the_edge,
        "lower Placing",
        times=5,
    ),
    rule(
        "drawer_half_shut",
        "E",
        "the drawer is not shut",
        "drawer",
        _half_shut,
        still_open,
        "Closing drawer",
        times=4,
    ),
    rule(
        "poured_beside",
        "E",
        "the jug is turned beside the bowl",
        "pour",
        _poured_beside,
        not_caught,
        "Pouring bowl",
        times=2,
    ),
    rule(
        "hung_at_tip",
        "E",
        "the pack hangs at the peg's tip, or falls",
        "hang",
        _at_the_tip,
        not_where_it_was,
        "hook peg InsertHoleOntoPeg Releasing",
        times=3,
    ),
)
