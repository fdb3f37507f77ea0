"""Class C: steps that are gone, or of which a token is left."""

from __future__ import annotations

from random import Random

import numpy as np

from . import tracks
from .bases import Ready
from .rule import Rule, Seen, rule
from .script import Script

ASIDE = 0.03
"""Distance between the hand's last places in two runs from which it counts as left elsewhere [m]."""


def _last_back(script: Script) -> str:
    return [o for o in script.origins() if o.rsplit("/", 1)[-1] == "back"][-1]


def _last_step_deleted(ready: Ready, draw: Random) -> str:
    """The last step of a task is deleted, with its comment or without."""
    name = _last_back(ready.script)
    return (ready.script.without(name) if draw.random() < 0.5 else ready.script.coded(name, ())).text


def _step_deleted(ready: Ready, draw: Random) -> str:
    """Any step that moves arm or fingers is deleted."""
    script = ready.script
    moving = [
        o for o in script.origins() if any(word in line for line in script.code(o) for word in ("move", "force_"))
    ]
    name = draw.choice(moving)
    return script.without(name, draw.choice((0, -1))).text


def _token(ready: Ready, draw: Random) -> str:
    """The last retreat ends after a few millimetres; of a vessel that turns back, after the first of 21 turns."""
    script, share = ready.script, draw.uniform(0.02, 0.08)
    name = _last_back(script)
    code = script.code(name)
    if len(code) > 1:
        return script.coded(name, code[: draw.randint(1, 4)]).text
    variable = script.variables("back_pose")[-1]
    start = _before_the_end(ready)
    end = script.numbers(variable)
    short = [*(a + share * (b - a) for a, b in zip(start, end[:3], strict=True)), *end[3:]]
    return script.with_numbers(variable, lambda _: short).text


def _half(ready: Ready, draw: Random) -> str:
    """The vessel is turned back half of the way."""
    name = _last_back(ready.script)
    code = ready.script.code(name)
    return ready.script.coded(name, code[: round(draw.uniform(0.4, 0.7) * len(code))]).text


def _before_the_end(ready: Ready) -> list[float]:
    """Where the tool was before the last straight retreat, which ends where the run ends, or 120 mm before the hand goes home."""
    path = ready.run.poses["effector"][:, :3]
    target = ready.script.numbers(ready.script.variables("back_pose")[-1])[:3]
    arrived = int(np.argmin(np.linalg.norm(path - target, axis=1)))
    slow = np.flatnonzero(np.linalg.norm(np.diff(path[:arrived], axis=0), axis=1) < 1e-5)
    still = [k for k in slow if np.linalg.norm(path[k] - target) > 0.02]
    return [float(n) for n in path[still[-1]]]


def differs(seen: Seen) -> str:
    """Say what ended elsewhere than in the unchanged program: the grasped thing, a joint, the hand; or what fell or was
    pressed."""
    run, base, held = seen.run, seen.ready.run, seen.base.held
    if any(abs(tracks.value(run, joint) - tracks.value(base, joint)) > 0.02 for joint in run.values):
        return "the joint ended elsewhere"
    if tracks.apart(run, base, held) > 0.01 or abs(tracks.turned(run, held) - tracks.turned(base, held)) > 8:
        return f"'{held}' ended elsewhere"
    if tracks.apart(run, base, "effector") > ASIDE:
        return f"the hand ended {1000 * tracks.apart(run, base, 'effector'):.0f} mm elsewhere"
    if tracks.fell(run, held) > tracks.fell(base, held) + 0.02:
        return f"'{held}' fell"
    harder = tracks.press(run, "effector/body", held).max() - tracks.press(base, "effector/body", held).max()
    return f"the hand pressed {harder:.0f} N harder" if harder > 10 else ""


RULES: tuple[Rule, ...] = (
    rule(
        "last_step_deleted",
        "C",
        "the last step of a task is gone",
        "placed drawer basket fetch hang pour door knob push shut off",
        _last_step_deleted,
        differs,
        "back Retracting Closing Pouring Opening TurningOn TurningOff left gone Pushing",
    ),
    rule(
        "step_deleted",
        "C",
        "a step is gone",
        "placed dropped joint push slide hang",
        _step_deleted,
        differs,
        ". / left gone no",
    ),
    rule("half_turned_back", "C", "what was tilted is turned back half of the way", "pour", _half, differs, "back Pouring"),
    rule(
        "token_retreat",
        "C",
        "the last retreat is a few millimetres long",
        "drawer pour push fetch basket hang knob off",
        _token,
        differs,
        "back Retracting Closing Pouring Pushing TurningOn TurningOff left",
    ),
)
