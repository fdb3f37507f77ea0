"""Diagnosis of a search without a solution: how the search ended, and the refusal at which it had come furthest."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from .trace import STOPPED, Entry

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?: m?m\b)?")  # a length is told in m or mm, by how long it is

SEVERAL = 3
"""Number of failed attempts with one common cause after which further attempts are expected to fail as well."""


def how_it_ended(entries: Sequence[Entry]) -> str:
    """Describe how a search ended: all alternatives were refused, or a budget was used up.

    The setting that raises the budget is named, except where one cause would most likely refuse the untried alternatives, too.
    """
    capped = _left_out(entries)
    late = any(e.kind == "budget" and "seconds" in e.numbers for e in capped)
    if any(e.kind == "stop" for e in capped) and not late:
        return f"the search was {STOPPED} before every alternative was tried"
    spent = {name: limit for e in capped if e.kind == "budget" for name, limit in e.numbers.items()}
    if spent and (tried := _alike(entries)) and spent.keys() <= {"sequences", "proofs"}:
        return f"all {tried} attempts failed by one cause, so that more of them would hardly help"
    if spent:
        limits = " and ".join(f"{name} = {limit}" for name, limit in spent.items())
        raised = ", ".join(f"{name}: {2 * limit}" for name, limit in spent.items())
        called = ", ".join(f"{name}={2 * limit}" for name, limit in spent.items())
        return (
            f"the search was cut short by its budget {limits}, untried alternatives may succeed; "
            f"raise it with 'budget: {{{raised}}}' in the scenario, or Budget({called}) in Python"
        )
    if capped:
        return "every alternative that was tried was refused; limits left others out, marked '!' in the trace"
    return "every alternative was refused"


def _alike(entries: Sequence[Entry]) -> int:
    """Return the number of failed attempts if at least ``SEVERAL`` failed and all have the same cause, else 0.

    An attempt is a program or, where none was run, a task sequence.
    """
    failed = [e for e in entries if e.kind == "proof" and e.outcome == "failed"]
    own = {e.candidate for e in failed}
    others = (nearest_miss([e for e in entries if e.candidate == n]) for n in {e.candidate for e in entries} - own)
    failed += [e for e in others if e is not None]
    return len(failed) if len({cause(e) for e in failed}) == 1 and len(failed) >= SEVERAL else 0


def cause(entry: Entry) -> tuple[str, str]:
    """Return a key for the cause of a refusal: its designator (empty for a program) and its reason, both without numbers."""
    return without_numbers(entry.designator) if entry.kind != "proof" else "", without_numbers(entry.reason)


def _left_out(entries: Sequence[Entry]) -> list[Entry]:
    """Return the trace entries on what a search left untried: used-up budgets, stops, and alternatives beyond
    the limit.

    Alternatives that were tried later are not among them.
    """
    widened = {e.candidate: e.number for e in entries if e.kind == "sequence" and e.outcome == "asked"}
    capped = [e for e in entries if e.outcome == "capped"]
    return [e for e in capped if e.kind in ("budget", "stop") or e.number > widened.get(e.candidate, 0)]


def nearest_miss(entries: Sequence[Entry]) -> Entry | None:
    """Return the nearest miss: a refused program, else the refusal that came after the most choices."""
    known = {e.number: e for e in entries}
    reasons = [
        e
        for e in entries
        if e.outcome in ("refused", "impossible") or (e.kind == "proof" and e.outcome == "failed")
    ]
    return max(
        reasons,
        key=lambda e: (e.kind == "proof", _depth(known, e), e.outcome == "impossible", e.passed, _says_more(e), -e.number),
        default=None,
    )


def _says_more(entry: Entry) -> bool:
    """Check whether a refusal states a remedy or a collision."""
    return entry.remedy is not None or entry.collision is not None


def _depth(entries: Mapping[int, Entry], entry: Entry) -> int:
    depth = 0
    while entry.parent in entries:
        entry, depth = entries[entry.parent], depth + 1
    return depth


def task_of(entry: Entry | None, known: Mapping[int, Entry]) -> int:
    """Return the number, from 1, of the plan's task that an entry of the trace belongs to; 0 if it belongs to none."""
    while entry is not None and "task" not in entry.numbers:
        entry = known.get(entry.parent)
    return int(entry.numbers["task"]) if entry is not None else 0


def without_numbers(text: str) -> str:
    """Return a reason without its numbers, so that reasons that differ in numbers only count as one cause."""
    return NUMBER.sub("#", text)
