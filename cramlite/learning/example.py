"""Examples of a task and counterexamples: marked spans of episodes, and actions that known tasks explain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from msgspec import field

from ..base.errors import UserError
from ..base.value import Value, replace
from ..interpretation.coherence import Claims, claims, passive
from ..interpretation.conditions import Binding, atoms
from ..interpretation.interpretation import interpret
from ..interpretation.matching import Match
from ..interpretation.rules import Rule
from ..interpretation.timeline import Timeline
from ..model.episode import Episode
from ..ontology.taxonomy import Taxonomy
from .span import Span

SHORTEST = 0.05
"""Shortest marked interval [s]: two or three samples of a camera."""
INSIDE = 0.8
"""Least share of an action's time within a marked interval at which the action belongs to the interval: people mark a little too early or
too late."""
ENDED = 0.5
"""Least share of an action's time within a marked interval at which an action that ends in the interval belongs to it: an action begins at
the change before it, and people mark its start later."""
BESIDE = 0.2
"""Largest share of an action's time within a marked interval at which the action does not belong to the interval."""


class Marked(Value):
    """Episode in which the interval of the task to be learned is marked.

    Args:
        episode: with the task.
        start, end: of it [s]; None for the ends of the episode.
    """

    episode: Episode
    start: float | None = None
    end: float | None = None


class Known(Value, eq=False):
    """Action of an episode, with the known task that explains it, if any.

    Args:
        span: of the action.
        claim: what the task says that begins and ends; None where no task is the best reading.
        explained: predicates of which the task says that they begin or end, or that do so with these.
        task: class of the task; "" where none explains it.
        roles: of that task, with their fillers.
        named: whether the recording itself names that task.
        strict: whether somebody said that this is not the task.
    """

    span: Span
    claim: Claims | None = None
    explained: frozenset[str] = frozenset()
    task: str = ""
    named: bool = False
    strict: bool = False
    roles: Mapping[str, str] = field(default_factory=dict)


class Example(Value, eq=False):
    """Span of an episode in which the task to be learned was done.

    Args:
        span: that was marked.
        actions: inside it.
        around: actions of the same episode beside it.
        tasks: known tasks that the best reading finds inside, in order, with the fillers of their roles.
        idle: known tasks in which nothing happens whose rules hold of it.
    """

    span: Span
    actions: tuple[Span, ...]
    around: tuple[Known, ...]
    tasks: tuple[tuple[str, dict[str, str]], ...] = ()
    idle: frozenset[str] = frozenset()


def example(marked: Marked, rules: Sequence[Rule], taxonomy: Taxonomy) -> Example:
    """Return the example in a marked episode: its span, the actions inside the span, and those before or
    after it.

    Raises:
        UserError: the interval is empty, or outside of the episode.
    """
    episode = marked.episode
    first, last = episode.span
    start, end = first if marked.start is None else marked.start, last if marked.end is None else marked.end
    if end - start < SHORTEST or start < first - 1e-6 or end > last + 1e-6:
        raise UserError(
            f"There is nothing to learn from {start:.2f} to {end:.2f} s of '{episode.name}': it was recorded from {first:.2f} to "
            f"{last:.2f} s, and an interval has {SHORTEST:.2f} s at least. Mark when the task begins and ends: --interval A:B, in seconds."
        )
    timeline = Timeline(_unnamed(episode), taxonomy)
    read, by_task = list(_read(timeline, rules)), {r.task: r for r in rules}
    inside = [Span(timeline, a, b) for a, b, _ in read if _share(a, b, start, end) >= INSIDE]
    around = tuple(_explained(Span(timeline, a, b), by_task, m) for a, b, m in read if _share(a, b, start, end) <= BESIDE)
    ended = (m for a, b, m in read if _share(a, b, start, end) >= (ENDED if start < b <= end else INSIDE))
    tasks = tuple((m.task, m.roles) for m in ended if m is not None and not passive(by_task[m.task]))
    span = Span(timeline, start, end)
    idle = frozenset(r.task for r in rules if passive(r) and holds(r, span))
    return Example(span, tuple(inside), around, tasks, idle)


def holds(rule: Rule, span: Span) -> bool:
    """Check whether a rule holds in a span of an episode for some assignment of things to its roles."""
    return bool(solutions(rule, span))


def solutions(rule: Rule, span: Span) -> list[Binding]:
    """Return the bindings of variables under which a rule holds in a span."""
    bindings: list[Binding] = [{}]
    for clause in rule.quick_order:
        bindings = [found for b in bindings for found in clause.condition.solve(span.phases[clause.phase], b)]
    return bindings


class Library:
    """Recorded episodes from which counterexamples are taken: the actions that a known task explains.

    The facts of each span are computed once.

    Args:
        episodes: with or without actions that they name.
        taxonomy: of classes.
        strict: whether the task surely was not done in them, so that the whole of each is none, either.
    """

    def __init__(self, episodes: Sequence[Episode], taxonomy: Taxonomy, *, strict: bool = False) -> None:
        self.episodes, self.taxonomy, self.strict = tuple(episodes), taxonomy, strict
        self._timelines = [Timeline(_unnamed(e), taxonomy) for e in episodes]
        self._spans: dict[tuple[int, float, float], Span] = {}

    def known(self, rules: Sequence[Rule]) -> tuple[Known, ...]:
        """Return the actions of the episodes, each with the task that known rules recognise or the recording
        names."""
        return tuple(k for number in range(len(self.episodes)) for k in self._known(number, rules))

    def _known(self, number: int, rules: Sequence[Rule]) -> Iterator[Known]:
        timeline, by_task = self._timelines[number], {r.task: r for r in rules}
        for start, end, match in _read(timeline, rules):
            yield _explained(self._span(number, start, end), by_task, match, self.strict)
        for event in self.episodes[number].of("action"):
            task = self.taxonomy.resolve(event.type) or ""
            if task in by_task:
                named = Match(task, dict(event.roles), "")
                yield _explained(self._span(number, event.start, event.end), by_task, named, self.strict, named=True)
        if self.strict:
            yield Known(self._span(number, *timeline.episode.span), strict=True)

    def _span(self, number: int, start: float, end: float) -> Span:
        key = (number, start, end)
        if key not in self._spans:
            self._spans[key] = Span(self._timelines[number], start, end)
        return self._spans[key]


def _unnamed(episode: Episode) -> Episode:
    return replace(episode, events=tuple(e for e in episode.events if e.kind != "action"))


def _read(timeline: Timeline, rules: Sequence[Rule]) -> Iterator[tuple[float, float, Match | None]]:
    """Yield start, end and task of each action of an episode.

    The task is that of the best reading by known rules; else a task without changes that fits; else None.
    """
    read = interpret(timeline.episode, rules, timeline.taxonomy)
    best = next(read.sequences(), None)
    explained = [k for k, a in enumerate(read.actions) if not a.unexplained]
    chosen = {explained[k]: m for k, m in zip(best.actions, best.matches, strict=True)} if best else {}
    idle = {r.task for r in rules if passive(r)}
    for k, action in enumerate(read.actions):
        yield action.start, action.end, chosen.get(k) or next((m for m in action.matches if m.task in idle), None)


def _explained(span: Span, rules: Mapping[str, Rule], match: Match | None, strict: bool = False, named: bool = False) -> Known:
    """Return an action of an episode with the known task that explains it, and the predicates that this task changes.

    Predicates that change by implication are among them.
    """
    if match is None:
        return Known(span, strict=strict)
    rule = rules[match.task]
    claim = claims(rule, match)
    fluents = {a.predicate.name: a.predicate.fluent for c in rule.clauses for a in atoms(c.condition)}
    names = {f[0] for f in claim.changes}
    names |= {p for n in names if n in fluents for p in (*fluents[n].implies, *fluents[n].undoes)}
    return Known(span, claim, frozenset(names), rule.task, named, strict, match.roles)


def _share(first: float, last: float, start: float, end: float) -> float:
    """Return the share of a span that lies in an interval."""
    return max(min(last, end) - max(first, start), 0.0) / max(last - first, 1e-9)
