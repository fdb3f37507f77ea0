"""Remedies after a search that found nothing, from the missing quantities that its refusals state."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from ..model.collision import Collision
from ..model.remedy import Remedy
from .diagnosis import nearest_miss, task_of, without_numbers
from .trace import Entry

MOST = 3
"""Number of remedies that are listed."""
REFUSED = ("refused", "impossible")
IN_TWIN = re.compile(r"twin \d+: ")
ROUNDED = 0.0005  # depth of a collision that is told in whole millimetres [m]


def what_to_try(entries: Sequence[Entry], most: int = MOST) -> tuple[str, ...]:
    """Return remedies for a failed search, one for each cause; those for validators' objections to programs come first.

    A remedy states the least amount that is missing; the most frequent cause comes first.

    Only refusals in the task that a candidate failed in count. Where none of them knows a remedy, the most frequent reasons are told.
    """
    refusals = list(_distinct(e for own in _candidates(entries) for e in decisive(own)))
    ran, others = _parted(refusals)
    given = [(e, e.remedy) for e in others if e.remedy is not None]
    seen = [(e, _room(e.collision)) for e in others if e.remedy is None and e.collision is not None]
    found = [*_against(ran), *_told(given), *_told(seen)]
    return tuple(found[:most]) or tuple(_reasons(refusals, most))


def _parted(refusals: Iterable[Entry]) -> tuple[list[Entry], list[Entry]]:
    """Split refusals into those of programs that ran, and all others."""
    found: tuple[list[Entry], list[Entry]] = [], []
    for e in refusals:
        found[e.kind != "proof"].append(e)
    return found


def _against(ran: Sequence[Entry]) -> Iterator[str]:
    """Generate remedies for validators' objections to programs, each with the number of affected programs; the most
    frequent cause first."""
    told = [(e, e.remedy or Remedy(without_numbers(_first_objection(e)), _first_objection(e))) for e in ran]
    often = Counter(_about(e, remedy) for e, remedy in told)
    for (_, count), says in zip(often.most_common(), _told(told), strict=True):
        yield says + (f" ({count} of {len(ran)} programs)" if count > 1 else "")


def _first_objection(proof: Entry) -> str:
    """Return the advice to remove the first objection that validators made to a program.

    Others may follow from it. If the program failed in twins, it is the objection of the first failed twin.
    """
    said = proof.reason.split("; ")
    first = next((part for part in said if IN_TWIN.match(part)), said[0])
    return f"remove the first objection, others may follow from it: {first}"


def decisive(entries: Sequence[Entry]) -> list[Entry]:
    """Return the refusals that decided a candidate's failure: those of its programs, else those in its last
    task."""
    known = {e.number: e for e in entries}
    if ran := [e for e in entries if e.kind == "proof" and e.outcome == "failed"]:
        return ran
    refused = [(task_of(e, known), e) for e in entries if e.outcome in REFUSED]
    last = max((task for task, _ in refused), default=0)
    return [e for task, e in refused if task == last]


def _candidates(entries: Sequence[Entry]) -> Iterator[list[Entry]]:
    for number in dict.fromkeys(e.candidate for e in entries):
        yield [e for e in entries if e.candidate == number]


def _distinct(entries: Iterable[Entry]) -> Iterator[Entry]:
    """Yield each refusal once, although several candidates may repeat it; refusals of programs are all kept."""
    found: dict[tuple[str, str, str, int], Entry] = {}
    for e in entries:
        found.setdefault((e.designator, e.text, e.reason, e.number if e.kind == "proof" else 0), e)
    yield from found.values()


def _told(found: Sequence[tuple[Entry, Remedy]]) -> Iterator[str]:
    """Generate one remedy for each cause of refusals, the one with the smallest missing amount (such as of a
    distance); the most frequent cause first."""
    least: dict[str, tuple[float, str]] = {}
    causes = [(_about(e, remedy), remedy.missing, f"{'' if remedy.about else f'{e.designator}: '}{remedy}") for e, remedy in found]
    for about, missing, says in causes:
        least[about] = min(least.get(about, (math.inf, "")), (missing, says), key=lambda told: told[0])
    for about, _ in Counter(about for about, _, _ in causes).most_common():
        yield least[about][1]


def _about(entry: Entry, remedy: Remedy) -> str:
    return remedy.about or without_numbers(f"{entry.designator.partition('#')[0]}: {remedy.says}")


def _room(collision: Collision) -> Remedy:
    """Return the remedy for two bodies that collide: more room between them."""
    more = f"at least {1000 * collision.depth:.0f} mm more room" if collision.depth >= ROUNDED else "more room"
    return Remedy("", f"{collision}: make {more} between them", collision.depth)


def _reasons(refusals: Sequence[Entry], most: int) -> Iterator[str]:
    """Generate the most frequent reasons of refusals without a remedy; reasons that differ only in numbers
    count as one.

    A single refusal gives none, since it is told as the nearest miss.
    """
    first = _each_once(f"{e.designator}: {e.reason}" for e in refusals)
    counted = Counter(without_numbers(f"{e.designator}: {e.reason}") for e in refusals)
    nearest = nearest_miss(refusals)
    told = without_numbers(f"{nearest.designator}: {nearest.reason}") if nearest is not None else ""
    for cause, count in counted.most_common(most) if len(counted) > 1 else ():
        if cause != told:
            yield first[cause] + (f" ({count} times)" if count > 1 else "")


def _each_once(said: Iterable[str]) -> dict[str, str]:
    """Group texts that differ only in their numbers: the text without numbers -> the first text of its group."""
    found: dict[str, str] = {}
    for text in said:
        found.setdefault(without_numbers(text), text)
    return found
