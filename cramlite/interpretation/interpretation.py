"""Interpretation of an episode: the tasks that each of its actions may be, and why an action is not one of the other tasks."""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from itertools import islice, pairwise
from typing import Any

from msgspec import field
from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.pulse import checkpoint
from ..base.value import Value
from ..model.episode import Episode, Event
from ..ontology.foundation import ACTION, TELLS_APART
from ..ontology.taxonomy import Taxonomy
from .coherence import candidates
from .conditions import Binding
from .decision_tree import DecisionTree
from .matching import Match, Rejection, matches_of, reject
from .ranking import DEFAULT_CAP, TaskSequence
from .rules import Rule
from .three_values import possible_matches
from .timeline import PADDING, Segment, Timeline

EPOCH = 1e8
"""Smallest time stamp that counts as seconds since 1970 [s]. 1e8 s is in 1973, and no recording lasts three years."""
LISTED = 3
"""Number of candidate task sequences in the JSON data."""
ELSEWHERE = 0.05
"""Smallest displacement by which a thing counts as moved to another place [m]: ten times a tracker's error, half the width of a hand."""


class Interpreted(Value, dict=True, eq=False):
    """Interpretation of one action.

    Args:
        start, end: [s].
        matches: one for each task and filling of its roles, sorted by task.
        segments: the pieces of the timeline that were merged into it, if more than one.
        evidence: why they were merged; empty if they were not.
        label: the task that the log itself names, if it does.
    """

    start: float
    end: float
    matches: tuple[Match, ...]
    segments: tuple[Segment, ...] = ()
    evidence: str = ""
    label: str | None = None
    _reject: Callable[[], tuple[Rejection, ...]] = tuple
    _moved: Callable[[], tuple[str, ...]] = tuple

    @property
    def unexplained(self) -> bool:
        """Whether no task explains the action."""
        return not self.matches

    @cached_property
    def rejections(self) -> tuple[Rejection, ...]:
        """Rejections: for every task that the action is not, the condition that failed; computed at the first
        access."""
        return self._reject()

    @cached_property
    def moved(self) -> tuple[str, ...]:
        """Things whose position at the action's end is more than ``ELSEWHERE`` from that at its start."""
        return self._moved()

    @cached_property
    def readings(self) -> frozenset[tuple[str, tuple[tuple[str, str], ...]]]:
        """Tasks that the action may be, each with the things in the task's roles."""
        return frozenset([(m.task, tuple(sorted(m.roles.items()))) for m in self.matches])

    def named(self, task: str) -> tuple[Match, ...]:
        """Return the ways in which the action may be a given task, one for each choice of the things in its
        roles."""
        return tuple(m for m in self.matches if m.task == task)


class Interpretation(Value, eq=False):
    """Interpretation of all actions of an episode.

    Args:
        episode: its name.
        actions: in order of time.
        taxonomy: for ranking, and for names in questions.
        rules: that matched: by what they say begins and ends, readings agree with themselves or not.
    """

    episode: str
    actions: tuple[Interpreted, ...]
    taxonomy: Taxonomy
    rules: Sequence[Rule] = ()

    @property
    def unexplained_actions(self) -> tuple[Interpreted, ...]:
        """Actions that no task explains; they are in no sequence, but reported."""
        return tuple(a for a in self.actions if a.unexplained)

    @property
    def zero(self) -> float:
        """Zero of the times that are shown to people [s]: the first action's start if stamps are seconds
        since 1970, else 0."""
        start = self.actions[0].start if self.actions else 0.0
        return start if start > EPOCH else 0.0

    def count(self) -> int:
        """Return the number of combined readings, incoherent ones included: the product of the numbers of
        readings of explained actions.

        0 if none is explained.
        """
        total = 1 if len(self.unexplained_actions) < len(self.actions) else 0
        for action in self.actions:
            total *= len(action.matches) or 1
        return total

    def sequences(self, cap: int = DEFAULT_CAP) -> Iterator[TaskSequence]:
        """Yield the coherent task sequences, the shortest description first (``coherence``, ``ranking``).

        Args:
            cap: how many unfinished sequences are kept in memory; beyond it the worst are forgotten.
        """
        return candidates([a for a in self.actions if not a.unexplained], self.rules, self.taxonomy, cap)

    def why(self, task: str, action: int) -> str:
        """Explain in words why an action is, or is not, a task.

        Args:
            task: CURIE, IRI or a name that users know.
            action: its number, from 0.

        Raises:
            UserError: no such task or action.
        """
        if not 0 <= action < len(self.actions):
            raise UserError(f"There is no action {action}; '{self.episode}' has actions 0 to {len(self.actions) - 1}.")
        one = self.actions[action]
        name = self.taxonomy.resolve(task)
        when = f"Action {action} ({one.start:.2f} to {one.end:.2f} s)"
        found = one.named(name or "")
        if found:
            return "\n".join(f"{when} is {m.task}: {m.explanation}; all {m.conditions} conditions hold." for m in found)
        refused = {r.task: r for r in one.rejections}
        if name not in refused:
            raise UserError(
                f"No rule speaks about the task '{task}'; {nearest(task, {m.task for m in one.matches} | set(refused))}"
            )
        return f"{when} is {refused[name].sentence}\n  rule: {refused[name].where}"

    def to_json(self) -> dict[str, Any]:
        """Return the JSON data of ``cramlite interpret --json``: actions, the number of readings, and the
        best candidates."""
        best = [_sequence_json(s, self.actions) for s in islice(self.sequences(), LISTED)]
        return {"actions": [_action_json(a) for a in self.actions], "sequences": self.count(), "candidates": best}


def _sequence_json(sequence: TaskSequence, actions: Sequence[Interpreted]) -> dict[str, Any]:
    explained = [k for k, a in enumerate(actions) if not a.unexplained]
    tasks = [
        {"action": explained[k], "task": m.task, "roles": m.roles, "not_known": list(m.unknown)}
        for k, m in zip(sequence.actions, sequence.matches, strict=True)
    ]
    return {"bits": -sequence.score, "terms": sequence.reason, "tasks": tasks}


def _action_json(action: Interpreted) -> dict[str, Any]:
    data: dict[str, Any] = {
        "start": action.start,
        "end": action.end,
        "named": action.label,
        "tasks": [
            {"task": m.task, "roles": m.roles, "explanation": m.explanation, "not_known": list(m.unknown)} for m in action.matches
        ],
        "rejections": [
            {
                "task": r.task,
                "phase": r.phase,
                "condition": r.condition,
                "binding": r.binding,
                "candidates": list(r.candidates),
                "facts": list(r.facts),
                "sentence": r.sentence,
            }
            for r in action.rejections
        ],
    }
    if action.evidence:
        data["merged"] = {"segments": [[s.start, s.end] for s in action.segments], "evidence": action.evidence}
    return data


def interpret(
    episode: Episode, rules: Sequence[Rule], taxonomy: Taxonomy, *, padding: float = PADDING, merge: bool = True
) -> Interpretation:
    """Recognise every task that each action of an episode may be.

    Args:
        episode: events and poses.
        rules: from ``load_rules``.
        taxonomy: classes of tasks and things.
        padding: see ``phases.PADDING`` [s].
        merge: join neighbouring anonymous actions that only refine each other.

    Returns:
        The interpretation; an episode without events has no actions.
    """
    with paused_collector():
        timeline = Timeline(episode, taxonomy)
        matcher = _Matcher(timeline, {r.task: r for r in rules}, DecisionTree(rules, timeline), padding)
        actions = matcher.match_all(matcher.timeline.segments())
        return Interpretation(episode.name, tuple(matcher.merged(actions) if merge else actions), taxonomy, rules)


class _Matcher(Value):
    """Matcher of an episode's actions: timeline, rules, decision tree, and caches of results."""

    timeline: Timeline
    rules: Mapping[str, Rule]
    tree: DecisionTree
    padding: float
    known: dict[Hashable, tuple[Match, ...]] = field(default_factory=dict)
    wholes: dict[tuple[float, float], Mapping[str, list[Binding]]] = field(default_factory=dict)

    def match_all(self, segments: Sequence[Segment]) -> list[Interpreted]:
        solved = self.tree.solve_all([self.timeline.phases(s, self.padding) for s in segments])
        return [self.matched(segment, (segment,), found) for segment, found in zip(segments, solved, strict=True)]

    def matched(
        self, segment: Segment, segments: tuple[Segment, ...], solved: Mapping[str, list[Binding]]
    ) -> Interpreted:
        matches = tuple([m for task in sorted(solved) for m in self.matches(task, solved[task])])
        label = segment.event.type if segment.event is not None else None
        label = self.timeline.taxonomy.resolve(label) if label else None
        if label and label != ACTION:
            matches += tuple(self.named(segment, label, {m.task for m in matches}))
        elif self.effector_unseen and not any(m.roles for m in matches):
            matches += tuple(self.unseen(segment))
        return Interpreted(
            segment.start,
            segment.end,
            matches,
            segments,
            "",
            None if label == ACTION else label,
            lambda: self.reject(segment, {m.task for m in matches}),
            lambda: self.moved(segment),
        )

    def named(self, segment: Segment, label: str, known: set[str]) -> Iterator[Match]:
        """Yield readings of an action as the task that the recording names, though some of their conditions
        cannot be judged.

        None of their conditions is false.
        """
        for task, rule in self.rules.items():
            if task not in known and segment.event is not None and self.timeline.taxonomy.is_a(task, label):
                yield from possible_matches(rule, self.timeline.phases(segment, self.padding), _fillers(rule, segment.event))

    @property
    def effector_unseen(self) -> bool:
        """Check whether things have recorded poses while the acting effector has none."""
        episode = self.timeline.episode
        return bool(episode.tracks) and episode.effector is not None and episode.effector not in episode.tracks

    def unseen(self, segment: Segment) -> Iterator[Match]:
        """Yield matches of an action with rules, each with one condition that cannot be judged, as the
        effector was not tracked.

        All other conditions hold.
        """
        for rule in self.rules.values():
            found = possible_matches(rule, self.timeline.phases(segment, self.padding), [{}])
            yield from (m for m in found if m.roles and len(m.unknown) == 1)

    def moved(self, segment: Segment) -> tuple[str, ...]:
        """Return the tracked things other than the hand that moved by more than ``ELSEWHERE`` between start
        and end of an action."""
        hand = self.timeline.episode.effector
        whole = (n for n, e in self.timeline.entities.items() if e.part_of is None and n in self.timeline.episode.tracks and n != hand)
        tracks = {n: self.timeline.episode.tracks[n] for n in whole}
        ends = {n: (t.at(segment.start), t.at(segment.end)) for n, t in tracks.items() if len(t.times)}
        return tuple(n for n, (a, b) in ends.items() if math.dist(a.position, b.position) > ELSEWHERE)

    def matches(self, task: str, bindings: list[Binding]) -> tuple[Match, ...]:
        """Return one match of a task's rule for each distinct filling of its roles; matches of equal bindings are computed once."""
        key = (task, *[tuple(b.values()) for b in bindings])
        if key not in self.known:
            self.known[key] = matches_of(self.rules[task], bindings)
        return self.known[key]

    def reject(self, segment: Segment, matched: set[str]) -> tuple[Rejection, ...]:
        phases = self.timeline.phases(segment, self.padding)
        refused = (reject(rule, phases) for task, rule in self.rules.items() if task not in matched)
        return tuple(r for r in refused if r is not None)

    def _telling(self, time: float) -> bool:
        """Check whether a state of a class that always separates two actions begins or ends at a time [s]."""
        boundaries = self.timeline.boundaries
        return any(time in boundaries(type_) for type_ in self.timeline.taxonomy.restricted_classes(TELLS_APART))

    def merged(self, actions: list[Interpreted]) -> list[Interpreted]:
        """Merge neighbouring actions if the merged action is recognised as all the tasks that each of them was recognised as.

        Explained actions are merged first, then unexplained ones with the action after them, then the
        rest.
        """
        spans = [Segment(a.start, b.end) for a, b in pairwise(actions) if self._refine(a, b)]
        solved = self.tree.solve_all([self.timeline.phases(s, self.padding) for s in spans])
        self.wholes.update(zip([(s.start, s.end) for s in spans], solved, strict=True))
        found = self._folded(actions, lambda before, after: not before.unexplained and not after.unexplained)
        found = self._folded(found[::-1], lambda before, _after: before.unexplained, backwards=True)[::-1]
        return self._folded(found, lambda _before, _after: True)

    def _folded(
        self, actions: list[Interpreted], wanted: Callable[[Interpreted, Interpreted], bool], backwards: bool = False
    ) -> list[Interpreted]:
        found: list[Interpreted] = []
        for action in actions:
            pair = None if not found else (action, found[-1]) if backwards else (found[-1], action)
            joined = self.join(*pair) if pair is not None and wanted(*pair) else None
            if joined is None:
                found.append(action)
            else:
                found[-1] = joined
        return found

    def join(self, before: Interpreted, after: Interpreted) -> Interpreted | None:
        """Join two neighbouring actions to one, if it may be every task that either of them may be; else return None.

        Only anonymous neighbours are joined, and only if one's tasks are among the other's: the boundary
        between them then told nothing apart. The joined action is judged anew against every rule, and
        two unexplained ones stay so unless together they are something.
        """
        if not self._refine(before, after):
            return None
        segments = (*before.segments, *after.segments)
        joined = self._whole(Segment(before.start, after.end), segments)
        if joined.unexplained or not before.readings | after.readings <= joined.readings:
            return None
        boundaries = ", ".join(f"{s.start:.2f} s" for s in segments[1:])
        evidence = (
            f"{len(segments)} segments with boundaries at {boundaries} were joined: the whole is judged to be "
            f"{', '.join(sorted({m.task for m in joined.matches}))}, which includes all tasks of each segment"
        )
        return replace(joined, evidence=evidence)

    def _refine(self, before: Interpreted, after: Interpreted) -> bool:
        """Check whether two neighbouring actions may be joined, because each task of one is also a task of the other.

        Both must be without label, and no state that separates actions may begin or end between them.
        """
        if before.end != after.start or self._telling(after.start):
            return False
        if any(s.event is not None for s in (*before.segments, *after.segments)):
            return False
        a, b = before.readings, after.readings
        return a <= b or b <= a

    def _whole(self, segment: Segment, segments: tuple[Segment, ...]) -> Interpreted:
        """Return the action that joined segments form, matched with all rules as a single action; results are
        cached."""
        key = (segment.start, segment.end)
        if key not in self.wholes:
            checkpoint()
            self.wholes[key] = self.tree.solve(self.timeline.phases(segment, self.padding))
        return self.matched(segment, segments, self.wholes[key])


def _fillers(rule: Rule, event: Event) -> Iterator[Binding]:
    """Yield possible fillers of a rule's roles for an action with a label: first the things that the label names, then
    no fillers.

    A label without role names gives its object to the first role.
    """
    said: Binding = {role: event.roles[role] for role in rule.roles if role in event.roles}
    if not said and rule.roles and "object" in event.roles:
        said = {next(iter(rule.roles)): event.roles["object"]}
    if said:
        yield said
    yield {}


@contextmanager
def paused_collector() -> Iterator[None]:
    """Pause Python's garbage collector in a ``with`` block.

    Each of its searches for cycles looks at all objects that there are, so that making many takes longer than in
    proportion: a third of the time for 10,000 actions. Mercurial does the same (``util.nogc``).
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
