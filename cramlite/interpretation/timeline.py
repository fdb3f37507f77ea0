"""Timeline of an episode for matching: actions, and states before, during and after each.

Closed world: a state that is not known to hold does not hold. The intervals are those
of Alt et al., KR 2023.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Hashable, Iterable
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal

from ..base.value import Value
from ..model.episode import Entity, Episode, Event
from ..ontology.taxonomy import Taxonomy
from .fluents import PLAIN, Fluent
from .state_index import StateIndex

PhaseName = Literal["pre", "run", "post"]
"""Phase of an action: just before it, all through it, or just after it."""
Row = tuple[str | float, ...]
"""Arguments for which a predicate holds: names of entities or classes; a value predicate's rows end with the number."""

PADDING = 0.2
"""Time after a labelled action within which its effects may appear [s]: the published rule base's value."""


class Predicate(Value):
    """Relation that conditions of rules may use; plugins declare it under the hook ``predicates``.

    Two predicates of one name are refused when the rules are loaded (UserError); ``cramlite.testing.check_predicate`` checks a
    declaration.

    Args:
        name: as it is written in rules: a lower-case word, e.g. "is_light".
        arity: number of arguments; of a value predicate, without the value.
        function: ``function(phase, *arguments)`` yields the rows that hold in the phase: tuples of ``arity`` names of entities
            or classes. An argument is None where it is open. Rows that contradict an argument are dropped by the caller. A
            value predicate's rows end with the number, in SI units.
        phases: where it means something, of "pre" (just before the action), "run" (all through it) and "post" (just after
            it); a rule that asks elsewhere is refused when it is loaded.
        timeless: it asks about classes and parts only, so its rows hold at every time.
        steady: it asks only which states hold, by their classes and roles, and which things' poses are known
            (``Timeline.located``), not since when; so its rows are the same wherever the same states hold. Such a
            predicate keeps what it works out in ``phase.situation``.
        possible: whether an episode can make it hold at all; rules that need it are left out where it cannot.
            It may be cautious: True costs time only.
        complete: asked with every argument open, it gives all its rows; it is then asked once, and indexed.
        value: it yields numbers, and is used in comparisons.
        static: ``static(scene, *arguments)`` for planning: whether it holds of entities of a world (``fluents.SymbolicWorld``), or a
            value predicate's number, where classes, parts and what the task holds decide; None where it takes a recording,
            or where tasks change it.
        fluent: for planning: how it behaves where tasks change it, and the goals that ask for it.
        cost: rough cost, 1 for a look at the states; cheaper conditions are checked first.
        unknown: ``unknown(phase, *arguments)`` gives the reason why nobody can tell whether it holds of the arguments, such as
            "no pose of 'cup'"; None where it can be told: then what does not hold is false. Without it, it can always be told.
        classes: places of the arguments that are classes, counted from 0.
        doc: one sentence for people.
    """

    name: str
    arity: int
    function: Callable[..., Iterable[Row]]
    phases: frozenset[PhaseName] = frozenset({"pre", "run", "post"})
    value: bool = False
    timeless: bool = False
    steady: bool = False
    complete: bool = False
    possible: Callable[[Timeline], bool] | None = None
    cost: int = 1
    doc: str = ""
    static: Callable[..., bool | float] | None = None
    fluent: Fluent = PLAIN
    unknown: Callable[..., str | None] | None = None
    classes: tuple[int, ...] = ()


class Segment(Value):
    """Action on the timeline: a recorded one, or a gap without one between two neighbouring times at which states
    or actions begin or end.

    ``event`` is None for the latter.

    Args:
        start, end: [s].
        event: the recorded action.
    """

    start: float
    end: float
    event: Event | None = None


Index = dict[tuple[str | float, ...], tuple[Row, ...]]
"""Index of a predicate's rows: values at some argument positions -> the rows with these values."""


class Phase:
    """Instant (``start == end``) or interval of the timeline in which predicates are evaluated [s].

    Predicates read it; ``memo`` is theirs to keep results in. ``situation`` is another memo, the same one for all
    phases in which the same states hold, all through and at some time, and the same things' poses are known;
    ``holds`` tells such phases apart.
    """

    __slots__ = ("end", "episode", "holds", "memo", "situation", "start", "taxonomy", "timeline")

    def __init__(self, timeline: Timeline, start: float, end: float) -> None:
        self.timeline, self.start, self.end = timeline, start, end
        self.episode, self.taxonomy = timeline.episode, timeline.taxonomy
        self.memo: dict[Hashable, Any] = {}
        self.holds = timeline.holding(start, end)
        self.situation: dict[Hashable, Any] = timeline.situation(self.holds)

    def states(self, type_: str) -> tuple[Event, ...]:
        """Return the recorded states of type ``type_`` that hold throughout this phase, an instant or an interval."""
        active = self.timeline.active(type_, self.start)
        return tuple([e for e in active if e.end >= self.end]) if self.end > self.start else active

    def overlapping(self, type_: str) -> tuple[Event, ...]:
        """Return the recorded states of type ``type_`` that hold at some time of the phase, however short.

        A spanning test cannot see a collision inside an action.
        """
        return self.timeline.active_between(type_, self.start, self.end)

    def rows(self, predicate: Predicate, arguments: tuple[str | float | None, ...]) -> tuple[Row, ...]:
        """Return the facts of a predicate, as rows of values, that match the given arguments in this phase; None
        matches any value."""
        if predicate.complete:
            places = tuple([k for k, a in enumerate(arguments) if a is not None])
            return self.index(predicate, places).get(tuple([a for a in arguments if a is not None]), ())
        known = self.timeline.rows if predicate.timeless else self.situation if predicate.steady else self.memo
        key = (predicate.name, arguments)
        found: tuple[Row, ...] | None = known.get(key)
        if found is None:
            rows = tuple(dict.fromkeys(predicate.function(self, *arguments)))
            found = known[key] = _agreeing(rows, arguments) if rows and arguments else rows
        return found

    def index(self, predicate: Predicate, places: tuple[int, ...]) -> Index:
        """Return all facts of a predicate that can list them (``complete``), as rows of values, indexed by their
        values at some argument positions."""
        known = self.situation if predicate.steady else self.timeline.rows if predicate.timeless else self.memo
        key = (predicate.name, places, "index")
        found: Index | None = known.get(key)
        if found is None:
            rows = dict.fromkeys(predicate.function(self, *[None] * predicate.arity))
            groups: dict[tuple[str | float, ...], list[Row]] = {}
            for row in rows:
                groups.setdefault(tuple([row[k] for k in places]), []).append(row)
            found = known[key] = {values: tuple(group) for values, group in groups.items()}
        return found


class Timeline:
    """Timeline of an episode: its states, indexed by time, and its segmentation into actions.

    A state that still holds when the recording ends is taken to go on: the end of a recording is no event.
    """

    def __init__(self, episode: Episode, taxonomy: Taxonomy) -> None:
        self.episode, self.taxonomy = episode, taxonomy
        self.memo: dict[Hashable, Any] = {}
        self.entities: dict[str, Entity] = {e.name: e for e in episode.entities}
        self.wholes: dict[str, tuple[str, ...]] = {e.name: tuple(_wholes(self.entities, e)) for e in episode.entities}
        self.rows: dict[Hashable, Any] = {}
        self._span = episode.span
        self._indices: dict[str, StateIndex] = {}
        self._instants: dict[float, Phase] = {}
        self._states = StateIndex([e for e in episode.events if e.kind == "state"], self._span[1])
        self._situations: dict[Hashable, dict[Hashable, Any]] = {}

    def types(self, name: str) -> tuple[str, ...]:
        """Return the classes of an entity by their names in this taxonomy; unknown classes keep their own
        names."""
        key = ("types", name)
        if key not in self.memo:
            entity = self.entities.get(name)
            types = entity.types if entity else ()
            self.memo[key] = tuple(self.taxonomy.resolve(t) or t for t in types)
        return self.memo[key]  # type: ignore[no-any-return]

    def entities_of(self, type_: str) -> tuple[str, ...]:
        """Return the names of the entities of a class, in the order of the semantic map."""
        key = ("entities", type_)
        if key not in self.memo:
            self.memo[key] = tuple(n for n in self.entities if self.taxonomy.any_is_a(self.types(n), type_))
        return self.memo[key]  # type: ignore[no-any-return]

    @cached_property
    def located(self) -> dict[str, float]:
        """Time at which the pose of each entity was first known [s]; entities without any known pose are left
        out."""
        tracked = {n: float(t.times[0]) for n, t in self.episode.tracks.items() if len(t.times)}
        return {**tracked, **{n: float("-inf") for n, e in self.entities.items() if e.pose is not None}}

    @cached_property
    def _located(self) -> list[float]:
        return sorted(self.located.values())

    def holding(self, start: float, end: float) -> Hashable:
        """Return a cache key for a span [s], equal for spans with the same states and with equally many things
        whose poses are known by the end."""
        return self._states.holding(start, end), bisect_right(self._located, end)

    def situation(self, holds: Hashable) -> dict[Hashable, Any]:
        """Return the cache of predicate values that all phases with the same states share."""
        return self._situations.setdefault(holds, {})

    def instant(self, time: float) -> Phase:
        """Return the phase (stretch of time) that starts and ends at one time [s], from a cache."""
        phase = self._instants.get(time)
        if phase is None:
            phase = self._instants[time] = Phase(self, time, time)
        return phase

    def phases(self, segment: Segment, padding: float = PADDING) -> dict[PhaseName, Phase]:
        """Return the phases of an action: the instant just before it, its whole duration, and the instant
        just after it.

        Args:
            padding: how long after the end of a labelled action its effects may appear [s]; as ``terminal`` has it.
        """
        return {
            "pre": self.instant(segment.start),
            "run": Phase(self, segment.start, segment.end),
            "post": self.instant(self.terminal(segment, padding)),
        }

    def terminal(self, segment: Segment, padding: float) -> float:
        """Return the instant at which the effects of an action are checked [s].

        The end of an anonymous action is where a state changes, so its effects are exact. A labelled
        action's end is a person's or a detector's judgement; its effects may appear up to ``padding``
        later, but never after the middle of the next labelled action: with the published constant
        0.2 s alone, a Sliding followed by a Retracting of 0.065 s would be judged by the Retracting's end.
        """
        if segment.event is None:
            return segment.end
        starts = self._labelled_starts
        k = bisect_left(starts, segment.end)
        if k < len(starts) and starts[k] < segment.end + padding:
            follower = self.labelled[k]
            return min(segment.end + padding, (follower.start + follower.end) / 2)
        return segment.end + padding

    @cached_property
    def labelled(self) -> tuple[Event, ...]:
        """Recorded actions, sorted by start."""
        return tuple(sorted(self.episode.of("action"), key=lambda e: (e.start, e.end)))

    @property
    def _labelled_starts(self) -> list[float]:
        if "starts" not in self.memo:
            self.memo["starts"] = [e.start for e in self.labelled]
        return self.memo["starts"]  # type: ignore[no-any-return]

    @cached_property
    def cuts(self) -> tuple[float, ...]:
        """Times at which states and recorded actions begin or end, and the ends of the recording; sorted [s]."""
        start, end = self._span
        found = {start, end}
        for event in self.episode.events:
            if event.kind != "situation":
                found.update(t for t in (event.start, event.end) if start < t < end)
        return tuple(sorted(found))

    def segments(self) -> tuple[Segment, ...]:
        """Return the actions: the recorded ones, and each gap without one between two neighbouring times at which
        states or actions begin or end.

        So some action is always going on.
        """
        start = self._span[0]
        found = [Segment(e.start, e.end, e) for e in self.labelled]
        covered = start
        known = iter([*self.labelled, None])
        action = next(known)
        for a, b in pairwise(self.cuts):
            while action is not None and action.start <= a:
                covered = max(covered, action.end)
                action = next(known)
            if a >= covered and b - a > 1e-9:
                found.append(Segment(a, b))
        return tuple(sorted(found, key=lambda s: (s.start, s.end)))

    def active(self, type_: str, time: float) -> tuple[Event, ...]:
        """Return the states of a class with start <= time < end [s]."""
        return self._index(type_).at(time)

    def active_between(self, type_: str, start: float, end: float) -> tuple[Event, ...]:
        """Return the states of a class that hold somewhere in [start, end) [s]."""
        return self._index(type_).between(start, end)

    def boundaries(self, type_: str) -> frozenset[float]:
        """Return the times at which states of a class begin or end [s]."""
        return self._index(type_).boundaries

    def _index(self, type_: str) -> StateIndex:
        index = self._indices.get(type_)
        if index is None:
            resolve, is_a = self.taxonomy.resolve, self.taxonomy.is_a
            kinds = {e.type for e in self.episode.events if e.kind == "state"}
            wanted = {t for t in kinds if is_a(resolve(t) or t, type_)}
            events = [e for e in self.episode.events if e.kind == "state" and e.type in wanted]
            index = self._indices[type_] = StateIndex(events, self._span[1])
        return index


def _agreeing(rows: tuple[Row, ...], arguments: tuple[str | float | None, ...]) -> tuple[Row, ...]:
    """Return those facts of a predicate, as rows of values, that match the given arguments; an argument None
    matches any value."""
    asked = [(k, a) for k, a in enumerate(arguments) if a is not None]
    return tuple([row for row in rows if all([row[k] == a for k, a in asked])])  # noqa: C419 - lists are faster here


def _wholes(entities: dict[str, Entity], entity: Entity) -> Iterable[str]:
    """Return an entity's name and those of the things that it is part of, nearest first.

    A cycle of ``part_of`` is cut.
    """
    seen: list[str] = []
    current: Entity | None = entity
    while current is not None and current.name not in seen:
        seen.append(current.name)
        current = entities.get(current.part_of) if current.part_of else None
    return seen
