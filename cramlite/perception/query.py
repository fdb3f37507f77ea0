"""Object queries: conditions on the objects in a camera's view, from an object designator or from text."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.designators import Object
from ..plugin.expert import RELATIONS, SEGMENTS, UNKNOWN, Expert, Judged

if TYPE_CHECKING:
    from ..ontology.taxonomy import Taxonomy


Check = Literal["EQUAL", "CLASS", "GEQ", "LEQ", "CONTAINS"]
ALIASES = {
    "class": "type", "color": "colour", "id": "instance", "cad-model": "model", "feature": "features",
    "hanging_from": "hangs_on",
}  # fmt: skip
DEFAULTS: Mapping[str, Check] = {"type": "CLASS", "features": "CONTAINS", **dict.fromkeys(RELATIONS, "CONTAINS")}
OPERATORS: Mapping[str, Check] = {">=": "GEQ", "<=": "LEQ", "~": "CONTAINS", "==": "EQUAL"}
POSSIBLE = 0.05
"""Least confidence of an alternative hypothesis for which an object is kept as a possible answer."""


class Condition(Value):
    """Condition on an attribute or a relation of an object.

    Args:
        key: an attribute, or a relation.
        check: EQUAL, CLASS (the class or a subclass), GEQ, LEQ (numbers), CONTAINS (one of several).
        value: word, CURIE or number.
    """

    key: str
    check: Check
    value: str | float

    def __str__(self) -> str:
        sign = {"GEQ": ">=", "LEQ": "<=", "CONTAINS": "~", "EQUAL": "=="}.get(self.check, "=")
        sign = "=" if self.check == DEFAULTS.get(self.key, "EQUAL") else sign
        return f"{self.key}{sign}{self.value}"

    @property
    def output(self) -> str:
        """Name of the value (an output of experts) by which the condition on an object is decided."""
        return "relations" if self.key in RELATIONS else self.key

    def holds(self, judged: Judged, taxonomy: Taxonomy) -> bool:
        """Check whether the best hypothesis of a value satisfies the condition."""
        return _TESTS[self.check](judged.value, self, taxonomy)

    def possible(self, judged: Judged, taxonomy: Taxonomy) -> bool:
        """Check whether the best or a less likely hypothesis of a value satisfies the condition."""
        rest = (o for o in judged.others if o.confidence >= POSSIBLE)
        return self.holds(judged, taxonomy) or any(self.holds(o, taxonomy) for o in rest)


class ObjectQuery(Value):
    """Object query: conditions on an object, and the values that are asked for.

    Args:
        conditions: all must hold.
        confidence: least confidence of an answer.
        wanted: values that an answer should have, beside those that decide it.
    """

    conditions: tuple[Condition, ...] = ()
    confidence: float = 0.0
    wanted: tuple[str, ...] = ("pose",)

    def __str__(self) -> str:
        return " ".join(map(str, self.conditions)) or "everything"

    def value(self, key: str) -> str | float | None:
        """Return the value that a query demands under a key, such as "colour"; None if it demands none."""
        return next((c.value for c in self.conditions if c.key == key), None)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the values that experts must compute: those in the query's conditions, then those that it asks for.

        A query without either needs the segments of the image.
        """
        return tuple(dict.fromkeys((*(c.output for c in self.conditions), *self.wanted))) or (SEGMENTS,)


def query_from(designator: Object, **more: str | float) -> ObjectQuery:
    """Convert an object designator to a perception query; ``more`` are further conditions on the object, as key=value.

    Only the first class is asked for; a designator's features are demanded each.
    """
    pairs: list[tuple[str, str | float]] = [("type", designator.types[0])] if designator.types else []
    pairs += [("features", f) for f in designator.features]
    if designator.entity:
        pairs.append(("instance", designator.entity))
    return ObjectQuery(tuple(Condition(k, DEFAULTS.get(k, "EQUAL"), v) for k, v in (*pairs, *more.items())))


def parse_query(text: str, taxonomy: Taxonomy, experts: Iterable[Expert], where: str = "") -> ObjectQuery:
    """Parse a query as people write it: ``type=cram:TeaBox colour=red size>=100mm on=Hanger confidence>=0.5``.

    Args:
        experts: all that are loaded: what they say of objects can be asked for.
        where: "file:line" of the text, if it is in a file; it begins each error.

    Raises:
        UserError: not of this form, an unknown key or an unknown class; the nearest right ones are named.
    """
    query, known = ObjectQuery(), {o for e in experts if e.scope != "view" for o in e.outputs}
    for word in text.split():
        condition = _condition(word, taxonomy, known, f"{where}: '{word}'" if where else f"'{word}'")
        if condition.key == "confidence":
            query = replace(query, confidence=float(condition.value))
        else:
            query = replace(query, conditions=(*query.conditions, condition))
    return query


def _condition(word: str, taxonomy: Taxonomy, known: Collection[str], where: str) -> Condition:
    """Parse one condition; ``known`` are the valid attributes, ``where`` names the condition's place in
    messages."""
    found = re.fullmatch(r"([\w-]+)(>=|<=|==|=|~)(.+)", word)
    if found is None:
        raise UserError(f"{where} is no condition of a query; write KEY=VALUE, e.g. colour=red, or KEY>=NUMBER.")
    key, sign, value = ALIASES.get(found[1], found[1]), found[2], found[3]
    valid = {*known, *RELATIONS, "confidence"}
    if key not in valid:
        written = valid | {alias for alias, of in ALIASES.items() if of in valid}
        raise UserError(f"{where}: a query cannot ask for '{found[1]}'; {nearest(found[1], written)}.")
    check = OPERATORS.get(sign) or DEFAULTS.get(key, "EQUAL")
    if check in ("GEQ", "LEQ"):
        return Condition(key, check, _number(value, where))
    if key in ("type", "features") and value != UNKNOWN:
        value = taxonomy.known(value, where)
    if key == "size":  # a length, or a word for one
        return (
            Condition(key, check, _number(value, where)) if value[0].isdigit() else Condition("size_word", check, value)
        )
    return Condition(key, check, value)


def _number(text: str, where: str) -> float:
    from pydantic import TypeAdapter, ValidationError

    from ..base.quantities import Length

    try:
        return float(text) if re.fullmatch(r"[\d.eE+-]+", text) else float(TypeAdapter(Length).validate_python(text))
    except (ValueError, ValidationError):
        raise UserError(f"{where}: '{text}' is no number; write e.g. size>=0.1 or size>=100mm.") from None


def _contains(value: Any, condition: Condition, taxonomy: Taxonomy) -> bool:
    """Check whether a perceived value, such as words or relations, contains what a condition asks for.

    Of a relation, the name or class of the other object is compared.
    """
    entries = value if isinstance(value, tuple | list | frozenset) else (value,)
    for entry in entries:
        if isinstance(entry, tuple):
            if entry[0] == condition.key and any(_means(e, str(condition.value), taxonomy) for e in entry[1:]):
                return True
        elif _means(str(entry), str(condition.value), taxonomy):
            return True
    return False


def _means(own: str, wanted: str, taxonomy: Taxonomy) -> bool:
    """Check whether a perceived name or class is the wanted one, or a subclass of the wanted class."""
    if own == wanted:
        return True
    known = taxonomy.resolve(wanted)
    return known is not None and taxonomy.resolve(own) is not None and taxonomy.is_a(own, known)


def _equal(value: Any, condition: Condition, taxonomy: Taxonomy) -> bool:
    """Check whether a perceived value equals the wanted one; a number may differ by 10 % of the wanted
    number.

    That is the accuracy of sizes from a depth camera.
    """
    if isinstance(value, float | int) and isinstance(condition.value, float | int):
        return abs(value - condition.value) <= 0.1 * abs(condition.value)
    return str(value) == str(condition.value)


def _class(value: Any, condition: Condition, taxonomy: Taxonomy) -> bool:
    if UNKNOWN in (value, condition.value):
        return bool(value == condition.value)
    return taxonomy.is_a(str(value), str(condition.value))


_TESTS: Mapping[Check, Callable[[Any, Condition, Taxonomy], bool]] = {
    "EQUAL": _equal,
    "CLASS": _class,
    "GEQ": lambda value, condition, _: float(value) >= float(condition.value),
    "LEQ": lambda value, condition, _: float(value) <= float(condition.value),
    "CONTAINS": _contains,
}
