"""Corruptions of a typed program written as JSON, from several classes of rules for programs of robots."""

from __future__ import annotations

import json
from collections.abc import Callable
from random import Random
from typing import Any

from . import tracks
from .bases import Ready
from .deletions import differs
from .order import fell, held_again, not_where_it_was
from .rule import Edit, Rule, Seen, rule

Steps = list[dict[str, Any]]
Change = Callable[[Steps, Random], Steps]


def changing(change: Change) -> Edit:
    """Make an edit of a change of the steps."""

    def edit(ready: Ready, draw: Random) -> str:
        program = ready.typed
        program["steps"] = change(program["steps"], draw)
        return json.dumps(program, indent=1)

    return edit


def found(steps: Steps, ending: str) -> int:
    """Find a step by how its origin ends."""
    return next(k for k, s in enumerate(steps) if s["origin"].endswith(ending))


def _late_open(steps: Steps, draw: Random) -> Steps:
    opens = steps.pop(found(steps, "Releasing/open"))
    steps.insert(found(steps, "Retracting/back") + 1, opens)
    return steps


def _drop_and_retake(steps: Steps, draw: Random) -> Steps:
    """Lift the thing, let go of it, and grip it again where it stood."""
    lift = found(steps, "PickingUp/lift")
    opens, approach, close = (steps[found(steps, f"Grasping/{name}")] for name in ("open", "approach", "close"))
    low = json.loads(json.dumps(steps[lift]))
    share = draw.uniform(0.3, 0.6)
    low["target"]["position"][2] -= (1 - share) * 0.1
    low["joints"] = [b + share * (a - b) for a, b in zip(steps[lift]["joints"], approach["joints"], strict=True)]
    again = [{**s, "origin": steps[lift]["origin"]} for s in (low, opens, approach, close)]
    return [*steps[:lift], *again, *steps[lift:]]


def _retaken(steps: Steps, draw: Random) -> Steps:
    """Grip the placed thing, lift it, and drop it where it stands."""
    back = found(steps, "Retracting/back")
    down = next(s for s in steps[::-1] if s["step"] == "MoveLinear" and s["origin"].endswith("lower"))
    close, opens = steps[found(steps, "Grasping/close")], steps[found(steps, "Releasing/open")]
    low = json.loads(json.dumps(down))
    low["target"]["position"][2] -= 0.018
    again = [{**s, "origin": steps[back]["origin"]} for s in (low, close, steps[back], opens)]
    return [*steps[: back + 1], *again, *steps[back + 1 :]]


def _payload(steps: Steps, draw: Random) -> Steps:
    """The empty hand is said to carry something."""
    last = max(k for k, s in enumerate(steps) if s["step"] == "SetPayload")
    steps[last]["mass"] += draw.uniform(2.5, 3.9)
    return steps


def _deleted(steps: Steps, draw: Random) -> Steps:
    steps.pop(
        draw.choice([k for k, s in enumerate(steps) if s["step"] not in ("ZeroSensor", "Wait", "SetPayload")])
    )
    return steps


def _half_open(steps: Steps, draw: Random) -> Steps:
    opens = steps[found(steps, "Releasing/open")]
    opens["opening"], opens["expect"] = draw.uniform(0.0, 0.03), "any"
    return steps


def _unguarded(ready: Ready, draw: Random) -> str:
    """A safeguard of a step is lost: what a grip or a guarded motion expects, a tare, or the guard of a motion in two parts."""
    program = ready.typed
    steps = program["steps"]
    asking = [s for s in steps if s.get("expect", "any") in ("object", "contact")]
    tares = [s for s in steps if s["step"] == "ZeroSensor"]
    guards = [s for k, s in enumerate(steps) if s["step"] == "MoveUntilContact" and steps[k - 1]["origin"] == s["origin"]]
    one = draw.choice([*asking, *tares, *guards])
    if one in tares:
        steps[steps.index(one)] = {"step": "Wait", "duration": 0.3, "origin": one["origin"]}
    elif one in asking and not (one in guards and draw.random() < 0.5):
        one["expect"] = "any"
    else:
        steps.remove(one)
    return json.dumps(program, indent=1)


def _unlimited(ready: Ready, draw: Random) -> str:
    """The program's force limit is raised, or gone."""
    return json.dumps({**ready.typed, "force_limit": draw.choice((0.0, 500.0))}, indent=1)


def unwatched(seen: Seen) -> str:
    """Say that a safeguard is lost, which is no harm in the run itself, if the thing came as far as before."""
    return "a safeguard is lost" if tracks.apart(seen.run, seen.ready.run, seen.base.held) < 0.02 else ""


def told_too_much(seen: Seen) -> str:
    """Say by how much the arm is told a wrong load: the weight that it was told and that is not there."""
    if seen.run.force is None or seen.ready.run.force is None:
        return ""
    force = abs(seen.run.force).max() - abs(seen.ready.run.force).max()
    return f"it felt {force:.0f} N that nothing exerts" if force > 10 else ""


RULES: tuple[Rule, ...] = (
    rule("typed_unguarded", "N", "a safeguard is lost", "typed typed_drawer", _unguarded, unwatched, "asks calls guarded", times=6),
    rule("typed_unlimited", "N", "the force limit is raised or gone", "typed typed_drawer", _unlimited, unwatched, "force_limit", times=4),
    rule(
        "typed_late_open",
        "B",
        "the fingers open behind the retreat",
        "typed",
        changing(_late_open),
        fell,
        "Releasing Placing",
        times=1,
    ),
    rule(
        "typed_drop_and_retake",
        "B",
        "it is dropped and gripped again",
        "typed",
        changing(_drop_and_retake),
        held_again,
        "Picking",
    ),
    rule(
        "typed_retaken",
        "B",
        "it is gripped again and dropped",
        "typed",
        changing(_retaken),
        lambda s: held_again(s) or fell(s),
        "Retracting Placing",
        times=1,
    ),
    rule("typed_step_deleted", "C", "a step is gone", "typed typed_drawer", changing(_deleted), differs, ". no", times=4),
    rule(
        "typed_payload",
        "D",
        "a payload is told that is not there",
        "typed typed_drawer",
        changing(_payload),
        told_too_much,
        "payload kg",
        times=2,
    ),
    rule(
        "typed_half_open",
        "N",
        "the fingers do not let go",
        "typed",
        changing(_half_open),
        not_where_it_was,
        "Releasing Placing",
    ),
)
