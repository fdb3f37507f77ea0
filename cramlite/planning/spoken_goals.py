"""Goals that a person says in a sentence ("say: put both cups onto the tray"), as goals about the things of a scene."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..base.errors import UserError
from .goal_parser import parse_goal
from .operators import Grounder
from .task_goals import Goal
from .trace import SENTENCE

if TYPE_CHECKING:
    from ..interpretation.fluents import SymbolicWorld
    from ..language.sentence import Understood
    from ..plugin.catalogue import Knowledge
    from .trace import Trace

SAID = re.compile(r"say(?: from (?P<view>[^:]+))?: (?P<sentence>.+)", re.DOTALL)


def spoken(goal: Goal, scene: SymbolicWorld, knowledge: Knowledge, where: str = "", trace: Trace | None = None) -> Goal:
    """Return a goal whose sentences are replaced by the goals that they mean; one without any stays as it is.

    Args:
        where: before each message, such as "scenario.yaml:3: ".
        trace: is told what was understood.

    Raises:
        NotUnderstood: a sentence is ambiguous, false of the scene, or in words that are not known.
    """
    if not any(SAID.fullmatch(text) for text in goal.says):
        return goal
    return Goal(tuple(dict.fromkeys(g for text in goal.says for g in _goals(text, scene, knowledge, where, trace))))


def _goals(text: str, scene: SymbolicWorld, knowledge: Knowledge, where: str, trace: Trace | None) -> Iterator[str]:
    found = SAID.fullmatch(text)
    if found is None:
        yield text
        return
    understood = understand(found["sentence"], scene, knowledge, found["view"] or "", where)
    if trace is not None:
        _trace(understood, trace)
    yield from understood.goals


def understand(sentence: str, scene: SymbolicWorld, knowledge: Knowledge, view: str = "", where: str = "") -> Understood:
    """Understand a sentence by the grammar, or, if it has unknown words, by the first plugin that reads it
    (``read_sentence``).

    Args:
        view: from where left and right are told: "robot", "camera" or "x, y"; by default that of a fixed camera, else the robot's.

    Raises:
        NotUnderstood: nobody understands it, or what a plugin answers are no goals here.
    """
    from ..language import sentence as language

    grounder = Grounder(scene, knowledge.predicates)
    try:
        return language.understand(sentence, scene, grounder.fluents, view)
    except language.NotUnderstood as error:
        forms = tuple(p.form for p in grounder.fluents.phrases)
        answer = knowledge.registry.first("read_sentence", sentence=sentence, scene=scene, forms=forms) if error.open else None
        if answer is None:
            raise language.NotUnderstood(f"{where}{error}", open=error.open, ambiguous=error.ambiguous) from error
        return _checked(sentence, tuple(map(str, answer)), grounder, where)


def _checked(sentence: str, goals: tuple[str, ...], grounder: Grounder, where: str) -> Understood:
    """Return the goals that a plugin read from a sentence, checked to be about things of the scene."""
    from ..language.meanings import Literal
    from ..language.sentence import NotUnderstood, Understood

    try:
        for goal in goals:
            parse_goal(goal, grounder)
    except UserError as error:
        raise NotUnderstood(f"{where}'{sentence}' was read by a plugin as '{' and '.join(goals)}', which cannot be: {error}") from error
    if not goals:
        raise NotUnderstood(f"{where}a plugin found no goal in '{sentence}'; say what shall hold in the end.")
    return Understood(sentence, tuple(map(Literal, goals)), by="plugin")


def _trace(understood: Understood, trace: Trace) -> None:
    view = f", left and right as seen from {understood.view}" if understood.view else ""
    view += f", left out: {'; '.join(map(repr, understood.left_out))}" if understood.left_out else ""
    for literal in understood.literals:
        origins = "; ".join(f"'{words}' is {meant}" for words, meant in literal.origins) or f"read by a {understood.by}"
        trace.add(0, SENTENCE, literal.goal, "asked", understood.by, f"of '{understood.sentence}': {origins}{view}", kind="goal")
