"""Planning scene: the postures of a robot among things and the straight joint-space lines between them.

A line between two joint positions is not sampled on a grid: coarse intervals are looked at first, at their
middle. Two geoms at distance d there are apart to both sides as far as no point of one moves by d, seen from
the other (``approach`` bounds its speed); the rest of the interval is looked at again (after the adaptive
bisection of Schwarzer, Saha and Latombe, IEEE T-RO 21(3), 2005). A share of the clearance is left everywhere
in between. Parabolas between lines are checked in the same way.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence

from cramlite.model import Floats

from .approach import Rates, Span, posture, rates
from .inflated import Inflated
from .joint_line import PROBED, JointBlend, JointLine
from .postures import Joints, Position, Postures, as_joints

Part = tuple[float, float, Rates]
"""Part of a line: where it begins and ends, as fractions of the line, and how fast geoms approach there."""
Room = list[tuple[int, float]]
"""How much nearer near pairs may come [m], each by its combination of ``Chains``."""
KEPT = 0.3  # share of the needed distance that is kept between two checks, too
TINY = 1e-9  # approach of a pair below which no distance is too small [m]
# Shortest interval of a line, largest joint difference [rad]: only counts near such contacts
SMALLEST = 0.002


class PlanningScene(Postures):
    """Planning scene: a robot among things; make one with ``scene``."""

    def line_free(self, a: Position, b: Position) -> bool:
        """Check whether the straight joint-space line from a free position is free: its end first, then
        the middles of its parts, then the rest, long parts first."""
        return self.where_blocked([(a, b)]) == [None]

    def where_blocked(self, lines: Sequence[tuple[Position, Position]]) -> list[Joints | None]:
        """Return a blocked joint position on each of some straight joint-space lines from free positions,
        None where one is free."""
        ends = [None if self.free(b) else as_joints(b) for _, b in lines]
        within = [JointLine(a, b) for (a, b), end in zip(lines, ends, strict=True) if end is None]
        found = iter(self._stopped(within))
        return [next(found) if end is None else end for end in ends]

    def blend_free(self, start: Floats, corner: Floats, goal: Floats) -> bool:
        """Check that the parabola that rounds the corner of a joint path is free; the positions at its
        ends are known to be free."""
        return self._stopped([JointBlend(start, corner, goal)]) == [None]

    def _stopped(self, lines: Sequence[JointLine]) -> list[Joints | None]:
        """Return a blocked joint position on each line, None where the arm is free along the whole line.

        The middles of a line's parts are looked at first; bounds are only computed where none of these is
        blocked, of all lines at once.
        """
        looks = [self._middles(line) for line in lines]
        spans = [s for look in looks if isinstance(look, list) for s, _ in look]
        known = iter(rates(spans, self.chains) if spans else ())
        return [
            look
            if isinstance(look, tuple)
            else self._blocked_in(line, [(span, room, next(known)) for span, room in look])
            for line, look in zip(lines, looks, strict=True)
        ]

    def _middles(self, line: JointLine) -> list[tuple[Span, Room]] | Joints:
        """Parts of a line with the room that there is in the middle of each; a middle that is blocked."""
        found = []
        for low, high in line.parts():
            q = line.at((low + high) / 2)
            self._place(q)
            room = self._room(q, self.levels[-1])
            if room is None:
                return as_joints(q)
            found.append((Span(line, low, high, posture(self.data)), room))
        return found

    def _blocked_in(self, line: JointLine, parts: Iterable[tuple[Span, Room, Rates]]) -> Joints | None:
        """Return a blocked joint position on a line with free middles of its parts; None if there is none."""
        rest: deque[Part] = deque()
        for span, room, known in parts:
            rest.extend(self._rest(line, (span.low, span.high, known), room, self.levels[-1]))
        while rest:
            part = rest.popleft()
            opened = self._judge(line, part)
            if opened is None:
                return as_joints(line.at((part[0] + part[1]) / 2))
            rest.extend(opened)
        return None

    def line_probed(self, a: Position, b: Position, apart: float = PROBED) -> bool:
        """Check that the end of a joint-space line and samples on it, ``apart`` [rad] at most, are free;
        between samples it may be blocked."""
        return self.free(b) and all(map(self._keeps, JointLine(a, b).probes(apart)))

    def blocked(self, a: Position, b: Position) -> float | None:
        """Return the fraction of the straight joint-space line where it is first blocked; None when it is
        free."""
        if not self.free(a):
            return 0.0
        line = JointLine(a, b)
        found = next((at for part in self._parts(line) if (at := self._first(line, part)) is not None), None)
        return found if found is not None or self.free(b) else 1.0

    def _parts(self, line: JointLine) -> list[Part]:
        """Divide a joint-space line into parts with bounds on how fast geoms approach one another there."""
        spans = []
        for low, high in line.parts():
            self._place(line.at((low + high) / 2))
            spans.append(Span(line, low, high, posture(self.data)))
        return [(s.low, s.high, known) for s, known in zip(spans, rates(spans, self.chains), strict=True)]

    def _judge(self, line: JointLine, part: Part) -> list[Part] | None:
        """Check the middle of a part of a joint-space line: return the smaller parts that must still be
        checked, None if the middle is blocked."""
        low, high, known = part
        far = self.kept + (high - low) / 2 * known.most
        level = next((v for v in self.levels if v.distance >= far), self.levels[-1])
        q = line.at((low + high) / 2)
        self._place(q)
        room = self._room(q, level)
        return None if room is None else self._rest(line, part, room, level)

    def _room(self, q: Position, level: Inflated) -> Room | None:
        """With the arm placed at a joint position: how much nearer each near pair may come [m], by its
        combination of ``Chains``; None if one is too close."""
        found, which = [], self.chains.which
        for g, h, d in self._near(level):
            need = self.need.item(g, h)
            if d < need:
                need = self._needed(q, g, h)
                if d < need:
                    return None
            found.append((which.item(g, h), d - (KEPT * need if need > 0.0 else need)))
        return found

    def _rest(self, line: JointLine, part: Part, room: Room, level: Inflated) -> list[Part]:
        """Smaller parts of a part of a line that must still be checked: the room in its middle clears it to
        both sides, too."""
        low, high, known = part
        middle, half, between = (low + high) / 2, (high - low) / 2, known.between
        wide = level.distance >= self.kept + half * known.most
        reach = half if wide else (level.distance - self.kept) / known.most
        clear = reach
        for pair, left in room:
            nearer = between[pair]
            here = left / (nearer if nearer > TINY else TINY)
            clear = here if here < clear else clear
        if clear >= half or (high - low) * line.size < SMALLEST:
            return []
        count = max(1, math.ceil((half - clear) / (2 * reach)))
        step = (half - clear) / count
        before = [low + k * step for k in range(count)]
        after = [middle + clear + k * step for k in range(count)]
        return [(at, at + step, known) for at in before + after]

    def _first(self, line: JointLine, part: Part) -> float | None:
        """Return where the arm is first blocked on a part of a joint-space line, as a share 0 to 1 of the
        line; None if nowhere."""
        halves = self._judge(line, part)
        low, high, known = part
        if halves is None:
            middle = (low + high) / 2
            if (high - low) * line.size < SMALLEST:
                return middle
            before = self._first(line, (low, middle, known))
            return middle if before is None else before
        return next((at for p in halves if (at := self._first(line, p)) is not None), None)
