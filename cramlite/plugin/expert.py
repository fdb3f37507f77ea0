"""Perception experts: declarations by plugins of values that can be computed from a view.

An expert is a function from named values to named values. The engine chains experts backwards from what is asked
(``expert_plan``), runs them cheapest first and falls back when one fails (``perception``).

Three scopes: a *view* expert runs once a picture, an *object* expert once for each segment, a *scene* expert once over
all objects. The last is given ``objects``, for each of them a mapping of those declared inputs that are known of it,
and answers with one entry for each, None where it can say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from msgspec import field

from ..base.value import Value
from .task_type import Parameter

if TYPE_CHECKING:
    pass


VIEW, SEGMENTS, SEGMENT, OBJECTS = "view", "segments", "segment", "objects"
"""Names of inputs and outputs that the engine knows: the camera view, its segments, the segment of one object, all objects."""
Scope = Literal["view", "object", "scene"]
Domain = tuple[str, ...] | Callable[[Mapping[str, Any]], tuple[str, ...]]


class Judged(Value):
    """Value that a perception expert computed, with its confidence, its reason and the alternative hypotheses.

    Args:
        value: any; words and CURIEs are compared with queries, numbers are in SI units.
        confidence: 0 to 1.
        reason: a clause with numbers and units.
        others: the hypotheses that lost, best first.
    """

    value: Any
    confidence: float = 1.0
    reason: str = ""
    others: tuple[Judged, ...] = ()

    def __post_init__(self) -> None:
        if not 0.0 <= self.confidence <= 1.0:
            raise ValueError(f"a confidence is between 0 and 1, not {self.confidence}")


class Inputs(Value):
    """Inputs of an expert: the values that the expert declared, and no others.

    Args:
        values: by name; those under ``uses`` may be missing.
        parameters: by name.
    """

    values: Mapping[str, Any]
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        """Return an expert's input by its name, without the confidence of the value."""
        found = self.values[name]
        return found.value if isinstance(found, Judged) else found

    def get(self, name: str, default: Any = None) -> Any:
        """Return an expert's input by its name; ``default`` if it is missing."""
        return self[name] if name in self.values else default

    def judged(self, name: str) -> Judged:
        """Return an expert's input by its name, with the confidence of the value and the alternative hypotheses."""
        found = self.values[name]
        return found if isinstance(found, Judged) else Judged(found)


class Expert(Value):
    """Perception expert: a function on views, with its declared inputs and outputs.

    Args:
        name: unique.
        summary: what it does, in a clause.
        inputs: values that it needs.
        outputs: values that it makes.
        run: from Inputs to a value for each output; raises ``Unresolvable(reason)`` where it can say nothing.
        scope: see the module.
        uses: values that it takes into account where somebody can make them; it runs without them too.
        domains: output -> what it may say: words, or classes as CURIEs; a function of the prior values where these
            decide. An output without a domain may be anything.
        cost_ms: CPU time of one run at 640 x 480 [ms], measured by its author; the cheapest provider is asked first.
        parameters: numbers with their sources.
    """

    name: str
    summary: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    run: Callable[[Inputs], Mapping[str, Any]]
    scope: Scope = "view"
    uses: tuple[str, ...] = ()
    domains: Mapping[str, Domain] = field(default_factory=dict)
    cost_ms: float = 1.0
    parameters: tuple[Parameter, ...] = ()

    def domain(self, output: str, priors: Mapping[str, Any]) -> tuple[str, ...] | None:
        """Return the values that an output of this perception expert may have; None if it may have any value."""
        declared = self.domains.get(output)
        return declared(priors) if callable(declared) else declared

    def defaults(self) -> dict[str, float]:
        """Return parameter -> default value, in the unit that the parameter's name ends with."""
        return {p.name: p.default for p in self.parameters}


RELATIONS = ("on", "in", "hangs_on", "left_of", "right_of", "above", "below")
"""Spatial relations between objects that scene experts may state."""
UNKNOWN = "unknown"
"""Output of an expert for a property whose true value is outside the expert's domain."""
