"""Harmless edits that resemble those of handling and protections: the run has the same result."""

from __future__ import annotations

import re
from random import Random

from .bases import Ready
from .handling import PLACED
from .harmless import SAME
from .order import opening
from .protections import URSCRIPT
from .rule import Rule, rule
from .snippets import WIDE, above, aside, excursion, fingers, go
from .strangers import at_some_time


def _guarded(ready: Ready, draw: Random) -> str:
    new = f"0.03, 0.01, {draw.uniform(4, 6):.1f}, 9.0"
    return ready.script.substituted("PuttingDown/lower", r"0\.03, 0\.01, 3\.0, 9\.0", new).text


def _thread_writes(ready: Ready, draw: Random) -> str:
    script = ready.script
    body = "  thread helper():", "    sleep(0.5)", '    textmsg("on the way")', "  end"
    started = script.within(script.origins()[0], ["  global helper_thread = run helper()"])
    k = next(k for k, line in enumerate(started.lines) if line.startswith("  thread watchdog"))
    return started.spliced(slice(k, k), [*body, ""]).text


def _counted(ready: Ready, draw: Random) -> str:
    lines = (
        "  global counted = 0",
        f"  while counted < {draw.randint(20, 90)}:",
        "    sync()",
        "    counted = counted + 1",
    )
    return ready.script.within(ready.script.origins()[0], [*lines, "  end"]).text


def _over_stranger(ready: Ready, draw: Random) -> str:
    at = ready.rest(ready.base.stranger)
    return at_some_time(ready, draw, (go(above(at, draw.uniform(0.15, 0.2))),))


def _detour(ready: Ready, draw: Random) -> str:
    lift = ready.script.numbers(ready.script.variables("lift_pose")[0])
    there = go(above(aside(lift, -draw.uniform(0.03, 0.08), -0.03), 0.05), 0.15)
    return ready.script.after("PickingUp/lift", [there, go(lift, 0.15)]).text


def _higher(ready: Ready, draw: Random) -> str:
    name = ready.script.variables("lift_pose")[0]
    return ready.script.with_numbers(name, lambda pose: above(pose, draw.uniform(0.01, 0.04))).text


def _farther(ready: Ready, draw: Random) -> str:
    name = ready.script.variables("back_pose")[-1]
    return ready.script.with_numbers(name, lambda pose: above(pose, draw.uniform(0.01, 0.04))).text


def _opened_fully(ready: Ready, draw: Random) -> str:
    return ready.script.substituted(opening(ready), rf"\({WIDE}, ", "(0, ").text


def _opened_at_home(ready: Ready, draw: Random) -> str:
    return ready.script.after("ParkingArms/park", [fingers(draw.choice((0, 60, 255)))]).text


def _limit_lowered(ready: Ready, draw: Random) -> str:
    return re.sub(r"force_limit = [1-9][\d.]*", f"force_limit = {draw.uniform(45, 55):.1f}", ready.text, count=1)


def _moved_while_parked(ready: Ready, draw: Random) -> str:
    turn = (
        f"  movej([here[0] + {draw.uniform(0.1, 0.3):.2f}, here[1], here[2], here[3], here[4], here[5]], a=1.4, v=1.0)"
    )
    return ready.script.after("ParkingArms/park", excursion([turn])).text


def _put_slowly(ready: Ready, draw: Random) -> str:
    new = f"0.03, {draw.uniform(0.005, 0.008):.4f}, 3.0, 9.0"
    return ready.script.substituted("PuttingDown/lower", r"0\.03, 0\.01, 3\.0, 9\.0", new).text


RULES: tuple[Rule, ...] = (
    rule("put_with_guard_of_5", "H", "it is put down with a guard of 4 to 6 N", PLACED, _guarded, SAME, times=1),
    rule("thread_writes", "H", "a thread writes a message", URSCRIPT, _thread_writes, SAME, times=1),
    rule("counted_wait", "H", "a loop counts before it starts", URSCRIPT, _counted, SAME, times=1),
    rule("over_stranger", "H", "the empty hand passes high over what no task names", URSCRIPT, _over_stranger, SAME,
         times=1),
    rule("detour", "H", "what is held makes a detour", "shelf stack fragile", _detour, SAME, times=1),
    rule("lifted_higher", "H", "it is lifted higher", "shelf stack fragile basket", _higher, SAME, times=1),
    rule("farther_back", "H", "the hand retreats farther", "shelf stack fragile", _farther, SAME, times=1),
    rule("opened_fully", "H", "the fingers open fully", PLACED, _opened_fully, SAME, times=1),
    rule("opened_at_home", "H", "the empty fingers move at home", "shelf stack basket", _opened_at_home, SAME,
         times=1),
    rule("limit_lowered", "H", "the force limit is a little lower", URSCRIPT, _limit_lowered, SAME, times=1),
    rule("moved_while_parked", "H", "the parked arm turns and comes back", "shelf stack", _moved_while_parked, SAME,
         times=1),
    rule("put_slowly", "H", "it is put down more slowly", PLACED, _put_slowly, SAME, times=1),
)  # fmt: skip
