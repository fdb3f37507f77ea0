"""Search traces as text for people: choices of the program, alternatives that were given up, and reasons."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from ..base.value import Value
from ..planning.diagnosis import nearest_miss
from ..planning.trace import Entry, Trace

MARKS = {
    "asked": "?", "chosen": "+", "refused": "-", "impossible": "x", "failed": "x", "nogood": "-", "capped": "!", "fault": "!!",
    "proven": "OK", "survived": "ok",
}  # fmt: skip
GIVEN_UP = "~"


def trace_text(trace: Trace, designator: str | None = None) -> str:
    """Return the tree of a search, or everything about one designator, each repeated answer once, as text.

    What follows a choice stands below it, one step further in if the choice was given up for another one; so a line at the
    margin is on the way to the program, however long that way is.
    """
    tree = _Tree.of(trace.entries)
    if designator:
        told = Counter("\n".join(tree.lines(e)) for e in trace.about(designator))
        return "\n".join(text + (f" ({count} times)" if count > 1 else "") for text, count in told.items())
    return "\n".join("  " * tree.indent(e) + line for e in trace.entries for line in tree.lines(e))


class _Tree(Value):
    """Entries of a trace as a tree.

    Args:
        entries: all of them, by number from 1.
        ends: of each choice: number of the first entry that no longer depends on it.
        kept: choices that are in a proven program.
        rivals: of each choice, how many were chosen for the same question.
        depths: of entries, filled as they are asked for.
    """

    entries: Sequence[Entry]
    ends: Mapping[int, int]
    kept: frozenset[int]
    rivals: Mapping[int, int]
    depths: dict[int, int]

    @classmethod
    def of(cls, entries: Sequence[Entry]) -> _Tree:
        ends = _ends(entries)
        proofs = [e.number for e in entries if e.outcome == "proven"]
        kept = frozenset(n for n, end in ends.items() if bisect_right(proofs, end - 1) > bisect_right(proofs, n))
        counts = Counter(e.parent for e in entries if e.outcome == "chosen")
        return cls(entries, ends, kept, {n: counts[entries[n - 1].parent] for n in ends}, {})

    def given_up(self, entry: Entry) -> bool:
        """Check whether the search gave up the choice that a trace entry records.

        While no program is proven only choices with rivals count: every choice of the way was then left in vain.
        """
        ended = self.ends.get(entry.number, 0)
        back = 0 < ended <= len(self.entries) and entry.number not in self.kept
        return back and (bool(self.kept) or self.rivals[entry.number] > 1)

    def indent(self, entry: Entry) -> int:
        """Return the indentation of a trace entry: its depth, and 1 more unless it opens the grounding of
        a designator."""
        return self.depth(entry) + (entry.outcome != "asked" and entry.parent > 0)

    def depth(self, entry: Entry) -> int:
        """Return the indentation depth of a trace entry in the printed tree: 2 more below each choice that was given up
        for an alternative.

        Without recursion, since a search may be a thousand questions long.
        """
        chain = []
        while entry.number not in self.depths and entry.parent:
            chain.append(entry)
            entry = self.entries[entry.parent - 1]
        self.depths.setdefault(entry.number, 0)
        for below in reversed(chain):
            above = self.entries[below.parent - 1]
            branched = self.given_up(above) and self.rivals[above.number] > 1
            self.depths[below.number] = self.depths[above.number] + 2 * branched
        return self.depths[chain[0].number] if chain else self.depths[entry.number]

    def lines(self, entry: Entry) -> Iterator[str]:
        """Format an entry of a search trace: outcome mark, designator, alternative, reason, cost and plugin;
        also why a choice was given up."""
        given_up = self.given_up(entry)
        cost = f" (cost {entry.cost:.3g})" if entry.cost is not None and abs(entry.cost) >= 0.0005 else ""
        who = "" if entry.plugin == "engine" else f"  [{entry.plugin}]"
        mark = GIVEN_UP if given_up else MARKS[entry.outcome]
        yield f"{mark:2} {entry.designator} {_decision_text(entry)}{cost}{who}".rstrip()
        if given_up and (why := self._why_given_up(entry)):
            yield f"   {why}"

    def _why_given_up(self, entry: Entry) -> str:
        """Return why a choice was given up: of the refusals that followed it, the nearest miss; "" if the choice had no
        alternative."""
        miss = nearest_miss(self.entries[entry.number : self.ends[entry.number] - 1]) if self.rivals[entry.number] > 1 else None
        return f"given up: {miss.designator}: {rounded(miss.reason)}" if miss else ""


def _ends(entries: Sequence[Entry]) -> dict[int, int]:
    """Map each choice of a search trace to the number of the first entry after all that followed from the
    choice.

    The search goes depth first, so a subtree ends where something is asked, tried or said that hangs no deeper than the choice
    itself. Of goals, whose steps hang under nothing, nothing is known.
    """
    ends: dict[int, int] = {}
    open_: list[Entry] = []
    for entry in entries:
        while open_ and entry.kind not in ("twin", "proof") and entry.parent <= open_[-1].parent:
            ends[open_.pop().number] = entry.number
        if entry.outcome == "chosen" and entry.parent:
            open_.append(entry)
    return {**ends, **{e.number: len(entries) + 1 for e in open_}}


def _decision_text(entry: Entry) -> str:
    """Return the alternative and the reason of a trace entry; words that both contain are given once."""
    name = entry.text if entry.outcome in ("asked", "chosen", "refused", "nogood") else ""
    name = re.sub(r"^\d+:(?=\()", "", name)
    return rounded(": ".join(x for x in ("" if _repeats(name, entry) else name, entry.reason) if x))


def _repeats(name: str, entry: Entry) -> bool:
    """Check whether the name of an alternative already appears in the reason or the designator of its trace entry."""
    key = re.escape(name)
    number = re.fullmatch(r"-?[\d.]+", name) is not None and entry.reason != ""
    again = re.match(rf"{key}(?!\w)", entry.reason) or (" " in name and name in entry.reason)
    return name == entry.designator or number or bool(again)


def rounded(text: str) -> str:
    """Round numbers in a text to three digits after the point."""
    return re.sub(r"-?\d+\.\d{4,}(e-?\d+)?", lambda m: f"{round(float(m[0]), 3) + 0.0:g}", text)

