"""Blockings (refused tasks) in PDDL: facts on the tasks done to each thing so far, and the tasks that these
block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ...interpretation.fluents import EFFECTOR, Fluents
from ...model.entity_name import BETWEEN
from .action_schema import ActionSchema
from .blocking import AnyOf, Blocking
from .handling import Done, Handling, Stage, Track, handled

ENTITY = "entity"
"""Type of all objects in PDDL."""


class BlockingText:
    """Blockings (tasks refused while certain things stay as they are) of a PDDL domain, written as derived
    predicates.

    A track lists the tasks done to a thing. The thing is at one stage of the track, or at none once other
    tasks were done to it.

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
        self.tracks = list(dict.fromkeys(t for b in self.blocked for t in b.tracks))
        self.atom, self.object_of, self.entities = atom, object_of, entities

    @property
    def named(self) -> set[str]:
        """Entities that blockings name: in the refused tasks, as things in the way, or in the tasks that were done to these before."""
        tasks = [*(b.task for b in self.blocked), *(one for t in self.tracks for one in t.past)]
        return {t.thing for t in self.tracks} | {e for task in tasks for _, e in task[1]}

    def initial(self) -> Iterator[str]:
        """Generate the PDDL facts at the start: each thing is at the beginning of each of its task histories, with no task done."""
        yield from (self._at(track, (0, "")) for track in self.tracks)

    def conditions(self, schema: ActionSchema) -> Iterator[str]:
        """Generate the precondition that a task with blockings is not blocked."""
        if any(b.task[0] == schema.doing for b in self.blocked):
            terms = [schema.terms[r] for r in sorted(schema.rule.roles)]
            yield f"(not {self.atom(_name(schema.doing), [t for t in terms if t != EFFECTOR])})"

    def derived(self) -> Iterator[str]:
        """Generate the derived predicates of PDDL: a thing is unchanged; any of several things is
        unchanged; a task with certain things is blocked.

        Each "or" has a predicate of its own: planners write conditions out as alternatives of "and", of which there would be many.
        """
        for track in self.tracks:
            yield f"(:derived {self._same(track)} (or {' '.join(self._at(track, s) for s in track.at_its_end())}))"
        for any_of in dict.fromkeys(s for b in self.blocked for s in b.sets if len(s) > 1):
            each = (f"(and {' '.join(map(self._same, tracks))})" for tracks in any_of)
            yield f"(:derived {self._any(any_of)} (or {' '.join(each)}))"
        for task in dict.fromkeys(b.task[0] for b in self.blocked):
            alternatives = [b for b in self.blocked if b.task[0] == task]
            roles = [r for r, e in alternatives[0].task[1] if e != EFFECTOR]
            name = self.atom(_name(task), [f"?{r}" for r in roles]).strip("()").split()[0]
            head = " ".join([name, *(f"?{r} - {ENTITY}" for r in roles)])
            yield f"(:derived ({head}) (or {' '.join(map(self._stands, alternatives))}))"

    def _stands(self, blocking: Blocking) -> str:
        fillers = [f"(= ?{r} {self.object_of(e)})" for r, e in blocking.task[1] if e != EFFECTOR]
        alone = (self._same(t) for s in blocking.sets for t in s[0] if len(s) == 1)
        several = (self._any(s) for s in blocking.sets if len(s) > 1)
        return f"(and {' '.join([*fillers, *alone, *several])})"

    def _same(self, track: Track) -> str:
        return self.atom(f"track {self.tracks.index(track)} is done", ())

    def _any(self, any_of: AnyOf) -> str:
        names = [str(self.tracks.index(t)) for tracks in any_of for t in tracks]
        return self.atom(f"one of tracks {' '.join(names)} is done", ())

    def effects(self, schema: ActionSchema, fluents: Fluents) -> Iterator[str]:
        """Generate the PDDL effects of an action on the task histories of things (the lists of tasks done to each thing).

        Each thing that the action handles advances on its track, or leaves it.
        """
        change = schema.change
        for term, how in handled(change.needs, change.adds, change.removes, fluents, change.moves).items():
            for track in self.tracks if term.startswith("?") else ():
                if track.thing in self.entities:
                    yield from (e for stage in (*track.stages(), None) for e in self._step(schema, term, how, track, stage))

    def _step(self, schema: ActionSchema, term: str, how: Handling, track: Track, stage: Stage | None) -> Iterator[str]:
        """Generate the PDDL effects of an action on how far a thing has come along a task history, from one stage
        of it (None: from outside the history).

        The thing goes on to the next stage, or leaves the track.

        The fillers of the track's own tasks lead along it, all other fillers off it.
        """
        here, otherwise = f"(= {term.rpartition(BETWEEN)[2]} {self.object_of(track.thing)})", track.after(stage, how, None)
        own = {self._fillers(schema, t): track.after(stage, how, t) for t in track.past if t[0] == schema.doing}
        own = {same: after for same, after in own.items() if same and after != otherwise}
        rest = {} if here in own else {" ".join([here, *(f"(not (and {same}))" for same in own)]): otherwise}
        cases = {**own, **rest}
        before = f" {self._at(track, stage)}" if stage is not None else ""
        for case, after in cases.items():
            if after != stage:
                ends = [f"(not{before})"] if before else []
                begins = [self._at(track, after)] if after is not None else []
                yield f"(when (and {case}{before}) (and {' '.join([*ends, *begins])}))"

    def _fillers(self, schema: ActionSchema, task: Done) -> str:
        """Return the PDDL condition that an action fills its roles with the same things as a given task that
        was done before.

        It is "" if the problem lacks one of them.
        """
        if not self.entities.issuperset(e for _, e in task[1]):
            return ""
        roles = ((schema.terms[r].rpartition(BETWEEN)[2], e) for r, e in task[1] if e != EFFECTOR)
        return " ".join(f"(= {term} {self.object_of(e)})" for term, e in roles)

    def _at(self, track: Track, stage: Stage) -> str:
        return self.atom(f"track {self.tracks.index(track)} stage {stage[0]} {stage[1]}", ())


def _name(task: str) -> str:
    return f"blocked {task}"
