"""Expert for materials: looked up for the recognised class, not measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from cramlite.plugin import UNKNOWN, Expert, Inputs, Judged, Unresolvable, hookimpl

from ..objects.products import entries

PROPERTY = "cram:material"


def known_material(model: str, kind: str, taxonomy: Any) -> tuple[str, str] | None:
    """Return the material of a product and the source that states it; None if no source does.

    Sources are the product's own entry, else the nearest class of the ontology.
    """
    own = entries().get(model, {}).get("material")
    if own is not None:
        return str(own), f"the entry of '{model}'"
    said = taxonomy.restrictions_on(kind, PROPERTY)
    return (str(said[0][1].filler), f"the ontology's class {said[0][0]}") if said else None


def materials(priors: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the materials of the known models and fixtures."""
    things = (*priors.get("models", ()), *priors.get("fixtures", ()))
    found = (known_material(t.name, t.type, priors["taxonomy"]) for t in things)
    return tuple(sorted({said[0] for said in found if said}))


def material(inputs: Inputs) -> Mapping[str, Any]:
    """Return the possible materials of an object with their confidences, the likeliest first.

    They are the materials of the models that the object may be; without such models, that of its fixture or
    class.
    """
    models = {m.name: m for m in inputs["models"]}
    kind = inputs.judged("type")
    looks = [(c.value, models[c.value].type, c.confidence) for c in inputs["candidates"] if c.value in models]
    if not looks and kind.value != UNKNOWN:
        fixture = inputs.get("fixture")
        looks = [(fixture.name if fixture else "", kind.value, kind.confidence)]
    shares: dict[str, float] = {}
    whys: dict[str, str] = {}
    for name, type_, sure in looks:
        said = known_material(name, type_, inputs["taxonomy"])
        if said is not None:
            shares[said[0]] = shares.get(said[0], 0.0) + sure
            whys.setdefault(said[0], f"not seen: {said[0]} is the material stated by {said[1]}, and the object was recognised as a {type_}")
    order = sorted(shares, key=lambda m: (-shares[m], m))
    if kind.value == UNKNOWN or not order:
        raise Unresolvable(f"no source has the material of a '{kind.value}'")
    ranked = [Judged(m, min(1.0, shares[m]), whys[m]) for m in order]
    return {"material": Judged(ranked[0].value, ranked[0].confidence, ranked[0].reason, tuple(ranked[1:]))}


@hookimpl
def experts() -> Iterable[Expert]:
    return [
        Expert("known_material", "the material that is known of what it was taken for",
               ("candidates", "type", "models", "taxonomy"), ("material",), material, "object", uses=("fixture",),
               domains={"material": materials}, cost_ms=0.2),
    ]  # fmt: skip
