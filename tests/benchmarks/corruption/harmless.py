"""Harmless edits: the text changes, the result of the run does not. Each oracle says what went wrong, "" for nothing."""

from __future__ import annotations

import json
import re
from random import Random

from . import tracks
from .bases import Ready
from .meanings import put_aside
from .order import closing_of
from .rule import Oracle, Rule, Seen, rule
from .script import SECTION, STEP, Script
from .snippets import wait

ALL = "shelf stack fragile lid drawer basket fetch hang shake push slide door knob shut off goals"
"""All bases in URScript but the one that pours, which takes ten times as long to run."""


def _comment_moved(ready: Ready, draw: Random) -> str:
    """Move a step's comment one to three lines down, within its task."""
    script = ready.script
    places = [
        k
        for k, line in enumerate(script.lines)
        if STEP.match(line) and line.startswith("  #") and _room(script, k) > 0
    ]
    k = draw.choice(places)
    far = draw.randint(1, min(3, _room(script, k)))
    return script.spliced(slice(k, k + 1 + far), [*script.lines[k + 1 : k + 1 + far], script.lines[k]]).text


def _room(script: Script, k: int) -> int:
    ends = (n for n, line in enumerate(script.lines) if n > k and (not line.strip() or SECTION.match(line)))
    return next(ends) - k - 1


def _reworded(ready: Ready, draw: Random) -> str:
    """Write the text behind a step's name in its comment anew."""
    script = ready.script
    k = draw.choice([k for k, line in enumerate(script.lines) if STEP.match(line)])
    return script.spliced(
        slice(k, k + 1), [script.lines[k].split(": ")[0] + ": as agreed with the shift leader"]
    ).text


def _trailing_removed(ready: Ready, draw: Random) -> str:
    """Comments behind code are deleted."""
    return "\n".join(re.sub(r"(\S)  # .*", r"\1", line) for line in ready.script.lines) + "\n"


def _blank_lines(ready: Ready, draw: Random) -> str:
    doubled = (line if line.strip() or draw.random() < 0.5 else "\n" for line in ready.script.lines)
    return "\n".join(doubled) + "\n\n"


def _slower(ready: Ready, draw: Random) -> str:
    """Every motion at 80 to 95 % of its speed."""
    share = draw.uniform(0.8, 0.95)
    return re.sub(r"(move[jl]\(.*, v=)([\d.]+)", lambda m: f"{m[1]}{share * float(m[2]):.4f}", ready.text)


def _waits(ready: Ready, draw: Random) -> str:
    script = ready.script
    name = draw.choice(
        [o for o in script.origins() if o.endswith(("lift", "open", "transfer", "back", "approach", "close"))]
    )
    return script.after(name, [wait(draw.uniform(0.2, 0.8))]).text


def _logged(ready: Ready, draw: Random) -> str:
    name = draw.choice(
        [o for o in ready.script.origins() if o.endswith(("lift", "open", "transfer", "back", "approach", "close"))]
    )
    return ready.script.after(name, [f'  textmsg("cell 4: done with part {draw.randint(1, 99)}")']).text


def _renamed(ready: Ready, draw: Random) -> str:
    variable = draw.choice(ready.script.variables("_(pose|joints)"))
    return re.sub(rf"\b{variable}\b", f"taught_point_{draw.randint(1, 9)}", ready.text)


def _placed_aside(ready: Ready, draw: Random) -> str:
    """10 to 25 mm aside on a shelf, 4 to 8 on a block."""
    far = draw.uniform(0.004, 0.008) if "stack" in ready.base.is_a else draw.uniform(0.01, 0.025)
    return put_aside(ready.script, far * draw.choice((-1, 1)), far * draw.choice((-0.5, 0.5))).text


def _gripped(ready: Ready, draw: Random) -> str:
    """The fingers press by 2 to 6 of 255 steps more."""
    script, name = ready.script, closing_of(ready.script)
    more = draw.randint(2, 6)
    code = [
        re.sub(r"\(255, 157, (\d+)", lambda m: f"(255, 157, {int(m[1]) + more}", line) for line in script.code(name)
    ]
    return script.coded(name, code).text


def _one_line(ready: Ready, draw: Random) -> str:
    return json.dumps(ready.typed, separators=draw.choice(((",", ":"), (", ", ": "))))


def _typed_slower(ready: Ready, draw: Random) -> str:
    program, share = ready.typed, draw.uniform(0.7, 0.95)
    for step in program["steps"]:
        if step["step"] in ("MoveLinear", "MoveJoints"):
            step["speed"] *= share
    return json.dumps(program, indent=draw.choice((None, 2)))


def as_before(within: float) -> Oracle:
    """Make an oracle that asks whether all things ended where they did, and no stranger was moved.

    Args:
        within: of what is held [m].
    """

    def oracle(seen: Seen) -> str:
        run, base, held = seen.run, seen.ready.run, seen.base.held
        if tracks.apart(run, base, held) > within or abs(tracks.turned(run, held) - tracks.turned(base, held)) > 5:
            return f"'{held}' ended elsewhere"
        others = [
            t.name
            for t in run.world.things
            if t.movable and t.name != held and tracks.apart(run, base, t.name) > 0.003
        ]
        if others:
            return f"'{others[0]}' ended elsewhere"
        if any(abs(tracks.value(run, joint) - tracks.value(base, joint)) > 0.02 for joint in run.values):
            return "a joint ended elsewhere"
        return "it fell" if tracks.fell(run, held) > tracks.fell(base, held) + 0.01 else ""

    return oracle


SAME = as_before(0.008)

RULES: tuple[Rule, ...] = (
    rule(
        "comment_moved",
        "H",
        "a comment stands some lines below",
        "shelf drawer hang lid off goals",
        _comment_moved,
        SAME,
        times=1,
    ),
    rule("comment_reworded", "H", "a comment says something else", "stack basket pour", _reworded, SAME, times=1),
    rule(
        "trailing_removed",
        "H",
        "comments behind code are gone",
        "fetch knob shelf",
        _trailing_removed,
        SAME,
        times=1,
    ),
    rule("blank_lines", "H", "there are more blank lines", "fragile door push", _blank_lines, SAME, times=1),
    rule(
        "slower", "H", "all motions are slower", "shelf stack drawer lid basket fetch knob shut goals", _slower, SAME, times=1
    ),
    rule("waits", "H", "it waits somewhere", "stack drawer fragile hang push slide off goals", _waits, SAME, times=1),
    rule("logged", "H", "a message is written", "lid basket door shake shut", _logged, SAME, times=1),
    rule("renamed", "H", "a variable has another name", "shelf fetch slide knob off shut", _renamed, SAME, times=1),
    rule(
        "placed_aside",
        "H",
        "it is put down some millimetres aside",
        "shelf stack fragile goals",
        _placed_aside,
        as_before(0.032),
    ),
    rule(
        "gripped_more",
        "H",
        "the grip is a little stronger",
        "shelf stack basket drawer door",
        _gripped,
        SAME,
        times=1,
    ),
    rule("typed_one_line", "H", "the typed program stands on one line", "typed typed_drawer", _one_line, SAME, times=2),
    rule("typed_slower", "H", "the typed program is slower", "typed typed_drawer", _typed_slower, SAME, times=1),
)
