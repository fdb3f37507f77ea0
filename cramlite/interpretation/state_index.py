"""Index of states by time: which states hold in every interval between two neighbouring times at which a state
begins or ends."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable

from msgspec.structs import replace

from ..model.episode import Event


class StateIndex:
    """Index of states by the intervals in which they hold.

    Args:
        events: states; those that end before they start, or at once, are left out.
        last: end of the recording [s]. A state that still holds then is taken to go on.
    """

    def __init__(self, events: Iterable[Event], last: float) -> None:
        def end(event: Event) -> float:
            return event.end if event.end < last else float("inf")

        open_ended = [replace(e, end=end(e)) if end(e) != e.end else e for e in events if e.end > e.start]
        self._bounds = sorted({t for e in open_ended for t in (e.start, e.end)})
        starting: dict[float, list[Event]] = {}
        for event in open_ended:
            starting.setdefault(event.start, []).append(event)
        self.boundaries = frozenset(self._bounds)
        self._active: list[tuple[Event, ...]] = []
        current: tuple[Event, ...] = ()
        for bound in self._bounds:
            current = (*(e for e in current if e.end > bound), *starting.get(bound, ()))
            self._active.append(current)
        self._kinds = _kinds(open_ended)
        self._kinds_of: dict[int, tuple[int, ...]] = {}

    def at(self, time: float) -> tuple[Event, ...]:
        """Return the states with start <= time < end, in order of start."""
        k = bisect_right(self._bounds, time) - 1
        return self._active[k] if k >= 0 else ()

    def between(self, start: float, end: float) -> tuple[Event, ...]:
        """Return the states that hold at some time in [start, end)."""
        first = bisect_right(self._bounds, start) - 1
        after = max(bisect_left(self._bounds, end), first + 1)
        if after == first + 1:
            return self._active[first] if first >= 0 else ()
        seen = {e.id: e for active in self._active[max(first, 0) : after] for e in active}
        return tuple(seen.values())

    def holding(self, start: float, end: float) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return the states that hold throughout [start, end), and those that hold at some time of it, as sorted
        tuples of state numbers.

        States of one class with the same roles have the same number.

        Two phases with the same answer cannot be told apart by which states hold.
        """
        k = bisect_right(self._bounds, start)
        if k == len(self._bounds) or end <= self._bounds[k]:
            kinds = self._between_bounds(k - 1)
            return kinds, kinds
        spanning = tuple([self._kinds[id(e)] for e in self.at(start) if e.end >= end])
        return spanning, tuple([self._kinds[id(e)] for e in self.between(start, end)])

    def _between_bounds(self, number: int) -> tuple[int, ...]:
        kinds = self._kinds_of.get(number)
        if kinds is None:
            active = self._active[number] if number >= 0 else ()
            kinds = self._kinds_of[number] = tuple([self._kinds[id(e)] for e in active])
        return kinds


def _kinds(events: Iterable[Event]) -> dict[int, int]:
    """Assign a number to each event; events of one class with the same roles get the same number."""
    numbers: dict[object, int] = {}
    return {
        id(e): numbers.setdefault((e.type, e.inferred, tuple(sorted(e.roles.items()))), len(numbers)) for e in events
    }
