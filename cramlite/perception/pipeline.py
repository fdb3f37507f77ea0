"""Perception pipelines: backward chaining from a query to the experts that answer it.

The cheapest experts come first, and those that can never give a wanted value are left out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from msgspec import Struct

from ..base.errors import CramliteError, did_you_mean
from ..base.value import Value
from ..plugin.expert import OBJECTS, SEGMENT, SEGMENTS, UNKNOWN, Expert
from .query import Check, ObjectQuery

INFINITE = float("inf")


class NoPipeline(CramliteError):
    """Failure to find experts that can answer a query; the message names the input that no expert makes."""

    exit_code = 1


class PipelineStage(Value):
    """Stage of a pipeline: a value, and the experts that can make it.

    Args:
        output: the value.
        providers: experts that can be run, cheapest first; the others are asked where those before fail.
        cost_ms: of the cheapest, without what it needs.
    """

    output: str
    providers: tuple[Expert, ...]
    cost_ms: float


class Pipeline(Value):
    """Perception pipeline: the values on the way to an answer, in the order in which they are made.

    Args:
        query: what is asked.
        stages: each after those that it needs.
        given: names of the values that are there from the start.
        refused: experts that could have been meant, and why they are not.
        reserve: other values that can be made: what a provider needs that is asked after another failed.
    """

    query: ObjectQuery
    stages: tuple[PipelineStage, ...]
    given: tuple[str, ...]
    refused: tuple[str, ...] = ()
    reserve: tuple[PipelineStage, ...] = ()

    def providers(self, output: str) -> tuple[Expert, ...]:
        """Return the experts that can make a value, in the order of asking; empty if none can."""
        return next((s.providers for s in (*self.stages, *self.reserve) if s.output == output), ())

    def __str__(self) -> str:
        return " -> ".join(f"{s.output} ({', else '.join(p.name for p in s.providers)})" for s in self.stages)


def plan_pipeline(
    query: ObjectQuery, experts: Iterable[Expert], priors: Mapping[str, Any], taxonomy: Any = None
) -> Pipeline:
    """Find the cheapest pipeline that answers a query.

    Args:
        priors: values known beforehand, by name; among them the view.
        taxonomy: for classes in value domains.

    Raises:
        NoPipeline: a value that the query asks for cannot be made; says which input is missing.
    """
    planner = _Planner(tuple(experts), priors, taxonomy, query)
    for output in query.outputs:
        if planner.cost(output) == INFINITE:
            raise NoPipeline(f"Nobody can answer '{query}': {planner.why(output)}.")
    order: list[str] = []
    for output in sorted(query.outputs, key=lambda o: (planner.cost(o), o)):
        planner.before(output, order)
    others = sorted({o for e in planner.experts for o in e.outputs} - set(order) - set(priors))
    stages, reserve = planner.stages(order), planner.stages(others)
    return Pipeline(query, stages, tuple(sorted(priors)), tuple(planner.refused()), reserve)


class _Planner(Struct, dict=True):
    """Planner of perception: it chooses the experts that answer one query about objects, and their order."""

    experts: tuple[Expert, ...]
    priors: Mapping[str, Any]
    taxonomy: Any
    query: ObjectQuery

    def __post_init__(self) -> None:
        self._costs: dict[str, float] = dict.fromkeys((*self.priors, OBJECTS), 0.0)
        self._settle()

    def _settle(self) -> None:
        """Compute the cost of each value: an expert costs its own time and that of its inputs (Bellman and
        Ford)."""
        changed = True
        while changed:
            changed = False
            for expert in self.experts:
                total = expert.cost_ms + sum(self.cost(i) for i in self._needs(expert))
                for output in expert.outputs:
                    if total < self.cost(output) and not self._unfit(expert, output):
                        self._costs[output], changed = total, True

    def cost(self, output: str) -> float:
        return self._costs.get(output, INFINITE)

    def _needs(self, expert: Expert) -> tuple[str, ...]:
        """Return the inputs of an expert, with the segmentation if it works on single objects."""
        extra = () if expert.scope == "view" else (SEGMENTS,)
        return tuple(dict.fromkeys((*extra, *(i for i in expert.inputs if i not in (SEGMENT, OBJECTS)))))

    def providers(self, output: str) -> list[Expert]:
        """Return the experts that make a value and whose inputs can be made, the cheapest in total first."""
        able = [
            (e.cost_ms + sum(self.cost(i) for i in self._needs(e)), e)
            for e in self.experts
            if output in e.outputs and not self._unfit(e, output)
        ]
        return [e for total, e in sorted(able, key=lambda p: (p[0], p[1].name)) if total < INFINITE]

    def stages(self, outputs: Iterable[str]) -> tuple[PipelineStage, ...]:
        return tuple(PipelineStage(o, tuple(p), p[0].cost_ms) for o in outputs if (p := self.providers(o)))

    def before(self, output: str, order: list[str], open_: Collection[str] = ()) -> None:
        """Append a value's name to the order of computation, after the inputs and optional inputs of the
        cheapest expert that makes it."""
        if output in self.priors or output == OBJECTS or output in order or output in open_:
            return
        for provider in self.providers(output)[:1]:
            names = (*self._needs(provider), *(u for u in provider.uses if self.cost(u) < INFINITE))
            for name in sorted(names, key=lambda n: (self.cost(n), n)):  # what is cheap may exclude objects
                self.before(name, order, (*open_, output))
        order.append(output)

    def _unfit(self, expert: Expert, output: str) -> str:
        """Return why an expert can never make a value that fulfils the query's condition; "" if it can."""
        domain = expert.domain(output, self.priors)
        if domain is None:
            return ""
        for condition in self.query.conditions:
            if condition.output == output and not self._within(condition.value, condition.check, condition.key, domain):
                said = ", ".join(domain) or "nothing"
                hint = did_you_mean(str(condition.value), domain)
                return f"expert '{expert.name}' never gives {condition.key} '{condition.value}'; {hint}its values are: {said}"
        return ""

    def _within(self, value: str | float, check: Check, key: str, domain: tuple[str, ...]) -> bool:
        if key in domain:  # a relation's name
            return True
        if isinstance(value, float) or check in ("GEQ", "LEQ"):
            return True
        if check == "CLASS" and value != UNKNOWN and self.taxonomy is not None:
            return any(d != UNKNOWN and self.taxonomy.is_a(d, value) for d in domain)
        return value in domain

    def refused(self) -> list[str]:
        return [why for e in self.experts for o in e.outputs if (why := self._unfit(e, o))]

    def why(self, output: str, open_: tuple[str, ...] = ()) -> str:
        """Return why a value cannot be made: the chain of experts down to the input that no expert makes."""
        makers = [e for e in self.experts if output in e.outputs]
        if not makers:
            return f"no expert makes '{output}', and no value of it is given beforehand"
        reasons = []
        for expert in makers:
            if unfit := self._unfit(expert, output):
                reasons.append(unfit)
                continue
            missing = [i for i in self._needs(expert) if self.cost(i) == INFINITE and i not in open_]
            reasons += [
                f"expert '{expert.name}' needs '{i}' for '{output}', and {self.why(i, (*open_, output))}"
                for i in missing
            ]
        return "; ".join(dict.fromkeys(reasons)) or f"'{output}' depends on itself"
