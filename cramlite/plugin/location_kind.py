"""Kinds of locations: relations that plugins declare, each with its parameters and the function that grounds it."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec

from ..base.errors import nearest
from ..base.value import Value
from ..model.belief import Belief
from ..model.designators import Location, Place, Stand
from .grounding import Answer, Context

Ground = Callable[[Location, Belief, Context], Iterable[Answer]]
"""Function that grounds a location in a belief."""


class NoParameters(Value):
    """Empty set of parameters, for a kind of location that takes none."""


class LocationKind(Value):
    """Kind of location: a plugin's declaration of a relation, such as "on".

    Args:
        name: ``Location.relation``.
        summary: the place, in one sentence.
        ground: gives the places, best first.
        of: the reference object; "" where there is none.
        parameters: class whose fields are what ``Location.parameters`` may say; its docstring has a line for each of them.
        gives: the class of the grounding.
    """

    name: str
    summary: str
    ground: Ground
    of: str = ""
    parameters: type[Value] = NoParameters
    gives: type[Place | Stand] = Place

    def misfit(self, said: Mapping[str, Any]) -> str:
        """Return why the given parameters do not suit this kind of location, in words; "" if they do."""
        known = {f.name: f for f in msgspec.structs.fields(self.parameters)}
        for name in said:
            if name not in known:
                return f"the relation '{self.name}' has no parameter '{name}'; {nearest(name, known)}"
        for name, field in known.items():
            if name not in said and field.required:
                return f"the relation '{self.name}' needs the parameter '{name}': {self.explained.get(name, '')}"
        try:
            msgspec.convert(dict(said), self.parameters)
        except msgspec.ValidationError as wrong:
            what, _, where = str(wrong).partition(" - at `$.")
            return f"the parameter '{where.rstrip('`')}' of the relation '{self.name}': {what[:1].lower()}{what[1:]}"
        return ""

    @property
    def explained(self) -> Mapping[str, str]:
        """Parameter of this kind of location -> its explanation, from the docstring of ``parameters``."""
        doc = inspect.getdoc(self.parameters) or ""
        found = re.findall(r"^    (\w[\w, ]*): ((?:.|\n(?:     |$))*)", doc.partition("Args:\n")[2], re.MULTILINE)
        return {name: " ".join(text.split()) for names, text in found for name in re.split(r", ", names)}
