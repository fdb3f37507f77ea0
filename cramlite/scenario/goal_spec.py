"""Goals as data, for programs that write goals: ``{"goal": "on", "things": ["tin", "tray"]}`` means "tin on tray"."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError

from ..base.errors import UserError
from ..base.spec import Spec
from .task_specs import WhereSpec


class EachSpec(Spec):
    """Placeholder in a goal for every thing of a class."""

    each: str

    def __str__(self) -> str:
        return f"each {self.each}"


class AnySpec(Spec):
    """Placeholder in a goal for any one thing of a class."""

    any: str

    def __str__(self) -> str:
        return f"any {self.any}"


class CountSpec(Spec):
    """Placeholder in a goal for a number of things of a class."""

    count: Annotated[int, Field(ge=1)]
    of: str

    def __str__(self) -> str:
        return f"{self.count} of {self.of}"


class PhraseSpec(Spec):
    """Goal in data form: the words of a goal phrase, and the things that it is about.

    Args:
        goal: the words of its form that are not things, e.g. "on", "open", "open by", "poured into".
        things: in the order of the form; in the place of the first a class with ``each``, ``any``, or ``count`` and ``of``.
        amount: with its unit, e.g. "120 mm".
        near, left_of, right_of, in_front_of, behind: a thing beside which the spot is.
    """

    goal: str
    things: Annotated[tuple[str | EachSpec | AnySpec | CountSpec, ...], Field(min_length=1, max_length=2)]
    amount: str = ""
    near: str = ""
    left_of: str = ""
    right_of: str = ""
    in_front_of: str = ""
    behind: str = ""

    def __str__(self) -> str:
        first, *others = map(str, self.things)
        sides = ((name.replace("_", " "), getattr(self, name)) for name in WhereSpec.sides())
        words = [first, self.goal, *others, self.amount, *(f"{side} {thing}" for side, thing in sides if thing)]
        return " ".join(filter(None, words))


class NotSpec(Spec):
    """Denial of a goal, written as data: the goal must not hold in the end."""

    model_config = ConfigDict(populate_by_name=True)
    denied: Annotated[PhraseSpec, Field(alias="not")]

    def __str__(self) -> str:
        return f"not {self.denied}"


class OrSpec(Spec):
    """Alternative goals, of which one must hold."""

    model_config = ConfigDict(populate_by_name=True)
    options: Annotated[tuple[PhraseSpec | NotSpec, ...], Field(alias="or", min_length=2)]

    def __str__(self) -> str:
        return " or ".join(map(str, self.options))


class SaySpec(Spec):
    """Goals that are given as an English sentence.

    Args:
        say: the sentence.
        view: from where left and right are told: "robot", "camera", or a point "x, y" of the world [m].
    """

    say: Annotated[str, Field(min_length=1)]
    view: str = ""

    def __str__(self) -> str:
        return f"say{f' from {self.view}' if self.view else ''}: {' '.join(self.say.split())}"


_SPECS: Mapping[str, type[Spec]] = {"goal": PhraseSpec, "not": NotSpec, "or": OrSpec, "say": SaySpec}


def goal_text(data: Any) -> Any:
    """Return a goal in words; a value that is no mapping is returned unchanged.

    Raises:
        ValueError: a mapping that is no goal; it says where and what would be right.
    """
    if not isinstance(data, Mapping):
        return data
    spec = next((s for key, s in _SPECS.items() if key in data), None)
    if spec is None:
        raise ValueError(
            'a goal as data is {"goal": "on", "things": ["tin", "tray"]}, {"not": GOAL}, {"or": [GOAL, GOAL]} or {"say": SENTENCE}'
        )
    try:
        return str(spec.model_validate(data))
    except ValidationError as error:
        first = error.errors()[0]
        if first["type"] == "string_type" and isinstance(first["input"], Mapping):
            raise ValueError(
                f"in the goal {dict(first['input'])} is no thing; a thing is given as its name, "
                '{"each": CLASS}, {"any": CLASS} or {"count": NUMBER, "of": CLASS}'
            ) from error
        place = ".".join(str(p) for p in first["loc"])
        raise ValueError(f"in the goal '{place}': {first['msg'].removeprefix('Value error, ').lower()}") from error


GoalText = Annotated[str, BeforeValidator(goal_text, json_schema_input_type=str | PhraseSpec | NotSpec | OrSpec | SaySpec)]
"""A goal in words, or as data."""


def listed_goals(data: Any) -> Any:
    """Return a list of goals; a single sentence, ``{"say": "put the tin on the tray"}``, becomes a list.

    Raises:
        ValueError: a text alone, which may be a condition or a sentence.
    """
    if isinstance(data, str):
        raise ValueError(f"this is text; a condition is in a list, [{data}], and a sentence is written {{say: {data}}}")
    return [data] if isinstance(data, Mapping) and "say" in data else data


GoalTexts = Annotated[
    tuple[GoalText, ...], BeforeValidator(listed_goals, json_schema_input_type=tuple[GoalText, ...] | SaySpec)
]
"""Goals of a scenario as a list, or as a single sentence under ``say``."""


def goal_texts(data: Any) -> tuple[str, ...]:
    """Return goals in words; each may be given in words or as data.

    Raises:
        UserError: it is no list of goals.
    """
    try:
        return TypeAdapter(Annotated[GoalTexts, Field(min_length=1)]).validate_python(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = f"goal {first['loc'][0] + 1}: " if first["loc"] and isinstance(first["loc"][0], int) else ""
        said = first["msg"].removeprefix("Value error, ")
        raise UserError(f"{where}{said}; a goal is a list such as ['tin on tray', {{'goal': 'open', 'things': ['drawer']}}].") from error
