"""Parsing of goals in words, such as "tin on counter near hook", by the phrases that predicates declare."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import combinations

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..interpretation.fluents import GoalCondition, GoalPhrase
from ..model.entity_name import thing_of
from ..scenario.task_specs import WhereSpec
from .operators import Grounder

SIDES = {name.replace("_", " "): name for name in WhereSpec.sides()}
"""Sides of a thing, such as "left of", at which a goal may ask for a place, each with its key of a task's ``where``."""

NOT = "not "
"""Prefix of a negated goal."""

AMOUNT = "AMOUNT"
NUMBER = r"([-+]?[\d.]+ ?[a-z]+)"
"""Placeholder in a form of goals for a number with a unit, and the pattern of such a number."""

PLACE = "PLACE"
"""Placeholder in a form of goals for a thing or a region of a thing, such as "table/left"."""


class ParsedGoal(Value):
    """Parsed goal.

    Args:
        text: as it was said, with single spaces.
        things: that it is about, in the order of the form.
        meaning: what it asks for.
        side, other: key of ``where`` and the thing beside which the spot is; "" for none.
    """

    text: str
    things: tuple[str, ...]
    meaning: GoalCondition
    side: str = ""
    other: str = ""


def parse_goal(text: str, grounder: Grounder, where: str = "") -> ParsedGoal:
    """Parse a goal in words, such as "tin on counter", in a form that a predicate declares, about things of the world.

    Args:
        where: before each message, such as "scenario.yaml:3: ".

    Raises:
        UserError: it is no goal, names what there is not, or makes no sense of it.
    """
    said = " ".join(text.split())
    if said.startswith(NOT):
        return _denied(parse_goal(said.removeprefix(NOT), grounder, where), where)
    for phrase in grounder.fluents.phrases:
        found = re.fullmatch(_pattern(phrase), said)
        if found is not None:
            words, count = [g or "" for g in found.groups()], len(_places(phrase))
            amount = (words.pop(count),) if phrase.form.endswith(AMOUNT) else ()
            side, other = words[count:] or ("", "")
            what, things = f"{where}the goal '{text}'", tuple(words[:count])
            meaning = _meaning(phrase, things, amount, other, grounder, what)
            goal = ParsedGoal(said, things, meaning, SIDES.get(side, ""), other)
            _check_side(goal, what)
            return goal
    raise UserError(f"{where}'{text}' is no goal; {_forms(grounder.fluents.phrases)}.")


def _denied(goal: ParsedGoal, where: str) -> ParsedGoal:
    """Return the negation of a goal.

    Raises:
        UserError: it is made of more than one relation, so that it could fail in several ways.
    """
    denied = goal.meaning.denied if not goal.side else None
    if denied is None:
        raise UserError(f"{where}the goal '{NOT}{goal.text}' denies more than one relation; state the wanted relation instead.")
    return ParsedGoal(NOT + goal.text, goal.things, denied)


def contradiction(texts: Sequence[str], grounder: Grounder, places: Sequence[str] = ()) -> str:
    """Describe why two of several goals cannot both hold, as the predicates declare; "" if there is no contradiction.

    Args:
        places: "file:line" of each goal; none for goals that stand in no file.
    """
    goals = [parse_goal(text, grounder) for text in texts]
    for (j, one), (k, other) in combinations(enumerate(goals), 2):
        why = grounder.fluents.clash(grounder.scene, one.meaning, other.meaning) or _two_manners(one, other)
        if why:
            first, second = (f"'{g.text}'" + (f" ({places[n]})" if places else "") for n, g in ((j, one), (k, other)))
            where = f"{places[k]}: " if places else ""
            return f"{where}the goals {first} and {second} contradict each other: {why}. Leave one of them out."
    return _ring(goals, grounder, places)


def _ring(goals: Sequence[ParsedGoal], grounder: Grounder, places: Sequence[str]) -> str:
    """Describe a cycle of goals in which things would carry each other in a circle; "" if there is no cycle."""
    asked = {f: k for k, goal in reversed(list(enumerate(goals))) for f in goal.meaning.needs}
    found = grounder.fluents.ring(asked)
    if not found:
        return ""
    concerned = sorted({asked[f] for f in found})
    *others, last = (f"'{goals[k].text}'" + (f" ({places[k]})" if places else "") for k in concerned)
    where = f"{places[concerned[-1]]}: " if places else ""
    said, thing = f"{', '.join(others)} and {last}" if others else last, found[0][1]
    return f"{where}the goals {said} contradict each other: '{thing}' would have to carry itself. Leave one of them out."


def _two_manners(one: ParsedGoal, other: ParsedGoal) -> str:
    """Describe how two goals ask for different ways of putting down the same thing; "" if they do not."""
    first, second = (g.meaning.manner.where if g.meaning.manner else {} for g in (one, other))
    if one.things[0] != other.things[0]:
        return ""
    both = [f"{key} {first[key]} and {second[key]}" for key in first if second.get(key, first[key]) != first[key]]
    return f"'{one.things[0]}' cannot be {' and '.join(both)} at one time" if both else ""


def _forms(phrases: Iterable[GoalPhrase]) -> str:
    """List the forms of goals, as advice after an unknown one: "say 'THING on PLACE' or ..."."""
    forms = [f"'{p.form}'" for p in sorted(phrases, key=lambda p: abs(len(_places(p)) - 2))]  # those of two things are the commonest
    said = f"say {', '.join(forms[:-1])} or {forms[-1]}" if forms[1:] else "no plugin declares a phrase for goals"
    sides = ", ".join(f"'{s}'" for s in SIDES)
    return f"{said}; PLACE may be followed by one of {sides} and a THING"


def _places(phrase: GoalPhrase) -> list[str]:
    return [w for w in phrase.form.split() if w.isupper() and w != AMOUNT]


def _pattern(phrase: GoalPhrase) -> str:
    """Return the regular expression of a goal's form, with a group for each of its things.

    A form with a place has two more groups, for a side and the thing on whose side the place is.
    """
    words_of = {AMOUNT: NUMBER, PLACE: r"(\w+(?:/\w+)?)"}
    first, *words = (words_of.get(w, r"(\w+)") if w.isupper() else re.escape(w) for w in phrase.form.split())
    verbs = f"(?:(?:{'|'.join(map(re.escape, phrase.verbs))}) )?" if phrase.verbs else ""
    beside = rf"(?: ({'|'.join(SIDES)}) (\w+))?" if len(_places(phrase)) > 1 else ""
    return f"{first} {verbs}{' '.join(words)}{beside}"


def _meaning(
    phrase: GoalPhrase, things: tuple[str, ...], amount: tuple[str, ...], other: str, grounder: Grounder, what: str
) -> GoalCondition:
    """Return the meaning of a goal phrase with things of the world as its arguments."""
    for name in filter(None, (*things, other)):
        known = grounder.things if name == thing_of(name) else grounder.scene.types
        if name not in known:
            raise UserError(f"{what} names '{name}'; {nearest(name, known)}.")
    try:
        return phrase.meaning(grounder.scene, *things, *amount)
    except UserError as error:
        raise UserError(f"{what}: {error}") from error


def _check_side(goal: ParsedGoal, what: str) -> None:
    if not goal.side:
        return
    side = next(words for words, key in SIDES.items() if key == goal.side)
    if not goal.meaning.spot:
        raise UserError(f"{what}: '{side}' chooses a spot on a surface or in a container, and this goal names none.")
    if goal.other in goal.things:
        own = " and ".join(f"'{t}'" for t in goal.things)
        raise UserError(f"{what}: '{side}' must be followed by another thing than {own}.")
