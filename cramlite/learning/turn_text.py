"""Source text for a learned turn in the module of a package: its constants, parameters, strokes and predicate."""

from __future__ import annotations

from collections.abc import Mapping

from .shown_turn import ShownTurn

ROWS = (
    ("speed_m_s", "0.08", "as along other joints"),
    ("force_limit_n", "25.0", "as along other joints"),
    ("most_n", "20.0", "grip force: what a hand off its middle strains the arm with stays below the limit"),
)
"""Parameters of a turn in strokes: name, default and source."""


def turn_words(turn: ShownTurn, role: str, name: str) -> Mapping[str, str]:
    """Return the words of the module's template for a task that turns the thing of a role.

    Args:
        name: of the package.
    """
    vector = ", ".join(f"{round(turn.angle * v, 3):g}" for v in turn.axis)
    axis = ", ".join(f"{v:g}" for v in turn.axis)
    declared = "".join(f'\n        Parameter("{n}", {default}, "{source}"),' for n, default, source in ROWS)
    hook = f'turn_predicate("turns_{name}", ({axis}), {turn.least:g}, {turn.most:g})'
    return {
        "constants": f'\nTURN, STROKES = ({vector}), {turn.strokes}\n"""{turn_said(turn, role)} It is done in so many grasps."""\n',
        "parameters": f'\n    parameters = ({declared}\n    )\n    moves = ("{role}",)',
        "decompose": "\n".join(f"        {line}" if line else "" for line in _steps(role)),
        "hooks": f"\n\n@hookimpl\ndef predicates() -> Iterable[Predicate]:\n    return [{hook}]\n",
    }


def turn_said(turn: ShownTurn, role: str) -> str:
    """Return a sentence on a turn."""
    axis = ", ".join(f"{v:g}" for v in turn.axis)
    return f"Rotation vector of {role} in its own frame [rad]: {turn.angle:g} about ({axis}), summed over all grasps."


def _steps(role: str) -> list[str]:
    """Return the lines of a decomposition: the handle is taken, turned and let go of, once for each stroke."""
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
