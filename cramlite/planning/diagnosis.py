"""Diagnosis of a search without a solution: how it ended, and the nearest miss."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from .trace import STOPPED, Entry, Trace


def failure_text(trace: Trace, faults: Iterable[object]) -> str:
    """Return why nothing was found: the nearest miss of all, and the one of each candidate."""
    lines = [f"No solution: {how_it_ended(trace.entries)}."]
    lines += [f"  Fault: {f}" for f in dict.fromkeys(str(f) for f in faults)]
    nearest = nearest_miss(trace.entries)
    if nearest is not None:
        lines.append(f"  Nearest miss: {_miss(nearest)}")
    for number in dict.fromkeys(e.candidate for e in trace.entries):
        miss = nearest_miss([e for e in trace.entries if e.candidate == number])
        if miss is not None and miss is not nearest:
            lines.append(f"  Also {_miss(miss)}")
    return "\n".join(lines)


def how_it_ended(entries: Sequence[Entry]) -> str:
    """Return whether all alternatives were refused, or what ended the search before, and how to raise it."""
    capped = _left_out(entries)
    late = any(e.kind == "budget" and "seconds" in e.numbers for e in capped)
    if any(e.kind == "stop" for e in capped) and not late:
        return f"the search was {STOPPED} before every alternative was tried"
    spent = {name: limit for e in capped if e.kind == "budget" for name, limit in e.numbers.items()}
    if spent:
        limits = " and ".join(f"{name} = {limit}" for name, limit in spent.items())
        raised = ", ".join(f"{name}: {2 * limit}" for name, limit in spent.items())
        called = ", ".join(f"{name}={2 * limit}" for name, limit in spent.items())
        return (
            f"the search was cut short by its budget {limits}, other alternatives may do; "
            f"raise it with 'budget: {{{raised}}}' in the scenario, or Budget({called}) in Python"
        )
    if capped:
        return "every alternative that was tried was refused; limits left others out, marked '!' in the trace"
    return "every alternative was refused"


def _left_out(entries: Sequence[Entry]) -> list[Entry]:
    """What ended the search, or left alternatives out of it that no wider round of the same task sequence took up again."""
    widened = {e.candidate: e.number for e in entries if e.kind == "sequence" and e.outcome == "asked"}
    capped = [e for e in entries if e.outcome == "capped"]
    return [e for e in capped if e.kind in ("budget", "stop") or e.number > widened.get(e.candidate, 0)]


def _miss(entry: Entry) -> str:
    return f"candidate {entry.candidate}, {entry.designator}: {entry.reason} [{entry.plugin}]"


def nearest_miss(entries: Sequence[Entry]) -> Entry | None:
    """Return the refusal that came after the most choices; a program whose text ran comes nearer than any."""
    known = {e.number: e for e in entries}
    reasons = [
        e
        for e in entries
        if e.outcome in ("refused", "impossible") or (e.kind == "proof" and e.outcome == "failed")
    ]
    return max(
        reasons,
        key=lambda e: (e.kind == "proof", _depth(known, e), e.outcome == "impossible", e.passed, -e.number),
        default=None,
    )


def _depth(entries: Mapping[int, Entry], entry: Entry) -> int:
    depth = 0
    while entry.parent in entries:
        entry, depth = entries[entry.parent], depth + 1
    return depth
