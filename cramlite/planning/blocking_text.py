"""Blockings in PDDL: what each of their things has been through, as facts that actions change, and what follows from these."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from ..interpretation.fluents import EFFECTOR, Fluents
from ..model.entity_name import BETWEEN
from .action_schema import ActionSchema
from .blocking import Blocking, Done, changes

ENTITY = "entity"
"""The type of all objects."""

Track = tuple[str, tuple[Done, ...]]
"""A thing, and the tasks that made it what it was when something was refused."""


class BlockingText:
    """Blockings of a domain: how far along each track its thing is, and the tasks that this bars.

    A thing is at one stage of a track, the number of tasks of it that were done; at none once anything else has been done to it.

    Args:
        atom: writes a predicate and its terms.
        object_of: name of an entity in PDDL.
        entities: that the problem has. Tasks with others cannot be done in it.
    """

    def __init__(
        self, blocked: Sequence[Blocking], atom: Callable[[str, Sequence[str]], str], object_of: Callable[[str], str],
        entities: frozenset[str],
    ) -> None:  # fmt: skip
        self.blocked = [b for b in blocked if entities.issuperset(e for _, e in b.task[1])]
        self.tracks: list[Track] = list(dict.fromkeys((t, past) for b in self.blocked for t, past in b.since.items()))
        self.atom, self.object_of, self.entities = atom, object_of, entities

    def initial(self) -> Iterator[str]:
        """Generate the facts that hold at first: nothing has been done to anything."""
        yield from (self._at(track, 0) for track in self.tracks)

    def conditions(self, schema: ActionSchema) -> Iterator[str]:
        """Generate the precondition of an action that blockings are about."""
        if any(b.task[0] == schema.task for b in self.blocked):
            terms = [schema.terms[r] for r in sorted(schema.rule.roles)]
            yield f"(not {self.atom(_name(schema.task), [t for t in terms if t != EFFECTOR])})"

    def derived(self) -> Iterator[str]:
        """Generate the derived predicates: a task is blocked with these things while all of a blocking's things are as they were."""
        for task in dict.fromkeys(b.task[0] for b in self.blocked):
            alternatives = [b for b in self.blocked if b.task[0] == task]
            roles = [r for r, e in alternatives[0].task[1] if e != EFFECTOR]
            name = self.atom(_name(task), [f"?{r}" for r in roles]).strip("()").split()[0]
            head = " ".join([name, *(f"?{r} - {ENTITY}" for r in roles)])
            yield f"(:derived ({head}) (or {' '.join(map(self._stands, alternatives))}))"

    def _stands(self, blocking: Blocking) -> str:
        same = [f"(= ?{r} {self.object_of(e)})" for r, e in blocking.task[1] if e != EFFECTOR]
        return f"(and {' '.join([*same, *(self._at((t, past), len(past)) for t, past in blocking.since.items())])})"

    def effects(self, schema: ActionSchema, fluents: Fluents) -> Iterator[str]:
        """Generate how an action leads things along their tracks, or off them."""
        change = schema.change
        moved = {t: c for t, c in changes(change.needs, change.adds, change.removes, fluents).items() if t.startswith("?")}
        for thing, past in self.tracks:
            for stage in range(len(past) + 1):
                at = self._at((thing, past), stage)
                yield from (f"(when (and {same} {at}) (not {at}))" for same in self._leaving(schema, moved, thing, past))
                if past[stage:] and past[stage][0] == schema.task and (same := self._same(schema, past[stage])):
                    yield f"(when (and {same} {at}) {self._at((thing, past), stage + 1)})"

    def _leaving(self, schema: ActionSchema, moved: Mapping[str, bool], thing: str, past: Sequence[Done]) -> Iterator[str]:
        """The fillers with which an action takes a thing away from a stage."""
        if thing in self.entities:
            yield from (f"(= {t} {self.object_of(thing)})" for t, changed in moved.items() if changed)
        if not all(moved.values()):
            yield from (s for one in dict.fromkeys(past) if one[0] == schema.task and (s := self._same(schema, one)))

    def _same(self, schema: ActionSchema, task: Done) -> str:
        """That an action is a task that was done; "" where it cannot be in this problem."""
        if not self.entities.issuperset(e for _, e in task[1]):
            return ""
        roles = ((schema.terms[r].rpartition(BETWEEN)[2], e) for r, e in task[1] if e != EFFECTOR)
        return " ".join(f"(= {term} {self.object_of(e)})" for term, e in roles)

    def _at(self, track: Track, stage: int) -> str:
        return self.atom(f"track {self.tracks.index(track)} stage {stage}", ())


def _name(task: str) -> str:
    return f"blocked {task}"
