"""Perception results: answers to a query about a view, dropped objects, annotations by expert, and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from msgspec import field

from ..base.value import Value
from ..model.geometry import Pose
from ..plugin.expert import Judged
from .pipeline import Pipeline
from .query import ObjectQuery

if TYPE_CHECKING:
    pass



class Annotation(Value):
    """Annotation: a value and the expert that gave it."""

    judged: Judged
    expert: str

    @property
    def value(self) -> Any:
        """Value that the expert gave, such as a class or a pose; of several hypotheses, the value of the best."""
        return self.judged.value


class Percept(Value):
    """Percept: an object that was seen, with its annotations.

    Args:
        number: among the objects of the view, from 1.
        values: name -> what was said; the part of the image is under "segment".
        confidence: of the weakest value that the query decides on, 0 to 1.
        dropped: why it is no answer; "" for answers.
        missing: values that nobody could say of it, with the reasons.
    """

    number: int
    values: Mapping[str, Annotation]
    confidence: float = 1.0
    dropped: str = ""
    missing: Mapping[str, str] = field(default_factory=dict)

    def value(self, name: str, default: Any = None) -> Any:
        """Return the value of the object's annotation with a given name; ``default`` if no expert gave it."""
        return self.values[name].value if name in self.values else default

    @property
    def experts(self) -> tuple[str, ...]:
        """Names of the experts that annotated the object."""
        return tuple(dict.fromkeys(s.expert for s in self.values.values()))


class Run(Value):
    """Run of an expert: number of objects that it was asked about, CPU time [ms], and failures."""

    expert: str
    output: str
    count: int
    ms: float
    failures: tuple[str, ...] = ()


class Perceived(Value):
    """Perception result: the answers to a query, best first, and everything that led to them.

    Args:
        answers: objects that satisfy every condition.
        dropped: the other objects, the nearest misses first.
        scene: values of the whole view.
        runs: in order.
        remarks: what a person should know: ambiguity, partial answers, nothing found.
    """

    query: ObjectQuery
    pipeline: Pipeline
    answers: tuple[Percept, ...]
    dropped: tuple[Percept, ...]
    scene: Mapping[str, Annotation]
    runs: tuple[Run, ...]
    remarks: tuple[str, ...] = ()

    @property
    def ms(self) -> float:
        """CPU time of all experts [ms]."""
        return sum(r.ms for r in self.runs)


SHOWN = 3
"""Largest number of alternative hypotheses of a value that the text lists; the page and the JSON have all."""


def perceived_text(found: Perceived) -> str:
    """Return the answers, the dropped objects with reasons, and the pipeline as text."""
    lines = [f"{len(found.answers)} answers to '{found.query}' in {found.ms:.0f} ms of CPU time"]
    for k, answer in enumerate(found.answers, 1):
        lines.append(f"  {k}. object {answer.number}, confidence {answer.confidence:.2f}")
        lines += [f"       {line}" for line in _value_lines(answer, found)]
    lines += [f"  not object {p.number}: {p.dropped}" for p in found.dropped]
    lines += [f"  remark: {r}" for r in found.remarks]
    lines.append(f"  pipeline: {found.pipeline}")
    lines += [f"  failed: {f}" for r in found.runs for f in r.failures]
    return "\n".join(lines)


def _value_lines(answer: Percept, found: Perceived) -> Iterator[str]:
    for name in found.query.outputs:
        said = answer.values.get(name)
        if said is None or (shown := plain(said.value)) is None:
            continue
        lost = ", ".join(f"{plain(o.value)} {o.confidence:.2f}" for o in said.judged.others[:SHOWN] if name != "pose")
        yield f"{name}: {in_words(shown)}  ({said.expert}, {said.judged.confidence:.2f}: {said.judged.reason})" + (
            f"; rather than {lost}" if lost else ""
        )


def in_words(value: Any) -> str:
    """Format a perceived value, given as JSON values, as text for people."""
    if isinstance(value, dict) and "position" in value:
        x, y, z = value["position"]
        w, *v = value["quaternion"]
        return f"[{x:.4f}, {y:.4f}, {z:.4f}] m, [{w:.4f}, {v[0]:.4f}, {v[1]:.4f}, {v[2]:.4f}]"
    if isinstance(value, list):
        return "; ".join(" ".join(v) if isinstance(v, list) else str(v) for v in value) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def plain(value: Any) -> Any:
    """Return a value as JSON values; None for images and point clouds."""
    if isinstance(value, str | int | float):
        return value
    if isinstance(value, Pose):
        return {"position": list(value.position), "quaternion": list(value.quaternion)}
    if isinstance(value, tuple) and all(isinstance(v, str) or (isinstance(v, tuple) and v) for v in value):
        return [list(v) if isinstance(v, tuple) else v for v in value]
    return None


def perceived_json(found: Perceived) -> dict[str, Any]:
    """Return the result as JSON values, without images."""
    return {
        "query": str(found.query),
        "answers": [_percept_json(p) for p in found.answers],
        "dropped": [_percept_json(p) for p in found.dropped],
        "remarks": found.remarks,
        "pipeline": [{"value": s.output, "experts": [p.name for p in s.providers]} for s in found.pipeline.stages],
        "runs": found.runs,
        "cpu_ms": found.ms,
    }


def _percept_json(percept: Percept) -> dict[str, Any]:
    values = {
        name: {"expert": said.expert, **_judged_json(said.judged)}
        for name, said in percept.values.items()
        if plain(said.value) is not None
    }
    own = {"object": percept.number, "confidence": percept.confidence, "experts": percept.experts, "values": values}
    return own | {"dropped": percept.dropped, "missing": percept.missing}


def _judged_json(judged: Judged) -> dict[str, Any]:
    others = [_judged_json(o) for o in judged.others]
    return {"value": plain(judged.value), "confidence": judged.confidence, "reason": judged.reason, "others": others}
