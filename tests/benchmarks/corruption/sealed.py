"""Sealed rules: a third of the corpus. They are judged once, at the end, when nobody mends validators any more.

Whoever changes a validator does not look in here, and does not run these; what was tried with them is that the edited texts run, and
that their oracles see the harm, without any validator.
"""

from __future__ import annotations

import re
from random import Random

from msgspec.structs import replace

from . import tracks
from .bases import Ready
from .deletions import differs
from .forces import FRAGILE
from .further import turned_hand
from .meanings import off_the_middle, put_aside
from .order import fell, held_again, not_where_it_was, opening
from .rule import Rule, Seen, rule
from .snippets import SHUT, USUAL_GRIP, Lines, above, aside, excursion, fingers, go, pressed, shoved, wait
from .strangers import visiting
from .typed import told_too_much


def _shoved(ready: Ready, draw: Random) -> Lines:
    """Closed fingers push the stranger away from the robot's side, low."""
    at = ready.rest(ready.base.stranger)
    start = aside(at, 0.09, 0.0)
    return shoved(start, aside(start, -draw.uniform(0.06, 0.1), 0.0))


def _shoved_back(ready: Ready, draw: Random) -> Lines:
    at, far = ready.rest(ready.base.stranger), draw.uniform(0.02, 0.04)
    one, other = aside(at, 0.09, 0.0), aside(at, -0.09 - far, 0.0)
    gap = 0.025 + 0.012
    return *shoved(one, aside(at, gap - far, 0.0)), *shoved(other, aside(at, -gap, 0.0))


def _nudged_twice(ready: Ready, draw: Random) -> Lines:
    """Nudge a stranger twice: each time by less than it may be moved, both times together by more."""
    at, far = ready.rest(ready.base.stranger), draw.uniform(0.0035, 0.0045)
    touch = aside(at, 0.025 + 0.012, 0.0)
    return tuple(
        line for k in (1, 2) for line in shoved(aside(touch, 0.05, 0.0), aside(touch, -k * far, 0.0), 0.02)
    )


def _placed_twice(ready: Ready, draw: Random) -> str:
    """Grip the thing again, lift it as high as before, and put it down where it stood."""
    at, high = ready.release, draw.uniform(0.06, 0.11)
    up = go(at, 0.1), fingers(SHUT, USUAL_GRIP), go(above(at, high), 0.1)
    down = go(above(at, 0.001), 0.1), fingers(0), go(above(at, 0.12), 0.1)
    return ready.script.after("Retracting/back", (*up, *down)).text


def _swapped(ready: Ready, draw: Random) -> str:
    """The retreat stands before the letting go; or the drawer is shut before the tin goes in."""
    script = ready.script
    number = 5 if ready.base.name == "drawer" and draw.random() < 0.5 else int(re.match(r"\d+", opening(ready))[0])  # type: ignore[index]
    first, second = script.section(number), script.section(number + 1)
    return script.spliced(slice(first.start, second.stop), (*script.lines[second], *script.lines[first])).text


def _task_deleted(ready: Ready, draw: Random) -> str:
    """All lines of the last task but parking are gone."""
    script = ready.script
    numbers = sorted({int(o.split(".")[0]) for o in script.origins() if "Parking" not in o})
    return script.spliced(script.section(draw.choice(numbers[-2:])), ()).text


def _hand_left_inside(ready: Ready, draw: Random) -> str:
    """The hand stays in the container: everything behind the letting go is gone."""
    script = ready.script
    end = script.lines.index("  kill watchdog_thread")
    return script.spliced(slice(script.block(opening(ready)).stop, end), ("",)).text


def _squeezed(ready: Ready, draw: Random) -> str:
    """Close the fingers hard on the released thing once more."""
    lines = fingers(SHUT, draw.randint(90, 255)), wait(0.3), fingers(15)
    return ready.script.after("Releasing/open", lines).text


def _furniture(ready: Ready, draw: Random) -> str:
    """Press closed fingers on the place, 80 mm beside the placed thing."""
    at, side = tracks.end(ready.run, ready.base.held), draw.choice((-1, 1))
    lines = pressed([at[0] + 0.085 * side, at[1], at[2] - 0.06, *ready.release[3:]], draw.uniform(30, 50), 0.2)
    return ready.script.after("Retracting/back", lines).text


def _off_the_edge(ready: Ready, draw: Random) -> str:
    """Put the thing down beside the shelf, or with more than half of it over the edge."""
    code = re.sub('"contact"', '"any"', put_aside(ready.script, draw.uniform(0.13, 0.15), 0.0).text)
    return code


def _beside_container(ready: Ready, draw: Random) -> str:
    """It is let go of beside the container, over the floor."""
    script = ready.script
    lower = script.numbers(script.variables("ungrasping_._lower_pose")[0])
    side = draw.uniform(0.25, 0.28)
    over, beside = above(lower, 0.25), aside(above(lower, -0.005), 0.0, side)
    moved = script.coded("Ungrasping/lower", (go(over), go(aside(over, 0.0, side), 0.2), go(beside, 0.1)))
    back = script.variables("retracting_._back_pose")[0]
    return moved.with_numbers(back, lambda pose: aside(above(pose, 0.1), 0.0, side)).text


def _half_done(ready: Ready, draw: Random) -> str:
    """The stroke that a task is about ends early: sliding, pushing, opening, turning."""
    script = ready.script
    end = script.variables(r"(stroke|push|pull|turn)_pose(_\d)?")[-1]
    start, share = tracks.hand(ready.run, _at_stroke(ready)), draw.uniform(0.1, 0.3)
    poses = script.variables(r"(stroke|push|pull|turn)_pose(_\d)?")
    for name in poses[:-1]:
        script = script.with_numbers(name, lambda _: start)
    return script.with_numbers(
        end, lambda pose: [*(a + share * (b - a) for a, b in zip(start, pose, strict=True))]
    ).text


def _at_stroke(ready: Ready) -> int:
    """Sample at which the stroke begins: the first at which the held thing has moved by 1 mm, or its joint."""
    run, held = ready.run, ready.base.held
    if held in run.values:
        return int((abs(run.values[held] - run.values[held][0]) > 0.005).argmax())
    way = run.poses[held][tracks.SETTLED :, :2]
    return int((((way - way[0]) ** 2).sum(axis=1) > 1e-6).argmax()) + tracks.SETTLED


def _thrown(ready: Ready, draw: Random) -> str:
    """The fingers open while the arm swings over to the place."""
    script = ready.script
    name = next(o for o in script.origins() if o.endswith("transfer") and "Grasping" not in o)
    move = script.code(name)[0].strip()
    thread = "  thread swing():", f"    {move}", "    motion_done = True", "  end"
    begun = "  motion_done = False", "  run swing()", wait(draw.uniform(0.4, 0.7)), fingers(0)
    ended = "  while not motion_done:", "    sync()", "  end"
    return script.coded(name, (*thread, *begun, *ended)).text.replace('"contact", "', '"any", "')


def _rushed(ready: Ready, draw: Random) -> str:
    """The vessel is tilted by 60 to 90 deg and swung at full speed on its way."""
    turn = draw.choice((-1, 1)) * draw.uniform(1.5, 1.9)
    lines = *turned_hand(turn, 3.0), *turned_hand(-turn, 3.0), *turned_hand(turn, 3.0)
    return ready.script.after("PickingUp/lift", excursion(lines)).text


def _twisted(ready: Ready, draw: Random) -> str:
    """Grip the placed thing again and turn it where it stands."""
    at = ready.release
    turn = draw.choice((-1, 1)) * draw.uniform(0.4, 0.7)
    grip = go(at, 0.1), fingers(SHUT, USUAL_GRIP), *excursion(turned_hand(turn))[:2], fingers(0)
    up = "  movel(pose_add(get_actual_tcp_pose(), p[0, 0, 0.1, 0, 0, 0]), a=0.5, v=0.1)"
    return ready.script.after("Retracting/back", (*grip, up)).text


def _payload(ready: Ready, draw: Random) -> str:
    """The empty hand is said to carry 2.6 to 4 kg."""
    name = "Releasing/payload" if "placed" in ready.base.is_a else "Ungrasping/payload"
    return ready.script.substituted(name, r"payload\(0\.\d+", f"payload({draw.uniform(3.5, 4.9):.3f}").text


def stranger_touched(seen: Seen) -> str:
    """Say how far the stranger was ever from where it stood, if more than 6 mm."""
    far = tracks.moved(seen.run, seen.base.stranger)
    return f"'{seen.base.stranger}' was moved by {1000 * far:.0f} mm" if far > 0.006 else ""


def _inside(seen: Seen) -> str:
    far = tracks.apart(seen.run, seen.ready.run, "effector")
    return f"the hand ended {1000 * far:.0f} mm from where it should" if far > 0.03 else ""


def _squeezed_hard(seen: Seen) -> str:
    force = max(tracks.press(seen.run, f"effector/{side}", seen.base.held).max() for side in ("left", "right"))
    return f"'{seen.base.held}' was squeezed with {force:.0f} N" if force > 1.3 * FRAGILE else ""


def _pressed_on(seen: Seen) -> str:
    force = tracks.press(seen.run, "effector", seen.base.place).max()
    return f"'{seen.base.place}' was pressed with {force:.0f} N" if force > 15 else ""


def _less(seen: Seen) -> str:
    """Return the way of the thing or its joint, if that is less than half of that in the unchanged program."""
    run, base, held = seen.run, seen.ready.run, seen.base.held
    joint = held in run.values
    now, before = (abs(tracks.value(r, held)) if joint else tracks.moved(r, held) for r in (run, base))
    return f"'{held}' went {now:.3f} instead of {before:.3f}" if now < 0.5 * before else ""


def _lost(seen: Seen) -> str:
    count = tracks.spilled(seen.run, seen.base.held, seen.base.place)
    return (
        f"{count} balls were lost"
        if count > tracks.spilled(seen.ready.run, seen.base.held, seen.base.place)
        else ""
    )


def _turned(seen: Seen) -> str:
    angle = tracks.spun(seen.run, seen.ready.run, seen.base.held)
    return f"'{seen.base.held}' was turned by {angle:.0f} deg" if angle > 10 else ""


CORRUPTIONS: tuple[Rule, ...] = (
    rule(
        "stranger_shoved",
        "A",
        "closed fingers push the stranger",
        "stranger",
        visiting(_shoved),
        stranger_touched,
        times=1,
    ),
    rule(
        "stranger_shoved_back",
        "A",
        "it is pushed away and back",
        "shelf basket lid fetch hang door",
        visiting(_shoved_back),
        stranger_touched,
        times=1,
    ),
    rule(
        "stranger_nudged_twice",
        "A",
        "it is nudged twice",
        "shelf basket fetch knob",
        visiting(_nudged_twice),
        stranger_touched,
        times=1,
    ),
    rule(
        "placed_twice",
        "B",
        "it is taken and put down again",
        "shelf stack fragile",
        _placed_twice,
        held_again,
        "Placing Retracting ParkingArms",
        times=2,
    ),
    rule(
        "tasks_swapped",
        "B",
        "two tasks have changed places",
        "basket fetch drawer hang",
        _swapped,
        lambda s: fell(s) or differs(s) or held_again(s),
        "order Retracting Ungrasping Releasing Closing",
        times=1,
    ),
    rule(
        "task_deleted",
        "C",
        "a task is gone",
        "placed dropped hang push shake slide",
        _task_deleted,
        differs,
        ". left gone no",
    ),
    rule(
        "hand_left_inside",
        "C",
        "the hand stays in the container",
        "basket fetch drawer",
        _hand_left_inside,
        _inside,
        "Retracting ParkingArms Closing left gone no",
        times=1,
    ),
    rule(
        "squeezed_again",
        "D",
        "a fragile thing is squeezed after its release",
        "fragile",
        _squeezed,
        _squeezed_hard,
        "grip N",
        times=4,
    ),
    rule(
        "furniture_pressed",
        "D",
        "the hand presses on the place",
        "shelf fragile",
        _furniture,
        _pressed_on,
        "shelf N",
    ),
    rule(
        "payload_wrong",
        "D",
        "a payload is told that is not there",
        "shelf stack basket",
        _payload,
        told_too_much,
        "payload kg",
        times=2,
    ),
    rule(
        "off_the_edge",
        "E",
        "it is put down over the edge",
        "shelf fragile",
        _off_the_edge,
        off_the_middle,
        "shelf Placing",
    ),
    rule(
        "beside_container",
        "E",
        "it is let go of beside the container",
        "basket fetch",
        _beside_container,
        not_where_it_was,
        "basket Ungrasping",
    ),
    rule(
        "half_done",
        "E",
        "a stroke ends early",
        "slide door",
        _half_done,
        _less,
        "SlidingObject Pushing Opening TurningOn",
    ),
    rule(
        "thrown",
        "N",
        "the fingers open while the arm swings",
        "shelf basket stack",
        _thrown,
        lambda s: fell(s) or not_where_it_was(s),
        "Placing Ungrasping PuttingDown",
    ),
    rule(
        "vessel_rushed",
        "N",
        "the vessel is swung",
        "pour",
        _rushed,
        _lost,
        "spilled grains PickingUp Shaking Pouring",
    ),
    rule(
        "twisted_after_placing",
        "N",
        "it is turned where it stands",
        "shelf stack fragile",
        _twisted,
        _turned,
        "Placing Retracting Parking",
    ),
)

RULES: tuple[Rule, ...] = tuple(replace(r, sealed=True) for r in CORRUPTIONS)
