"""Python source text for the module of a learned task: its path, parameters, steps and predicate."""

from __future__ import annotations

from collections.abc import Mapping

from ..model.robot import FORCE_LIMIT
from ..model.shown_path import ShownPath
from .proposal import Proposal
from .shown_force import MARGIN, ShownForce
from .shown_rest import ShownRest
from .shown_turn import ShownTurn

PRESS_N = 12.0
"""Default force with which a learned motion presses [N], where no demonstration recorded a force: what a block needs to keep its contact in
simulation."""
SLIDE = ("slide_m_s", "0.02", "at 20 mm/s and less inertia does not look like contact")
UNKNOWN = (
    ("press_n", f"{PRESS_N}", "what a block needs to keep its contact in simulation; no demonstration says a force"),
    ("force_limit_n", "25.0", "as for other motions along a surface"),
)
"""Parameters of a motion whose force nobody recorded: name, default and source."""
TURNED = (
    ("speed_m_s", "0.08", "as along other joints"),
    ("force_limit_n", "25.0", "as along other joints"),
    ("most_n", "20.0", "grip force: what a hand off its middle strains the arm with stays below the limit"),
)
"""Parameters of a turn in strokes: name, default and source."""


def motion_words(proposal: Proposal, name: str) -> Mapping[str, str]:
    """Return the texts for the placeholders of a module's template, for a task that is done by a learned motion.

    There are none for other tasks.

    Args:
        name: of the package.
    """
    if proposal.rest is not None:
        return _rest_words(proposal.rest, name)
    if proposal.turning is not None:
        return _turn_words(*proposal.turning, name)
    if proposal.moving is None:
        return {}
    motion, mover, about = proposal.moving
    path = motion.path
    speed = ("speed_m_s", f"{path.speed:g}", "the median of the shown speeds")
    rows = (SLIDE, *(_forces(motion.force) if motion.force else UNKNOWN)) if path.touching else (speed,)
    declared = "".join(f'\n        Parameter("{n}", {default}, "{source}"),' for n, default, source in rows)
    return {
        "constants": f"\nPATH = {path_text(path)}\n\"\"\"{said(proposal)}\"\"\"\n",
        "parameters": f"\n    parameters = ({declared}\n    )" + ("" if path.touching else "\n    slides = False"),
        "decompose": "\n".join(_steps(path, mover, about)),
        "hooks": _hook(f'path_predicate("follows_{name}", PATH)'),
    }


def _forces(force: ShownForce) -> tuple[tuple[str, str, str], ...]:
    """Return the force parameters of a motion whose examples record their forces: name, default and source."""
    shown, peak = ", ".join(f"{e.press_n:g}" for e in force.examples), max(e.peak_n for e in force.examples)
    return (
        ("press_n", f"{force.press_n}", f"the median of what people pressed with: {shown} N"),
        ("force_limit_n", f"{force.limit_n}", f"{MARGIN:g} times the highest force that people reached, {peak:g} N"),
    )


def _rest_words(rest: ShownRest, name: str) -> Mapping[str, str]:
    return {
        "constants": f'\nLEAST_S = {rest.least_s:g}\n"""Shortest rest that counts [s]."""\n',
        "parameters": f'\n    parameters = (Parameter("rest_s", {rest.duration_s:g}, "the median of the shown rests"),)',
        "hooks": _hook(f'rest_predicate("rests_{name}", LEAST_S)'),
    }


def _hook(made: str) -> str:
    return f"\n\n@hookimpl\ndef predicates() -> Iterable[Predicate]:\n    return [{made}]\n"


def said(proposal: Proposal) -> str:
    """Return a sentence that describes the motion of a learned task; "" if known tasks alone explain the task."""
    if proposal.rest is not None:
        return f"At the end the hand rests for {proposal.rest.duration_s:g} s."
    if proposal.turning is not None:
        return _turn_said(*proposal.turning)
    if proposal.moving is None:
        return ""
    motion, mover, about = proposal.moving
    path = motion.path
    where = path.anchor.part.split(":")[-1] or "frame"
    frame = f"in the frame of the {where} of {about}{', at its bottom' if path.anchor.deep else ''}"
    frame = "about its first place" if path.anchor.own else frame
    counts = " ".join(f"{c:g}" for c in motion.counts)
    along = f"along it {counts} times" if path.times > 1 else "along it once"
    often = f"the examples went {f'round it {counts} times' if path.closed else along}"
    unit = "; x and y in halves of its width" if path.anchor.scaled else ""
    return f"Path of the bottom centre of {mover} {frame}{unit}: {often}; the examples differ by {1000 * motion.spread:.1f} mm."


def force_said(proposal: Proposal) -> str:
    """Return sentences on the force with which a learned motion presses, and the examples that it comes from; "" for other tasks."""
    if proposal.moving is None or not proposal.moving[0].path.touching:
        return ""
    force = proposal.moving[0].force
    if force is None:
        return f"No example says with what force it presses: it is {PRESS_N:g} N by default; correct press_n in the package."
    shown = "; ".join(f"{e.example}: {e.press_n:g} N, at most {e.peak_n:g} N" for e in force.examples)
    high = f" Programs stop at {FORCE_LIMIT:g} N unless the scenario's force_limit says more." if force.limit_n > FORCE_LIMIT else ""
    return (
        f"It presses with {force.press_n:g} N, the median of the examples (spread {force.spread_n:g} N), and stops at {force.limit_n:g} N. "
        f"Recorded forces: {shown}.{high}"
    )


def path_text(path: ShownPath) -> str:
    """Return a path as a Python expression with one corner per line."""
    points = "".join(f"\n        ({x:g}, {y:g}, {z:g})," for x, y, z in path.points)
    a, aimed = path.anchor, "" if path.heading is None else f" heading={path.heading:g},"
    own = ", own=True" if a.own else ""
    return (
        f"ShownPath(\n    points=({points}\n    ),\n"
        f'    anchor=Anchor("{a.part}", deep={a.deep}, scaled={a.scaled}{own}),\n'
        f"    times={path.times}, least={path.least:g}, tolerance={path.tolerance:g}, closed={path.closed}, either={path.either},\n"
        f"    touching={path.touching}, stand_off={path.stand_off:g}, speed={path.speed:g},{aimed}\n)"
    )


def _steps(path: ShownPath, mover: str, about: str) -> list[str]:
    """Return lines of Python that lead the hand above the path's start, down, along the path, and up again.

    On a surface they do so once for each stroke. A path about the payload's own place begins where the hand is.
    """
    roles, reference = f'moved, about = action.roles["{mover}"], action.roles["{about}"]', "about"
    if path.anchor.own:
        roles, reference = f'moved = action.roles["{mover}"]', "moved"
    lines = [
        roles,
        "if belief.held is None or belief.held.thing != moved.entity:",
        """    raise Unresolvable.because_of_earlier_tasks(f"'{moved.entity}' is not in the hand", (moved.name,))""",
        f'way = Location(action.inside("way"), "shown_path", {reference}.name, {{"path": PATH}})',
    ]
    if path.anchor.own:
        lines += ["yield Decomposition((", "    way,", f"    {_free('')[-1]}", '), "as it was shown")']
    elif path.touching and path.times > 1:
        lines += ["steps: list[Location | Motion] = [way]", 'for n in ("", *(f"_{k}" for k in range(2, PATH.times + 1))):']
        lines += [f"    {line}" for line in _once(path, "{n}", "steps += [", "]")]
        lines.append('yield Decomposition(tuple(steps), "as it was shown")')
    else:
        lines += _once(path, "", "yield Decomposition((", '), "as it was shown")', "    way,")
    return [f"        {line}" for line in lines]


def _once(path: ShownPath, number: str, begin: str, end: str, *first: str) -> list[str]:
    """Return lines of Python for a single pass along a shown path: above its start, along the path, and away
    from its end.

    Args:
        number: at the end of names of what is done more than once.
    """
    lines = [
        f'up = Location({_inside("up", number)}, "lift", None, {{"height_m": PATH.stand_off}})',
        begin,
        *first,
        f'    Motion({_inside("transfer", number)}, "transfer", way, reason="above where it begins"),',
        *(f"    {line}" for line in (_pressed(number) if path.touching else _free(number))),
        "    up,",
        f'    Motion({_inside("leave", number)}, "linear", up, {{"stage": Stage.POSE}}, (about.name,), "clear of it"),',
        end,
    ]
    return lines


def _inside(name: str, number: str) -> str:
    return f'action.inside({"f" if number else ""}"{name}{number}")'


def _free(number: str) -> list[str]:
    return [
        f'Motion({_inside("enter", number)}, "linear", way, {{"stage": Stage.POSE}}, reason="down to where it begins"),',
        f'Motion({_inside("follow", number)}, "trace", way, {{"speed_m_s": self.parameter(action, "speed_m_s")}}, reason="the path"),',
    ]


def _pressed(number: str) -> list[str]:
    return [
        f'Motion({_inside("tare", number)}, "zero_sensor", reason="from here on, more is pressing"),',
        f'Motion({_inside("enter", number)}, "until_contact", way, {{"free_m_s": 0.1}}, (about.name,), "down until it touches"),',
        f'Motion({_inside("follow", number)}, "compliant_slide", way, {{',
        '    "press_n": self.parameter(action, "press_n"), "speed_m_s": self.parameter(action, "slide_m_s"),',
        '    "force_limit_n": self.parameter(action, "force_limit_n"),',
        '}, (about.name,), "the path"),',
    ]


def _turn_words(turn: ShownTurn, role: str, name: str) -> Mapping[str, str]:
    vector = ", ".join(f"{round(turn.angle * v, 3):g}" for v in turn.axis)
    axis = ", ".join(f"{v:g}" for v in turn.axis)
    declared = "".join(f'\n        Parameter("{n}", {default}, "{source}"),' for n, default, source in TURNED)
    hook = f'turn_predicate("turns_{name}", ({axis}), {turn.least:g}, {turn.most:g})'
    return {
        "constants": f'\nTURN, STROKES = ({vector}), {turn.strokes}\n"""{_turn_said(turn, role)} It is done in so many grasps."""\n',
        "parameters": f'\n    parameters = ({declared}\n    )\n    moves = ("{role}",)',
        "decompose": "\n".join(f"        {line}" if line else "" for line in _strokes(role)),
        "hooks": f"\n\n@hookimpl\ndef predicates() -> Iterable[Predicate]:\n    return [{hook}]\n",
    }


def _turn_said(turn: ShownTurn, role: str) -> str:
    axis = ", ".join(f"{v:g}" for v in turn.axis)
    return f"Rotation vector of {role} in its own frame [rad]: {turn.angle:g} about ({axis}), summed over all grasps."


def _strokes(role: str) -> list[str]:
    """Return Python lines that decompose a turning task into motions: grasp the handle, turn it and let go, once
    for each stroke."""
    return [
        f'turned, touch = action.roles["{role}"], (action.roles["{role}"].name,)',
        "part, steps = tuple(v / STROKES for v in TURN), list[Location | Motion]()",
        'limits = {n: self.parameter(action, n) for n in ("speed_m_s", "force_limit_n")}',
        'close = {"to": Fingers.CLOSED, "expect": ExpectedGrip.OBJECT, "most_n": self.parameter(action, "most_n")}',
        'apart = {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}',
        "for k in range(1, STROKES + 1):",
        '    hold = Location(action.inside(f"hold_{k}"), "handle", turned.name)',
        '    way = Location(action.inside(f"way_{k}"), "turned", turned.name, {"turn": part})',
        '    back = Location(action.inside(f"away_{k}"), "retreat", None, {"straight": True})',
        "    steps += [",
        "        hold,",
        '        Motion(action.inside(f"open_{k}"), "gripper", hold, {"to": Fingers.PLACE}, reason="wider than the handle"),',
        '        Motion(action.inside(f"transfer_{k}"), "transfer", hold, reason="in front of the handle"),',
        '        Motion(action.inside(f"approach_{k}"), "linear", hold, {"stage": Stage.POSE}, touch, "around the handle"),',
        '        Motion(action.inside(f"close_{k}"), "gripper", hold, close, reason="hold the handle"),',
        "        way,",
        '        Motion(action.inside(f"turn_{k}"), "force_path", way, limits, touch, "as far as the wrist turns"),',
        '        Motion(action.inside(f"release_{k}"), "gripper", None, apart, reason="let go"),',
        "        back,",
        '        Motion(action.inside(f"back_{k}"), "linear", back, {"stage": Stage.POSE}, touch, "clear of the handle"),',
        "    ]",
        'yield Decomposition(tuple(steps), "as it was shown, in strokes")',
    ]
