"""Execution of a perception pipeline: experts are asked about a view, and objects that do not fit are dropped with the reason."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from msgspec import Struct, field

from ..base.errors import DEFECTS, Unresolvable
from ..base.pulse import checkpoint
from ..ontology.taxonomy import Taxonomy
from ..plugin.expert import OBJECTS, SEGMENT, SEGMENTS, VIEW, Expert, Inputs, Judged
from .pipeline import Pipeline, plan_pipeline
from .query import Condition, ObjectQuery
from .result import Annotation, Perceived, Percept, Run

OnFault = Callable[[str, BaseException], str]
NEAR = 0.1
"""Difference of confidence below which two answers count as equally good."""


def perceive(
    query: ObjectQuery,
    experts: Iterable[Expert],
    priors: Mapping[str, Any],
    taxonomy: Taxonomy,
    on_fault: OnFault = lambda expert, error: f"expert '{expert}' broke: {type(error).__name__}: {error}",
) -> Perceived:
    """Answer a query about a view.

    Args:
        priors: the view under "view", and further values that are known beforehand: "models", "fixtures", "region", ...
        on_fault: is told of an expert's bug, and says it in a clause.

    Raises:
        NoPipeline: the experts there are cannot answer it.
    """
    pipeline = plan_pipeline(query, experts, priors, taxonomy)
    running = _Running(pipeline, taxonomy, on_fault, {k: Annotation(Judged(v), "given") for k, v in priors.items()})
    for stage in pipeline.stages:
        running.make(stage.output)
        running.prune()
    return running.result()


class _Object(Struct):
    """Object of a view while the pipeline runs: its values so far, and why it was dropped."""

    number: int
    values: dict[str, Annotation]
    dropped: str = ""
    passed: int = 0
    missing: dict[str, list[str]] = field(default_factory=dict)


class _Running(Struct):
    """Perception pipeline during its execution."""

    pipeline: Pipeline
    taxonomy: Taxonomy
    on_fault: OnFault
    scene: dict[str, Annotation]
    objects: list[_Object] = field(default_factory=list)
    runs: list[Run] = field(default_factory=list)
    tried: set[tuple[str, int]] = field(default_factory=set)
    failures: dict[str, list[str]] = field(default_factory=dict)
    making: list[str] = field(default_factory=list)

    def make(self, output: str) -> None:
        """Ask the experts for a value in order, each about the objects that do not have the value yet.

        A value that is being made is not made for its own sake: what an expert uses may depend on what it makes.
        """
        if output in self.making:
            return
        self.making.append(output)
        for expert in self.pipeline.providers(output):
            if not self._lacks(output, expert):
                break
            for name in (*expert.inputs, *expert.uses):
                if name not in (VIEW, SEGMENT, OBJECTS) and self._lacks(name, expert):
                    self.make(name)
            self._run(expert, output)
        self.making.pop()

    def _lacks(self, output: str, expert: Expert) -> bool:
        if output in self.scene:
            return False
        if expert.scope == "view" or output == SEGMENTS:
            return True
        return any(output not in o.values for o in self._alive())

    def _alive(self) -> list[_Object]:
        return [o for o in self.objects if not o.dropped]

    def _run(self, expert: Expert, output: str) -> None:
        begin, notes, count = time.process_time(), [], 0
        if expert.scope != "object":
            if (expert.name, 0) in self.tried:
                return
            self.tried.add((expert.name, 0))
            count = len(self.objects) if expert.scope == "scene" else 1
            notes += self._scene(expert) if expert.scope == "scene" else self._view(expert)
        else:
            for thing in self._alive():
                if output not in thing.values and (expert.name, thing.number) not in self.tried:
                    count += 1
                    notes += self._object(expert, thing, output)
        self.failures.setdefault(output, []).extend(notes)
        self.runs.append(Run(expert.name, output, count, 1000 * (time.process_time() - begin), tuple(notes)))

    def _view(self, expert: Expert) -> list[str]:
        found, why = self._ask(expert, self.scene)
        if found is None:
            return [why]
        self.scene |= found
        if SEGMENTS in found and not self.objects:
            parts: Sequence[Any] = found[SEGMENTS].value
            self.objects = [_Object(k, {SEGMENT: Annotation(Judged(p), expert.name)}) for k, p in enumerate(parts, 1)]
        return []

    def _object(self, expert: Expert, thing: _Object, output: str) -> list[str]:
        self.tried.add((expert.name, thing.number))
        found, why = self._ask(expert, {**self.scene, **thing.values})
        if found is None:
            thing.missing.setdefault(output, []).append(why)
            return [f"object {thing.number}: {why}"]
        for name, said in found.items():
            thing.values[name] = _replacing(said, thing.values.get(name))
        return []

    def _scene(self, expert: Expert) -> list[str]:
        """Ask an expert about the whole scene; it answers with one entry for each object, None for an object
        that it does not know."""
        declared = {*expert.inputs, *expert.uses}
        table = tuple({k: s.judged for k, s in o.values.items() if k in declared} for o in self.objects)
        seen = {**self.scene, OBJECTS: Annotation(Judged(table), "engine")}
        of_objects = {k: Annotation(Judged(None), "engine") for row in table for k in row}
        found, why = self._ask(expert, {**of_objects, **seen}, raw=True)
        if found is None:
            return [why]
        for name, said in found.items():
            for thing, entry in zip(self.objects, said.value, strict=True):
                if entry is not None:
                    thing.values[name] = Annotation(_as_judged(entry), expert.name)
        return []

    def _ask(
        self, expert: Expert, known: Mapping[str, Annotation], *, raw: bool = False
    ) -> tuple[dict[str, Annotation] | None, str]:
        """Return the answer of an expert, which sees its declared inputs only; None and the reason if it
        fails."""
        missing = [i for i in expert.inputs if i not in known]
        if missing:
            return None, f"expert '{expert.name}' lacks {', '.join(missing)}"
        checkpoint()
        values = {n: known[n].judged for n in (*expert.inputs, *expert.uses) if n in known}
        try:
            found = expert.run(Inputs(values, expert.defaults()))
            absent = [o for o in expert.outputs if o not in found]
            if absent:
                raise TypeError(f"the expert returned no {', '.join(absent)}, which it declares as output")
            entries = {o: Annotation(Judged(found[o]) if raw else _as_judged(found[o]), expert.name) for o in expert.outputs}
            if raw and any(len(e.value) != len(self.objects) for e in entries.values()):
                raise TypeError(f"a scene expert must answer with one entry for each of the {len(self.objects)} objects")
            return entries, ""
        except Unresolvable as impossible:
            return None, f"expert '{expert.name}': {impossible.reason}"
        except DEFECTS as error:
            return None, self.on_fault(expert.name, error)

    def prune(self) -> None:
        """Drop objects for which a condition cannot hold any more, once all experts that need the whole scene
        were asked."""
        pending = [s for s in self.pipeline.stages if any(p.scope == "scene" for p in s.providers)]
        made = {r.output for r in self.runs}
        if any(s.output not in made for s in pending):
            return
        for thing in self._alive():
            self._check_conditions(thing)

    def _check_conditions(self, thing: _Object) -> None:
        for condition in self.pipeline.query.conditions:
            said = thing.values.get(condition.output)
            if said is None:
                continue
            if not condition.possible(said.judged, self.taxonomy):
                thing.dropped = _not(condition, said, "not")
                return
            thing.passed += 1

    def result(self) -> Perceived:
        """Return the answers: objects for whose best hypotheses every condition holds with enough
        confidence."""
        percepts = [self._percept(o) for o in self.objects]
        answers = sorted((p for p in percepts if not p.dropped), key=lambda p: (-p.confidence, p.number))
        order = {o.number: -o.passed for o in self.objects}
        dropped = sorted((p for p in percepts if p.dropped), key=lambda p: (order[p.number], p.number))
        remarks = tuple(_remarks(self, answers, dropped))
        return Perceived(
            self.pipeline.query, self.pipeline, tuple(answers), tuple(dropped), self.scene, tuple(self.runs), remarks
        )

    def _percept(self, thing: _Object) -> Percept:
        query, dropped, sure = self.pipeline.query, thing.dropped, [1.0]
        for condition in query.conditions if not dropped else ():
            said = thing.values.get(condition.output)
            if said is None:
                dropped = f"nobody could say its {condition.output}: " + "; ".join(
                    thing.missing.get(condition.output, ())
                )
            elif not condition.holds(said.judged, self.taxonomy):
                dropped = _not(condition, said, "rather than")
            else:
                sure.append(said.judged.confidence)
        sure += [thing.values[w].judged.confidence for w in query.wanted if w in thing.values]
        if not dropped and min(sure) < query.confidence:
            dropped = f"its confidence is {min(sure):.2f}, less than the {query.confidence:.2f} that is asked for"
        missing = {k: "; ".join(v) for k, v in thing.missing.items() if k not in thing.values}
        return Percept(thing.number, dict(thing.values), min(sure), dropped, missing)


def _as_judged(value: Any) -> Judged:
    return value if isinstance(value, Judged) else Judged(value)


def _replacing(said: Annotation, before: Annotation | None) -> Annotation:
    """Return a new annotation of an object, with the value of the annotation that it replaces as a less likely
    hypothesis."""
    if before is None or before.value == said.value:
        return said
    lost = Judged(before.value, before.judged.confidence, f"{before.expert}: {before.judged.reason}")
    judged = said.judged
    return Annotation(Judged(judged.value, judged.confidence, judged.reason, (*judged.others, lost)), said.expert)


def _words(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, tuple | list):
        return "; ".join(" ".join(map(str, v)) if isinstance(v, tuple) else str(v) for v in value) or "none"
    return str(value)


def _not(condition: Condition, said: Annotation, how: str) -> str:
    """Return why a condition on an object does not hold, with the value that was perceived.

    For a relation such as "on", all relations of the object with that name are listed.
    """
    if condition.output != "relations":
        return f"{condition.output} is {_words(said.value)}, {how} {condition}" + _because(said)
    near = tuple(f for f in said.value if f[0] == condition.key)
    return f"it is {condition.key} {', '.join(f[1] for f in near) or 'nothing that is known'}, not {condition}"


def _because(said: Annotation) -> str:
    return f" ({said.expert}: {said.judged.reason})" if said.judged.reason else ""


def _remarks(running: _Running, answers: Sequence[Percept], dropped: Sequence[Percept]) -> Iterable[str]:
    query = running.pipeline.query
    if not answers:
        yield f"nothing found for '{query}': {_nothing(running, dropped)}"
    unsure = [a for a in answers if a.confidence > answers[0].confidence - NEAR]
    if len(unsure) > 1 and query.conditions:
        numbers = ", ".join(str(a.number) for a in unsure)
        yield f"{len(unsure)} objects fit '{query}' equally well: {numbers}; ask for something that tells them apart"
    for answer in answers:
        for output, why in answer.missing.items():
            if output in query.outputs:
                yield f"object {answer.number} has no {output}: {why}"


def _nothing(running: _Running, dropped: Sequence[Percept]) -> str:
    if not running.objects:
        whys = [w for o in (SEGMENTS, *running.failures) for w in running.failures.get(o, ())]
        return "; ".join(dict.fromkeys(whys)) or "the view shows no object"
    return "; ".join(f"object {p.number}: {p.dropped}" for p in dropped[:6])
