"""Trace of a search: the answers of plugins, and the reasons of refusals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct, ValidationError, convert, field, to_builtins
from msgspec.structs import replace

from ..base.errors import UserError
from ..base.run_directory import read_json
from ..base.stopwatch import Stopwatch
from ..base.value import Value
from ..model.collision import Collision
from ..model.remedy import Remedy
from .refutation import Refutation

Outcome = Literal["asked", "chosen", "refused", "impossible", "failed", "nogood", "capped", "fault", "proven", "survived"]
Kind = Literal["sequence", "goal", "action", "compound", "object", "location", "motion", "twin", "proof", "budget", "stop"]
STOPPED = "stopped by the caller"
KNOWN = "answered before"
SENTENCE = "sentence"
"""Designator of the trace entries that say how a sentence was understood."""


class Entry(Value):
    """Entry of the trace: a question, choice or refusal, with its plugin and reason.

    Args:
        number: position in the trace.
        parent: number of the choice that this hangs under; 0 for the root.
        candidate: which task sequence this belongs to, from 1.
        kind: what it is about: a "sequence" of tasks as a whole, a step towards a "goal", a designator ("action",
            "compound", "object", "location", "motion"), a run of a program in a "twin", the "proof" of a program, a
            "budget" that is used up, or a "stop" by the caller.
        designator: its name; where there is none, a word for people.
        text: what is asked for, or the alternative, in words.
        outcome: "asked" (a designator is up; a sequence, tried again in a wider round), "chosen" (an alternative is tried),
            "refused" (a plugin considered and dropped it), "impossible" (a plugin says so for the whole designator), "failed"
            (tried, and what followed failed), "nogood" (skipped: the same combination failed before), "capped", "fault" (a plugin's bug),
            "proven" (its text ran and was judged), "survived" (it succeeded in a twin).
        plugin: who said it.
        reason: a clause with numbers and units.
        cost: of an alternative.
        passed: checks that a refused alternative passed before.
        numbers: what readers count with, by name, with units in the names. Of what is asked within a task: "task", which
            one of the plan it is, from 1, and "depth", how many actions are open around it (compounds not counted). Of an object
            that is asked for before all tasks: "first_task" and "last_task", those that need it. Of a
            "sequence" that is tried again: "breadth", how many times as many alternatives as at first. Of a
            designator that failed or was capped: "tried", alternatives. Of a budget: its name in ``Budget``, and what it
            was. Of a failed proof: what was measured, and the limits. Of what plugins refuse: what they say, e.g.
            {"reach_m": 0.91, "limit_m": 0.85}.
        refutation: of a "sequence" that failed: what that depends on.
        collision: of what was refused since two bodies would be too near one another: that state.
        remedy: of what was refused, also of a failed proof: what is missing and what to try.
    """

    number: int
    parent: int
    candidate: int
    kind: Kind
    designator: str
    text: str
    outcome: Outcome
    plugin: str
    reason: str
    cost: float | None = None
    passed: int = 0
    numbers: Mapping[str, int | float] = field(default_factory=dict)
    refutation: Refutation | None = None
    collision: Collision | None = None
    remedy: Remedy | None = None


class Trace(Struct):
    """Trace of a search: an append-only list of entries, filled while it runs.

    Args:
        entries: in the order in which things were decided.
        candidate: which task sequence is being tried, from 1.
        watch: CPU time so far; see ``seconds``.
        first_program: CPU time of planning until the first complete program was handed to the proof [s]; None before that.
    """

    entries: list[Entry] = field(default_factory=list)
    candidate: int = 1
    watch: Stopwatch = field(default_factory=Stopwatch)
    first_program: float | None = None

    @property
    def seconds(self) -> dict[str, float]:
        """CPU time of the search so far by stage [s]: "planning", "proof" and "twins".

        Planning is task sequences and plugins' answers, proof is nominal runs of complete programs and their
        validators. No written file has these times, since runs would differ.
        """
        return {"planning": 0.0, "proof": 0.0, "twins": 0.0, **self.watch.read()}

    def add(
        self, parent: int, designator: str, text: str, outcome: Outcome, plugin: str, reason: str,
        cost: float | None = None, passed: int = 0, *, kind: Kind, numbers: Mapping[str, float] | None = None,
        collision: Collision | None = None, remedy: Remedy | None = None,
    ) -> int:  # fmt: skip
        """Append an entry to the trace, and return its number; infinite figures and NaN are left out, as JSON has
        none."""
        number = len(self.entries) + 1
        finite = {k: v for k, v in (numbers or {}).items() if math.isfinite(v)}
        self.entries.append(
            Entry(
                number, parent, self.candidate, kind, designator, text, outcome, plugin, reason, cost, passed, finite,
                collision=collision, remedy=remedy,
            )
        )  # fmt: skip
        return number

    def answered_before(self, number: int) -> None:
        """Note in the trace that the answers to a question were known already, so that no plugin was asked."""
        self.entries[number - 1] = replace(self.entries[number - 1], reason=KNOWN)

    def spent(self, budget: str, limit: int, reason: str) -> None:
        """Record in the trace that a budget was used up.

        Args:
            budget: its name in ``Budget``.
            limit: what it was [work of that budget].
        """
        text = f"{budget} = {limit}"
        self.add(0, "budget", text, "capped", "engine", reason, kind="budget", numbers={budget: limit})

    def widened(self, plan: str, breadth: int) -> None:
        """Append to the trace that the present task sequence is tried again, with more alternatives of
        each designator.

        Args:
            breadth: how many times as many alternatives of each designator are tried as in the first round.
        """
        said = f"tried again with {breadth} times as many alternatives of each choice as in the first round"
        self.add(0, "sequence", plan, "asked", "engine", said, kind="sequence", numbers={"breadth": breadth})

    def stopped(self, work: str = "") -> None:
        """Record in the trace that the caller stopped the search, and the work that this interrupted, such as
        "program 2 runs"."""
        self.add(0, "budget", work, "capped", "engine", STOPPED, kind="stop")

    def refuted(self, plan: str, found: Refutation) -> None:
        """Record in the trace that all groundings of the present task sequence failed, and on what tasks and
        things that depends."""
        sets = [" or ".join(f"'{t}'" for t in any_of) for any_of in found.things or ()]
        things = "things that no plugin named" if found.things is None else ", ".join(sets) or "no other thing"
        unfit = ", ".join(f"'{name}'" for name in found.unfit)
        said = f"the failure depends on tasks {', '.join(map(str, found.tasks)) or 'none'}, and on {things}"
        said = f"no task can be done with {unfit}" if unfit else said
        number = self.add(0, "sequence", plan, "failed", "engine", said, kind="sequence")
        self.entries[number - 1] = replace(self.entries[number - 1], refutation=found)

    @property
    def refutation(self) -> Refutation | None:
        """Reason why all groundings of the present or last task sequence failed; None if some were not tried."""
        own = (e.refutation for e in reversed(self.entries) if e.candidate == self.candidate)
        return next((r for r in own if r is not None), None)

    def about(self, designator: str) -> Iterator[Entry]:
        """Return the trace entries about designators whose name contains a text; upper and lower case are the same."""
        return (e for e in self.entries if designator.lower() in e.designator.lower())

    def to_json(self) -> list[dict[str, Any]]:
        """Return the entries of the trace as JSON values."""
        return [to_builtins(e) for e in self.entries]

    @classmethod
    def from_json(cls, rows: list[dict[str, Any]]) -> Trace:
        """Read the trace that ``to_json`` wrote.

        Raises:
            msgspec.ValidationError: an entry has no kind, or another field that is missing or wrong.
        """
        return cls(convert(rows, list[Entry]))


def understood_entries(entries: list[Entry]) -> tuple[Entry, ...]:
    """Return the trace entries that say how a sentence of the user was understood, without repetitions."""
    return tuple({e.text: e for e in entries if e.designator == SENTENCE}.values())


def read_trace(path: Path) -> Trace:
    """Read ``trace.json`` of a run directory.

    Raises:
        UserError: it is missing, broken, no trace, or of a version whose entries had no kind.
    """
    data = read_json(path, "trace")
    try:
        return Trace.from_json(data["entries"])
    except (KeyError, TypeError) as error:
        raise UserError(f"'{path}' is no trace of a run; give a directory that 'cramlite resolve --out' wrote.") from error
    except ValidationError as error:
        raise UserError(
            f"'{path}' is no trace that this version of cramlite reads: {error}. "
            "An older one may have written it; run 'cramlite resolve' again with another --out."
        ) from error
