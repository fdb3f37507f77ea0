"""Class N: what the audit did not try: heights, leaning vessels, joints that are turned back, fingers that do not open."""

from __future__ import annotations

from random import Random

from . import tracks
from .bases import Ready
from .order import held_again, not_where_it_was, opening
from .rule import Rule, Seen, rule
from .snippets import above, aside, excursion, go, leaning, wait
from .strangers import stranger_moved


def _from_high(ready: Ready, draw: Random) -> str:
    """The fingers open 150 to 300 mm higher over a container."""
    higher = draw.uniform(0.15, 0.3)
    script = ready.script
    lines = [go(above(script.numbers(script.variables("ungrasping_._lower_pose")[0]), higher), 0.1)]
    return script.coded("Ungrasping/lower", lines).text


def turned_hand(turn: float, speed: float = 1.0) -> list[str]:
    """Turn the hand about its own axis and back [rad]."""
    joints = ", ".join([*(f"here[{k}]" for k in range(5)), f"here[5] + {turn:.3f}"])
    return [f"  movej([{joints}], a=1.4, v={speed})", wait(0.5)]


def _tipped(ready: Ready, draw: Random) -> str:
    """Turn the vessel over after the lift, above the place where it stood, and turn it back."""
    turn = draw.choice((-1, 1)) * draw.uniform(2.2, 2.8)
    return ready.script.after("PickingUp/lift", excursion(turned_hand(turn))).text


def _turned_back(ready: Ready, draw: Random) -> str:
    """Move the hand back along its path before it lets go."""
    script = ready.script
    step = next(o for o in script.origins() if o.endswith(("/pull", "/turn")))
    code = list(script.code(step))
    moves = [line for line in code if "movel(" in line]
    stop = draw.randint(0, (len(moves) - 2) // 2)
    back = moves[stop:-1][::-1] + (
        [moves[0].replace("_pull_pose", "_approach_pose").replace("_turn_pose", "_approach_pose")] * (stop == 0)
    )
    k = code.index(moves[-1]) + 1
    longer = [
        line.replace("25.0, 8.0", "25.0, 30.0").replace("25.0, 13.0", "25.0, 40.0")
        for line in (*code[:k], *back, *code[k:])
    ]
    return script.coded(step, longer).text


def _half_open(ready: Ready, draw: Random) -> str:
    """The fingers do not open wide enough to let go."""
    code = f'  move_gripper({draw.randint(150, 220)}, 157, 0, "any", 3.0, "open")'
    return ready.script.coded(opening(ready), [code]).text


def _sweeps(ready: Ready, draw: Random) -> str:
    """What is held is led low through the stranger."""
    at = ready.rest(ready.base.stranger)
    low = [*at[:2], ready.grasp[2] + 0.02, *ready.grasp[3:]]
    near, far = aside(low, draw.uniform(-0.02, 0.02), -0.13), aside(low, 0.0, draw.uniform(-0.005, 0.03))
    lines = go(above(near, 0.1)), go(near, 0.1), go(far, 0.1), go(above(far, 0.12), 0.1), go(above(near, 0.12))
    return ready.script.after("PickingUp/lift", lines).text


def _let_go_leaning(ready: Ready, draw: Random) -> str:
    """The hand leans by 35 to 45 deg about the line between its pads, 15 mm over the place, and lets go."""
    lower = ready.script.numbers(ready.script.variables("lower_pose")[0])
    axis = tracks.closing_axis(ready.run, tracks.release(ready.run, ready.base.held))
    lines = [go(leaning(above(lower, 0.015), draw.choice((-1, 1)) * draw.uniform(0.6, 0.8), axis), 0.1)]
    return ready.script.after("PuttingDown/rest", lines).text


def _fell_deep(seen: Seen) -> str:
    deep, before = (tracks.fell(run, seen.base.held) for run in (seen.run, seen.ready.run))
    return f"'{seen.base.held}' fell {1000 * deep:.0f} mm" if deep > before + 0.12 else ""


def _spilled(seen: Seen) -> str:
    count = tracks.spilled(seen.run, seen.base.held, seen.base.place)
    before = tracks.spilled(seen.ready.run, seen.base.held, seen.base.place)
    return f"{count} balls were spilled" if count > before else ""


def _joint_back(seen: Seen) -> str:
    now, before = tracks.value(seen.run, seen.base.held), tracks.value(seen.ready.run, seen.base.held)
    first = float(seen.ready.run.values[seen.base.held][0])
    less = abs(now - first) < 0.6 * abs(before - first)
    return f"'{seen.base.held}' was left at {now:.2f} instead of {before:.2f}" if less else ""


def _fell_over(seen: Seen) -> str:
    lean = tracks.turned(seen.run, seen.base.held)
    return f"'{seen.base.held}' ended leaning by {lean:.0f} deg" if lean > 30 else ""


RULES: tuple[Rule, ...] = (
    rule(
        "dropped_from_high",
        "N",
        "it is dropped into the container from high above",
        "basket fetch drawer",
        _from_high,
        _fell_deep,
        "Ungrasping basket",
    ),
    rule(
        "vessel_tipped",
        "N",
        "the vessel is tipped on its way",
        "pour",
        _tipped,
        _spilled,
        "spilled PickingUp grains Pouring Shaking",
    ),
    rule(
        "turned_back",
        "N",
        "what was opened or turned is brought back",
        "turning",
        _turned_back,
        _joint_back,
        "Opening TurningOn TurningOff",
    ),
    rule(
        "half_open",
        "N",
        "the fingers do not let go",
        "placed dropped",
        _half_open,
        lambda s: not_where_it_was(s) or held_again(s),
        "Releasing Ungrasping Placing",
        times=1,
    ),
    rule(
        "payload_hits_stranger",
        "N",
        "what is held is led through what stands there",
        "shelf fragile stack basket",
        _sweeps,
        stranger_moved,
        "hit PickingUp",
        times=1,
    ),
    rule(
        "let_go_leaning",
        "N",
        "it is let go of leaning, and falls over",
        "shelf fragile stack",
        _let_go_leaning,
        _fell_over,
        "Releasing Placing",
    ),
)
