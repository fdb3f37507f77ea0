"""Runs of a program under test, with the assertions about them.

Each assertion returns the run, so that several can follow one another. It is asked of the run in the world as it is and of each
twin: it holds if it holds in the former and in ``AT_LEAST`` of all. Where it does not, an ``AssertionError`` says what happened,
when, and in which line of the program, and a page with the moment drawn is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base.quantities import parse_quantity
from ..base.value import Value
from ..engine.proof.judging import Purpose, judge_rollout
from ..model.geometry import Floats
from ..model.run.rollout import Rollout, Touch
from ..model.twins.proof_doubts import ProofDoubts
from ..model.twins.twin_drawing import Draw
from ..plugin.catalogue import Knowledge
from .failure_page import write_failure_page
from .miss import Miss, ProgramFailure, name_is, names_of, said_touch
from .snapshots import Tolerances, compare, read_snapshot, taken, write_snapshot

AT_LEAST = ProofDoubts().at_least
"""Least share of all runs in which an assertion must hold: the same share as in proofs."""
Quantity = float | str
"""A number in SI units, or text with a unit: "5 mm"."""


class Way(Value):
    """Single run of a program: in the world as it is, or in a twin.

    Args:
        name: "the run", or "twin 3 of 9".
        draws: what makes the twin's world differ.
    """

    name: str
    rollout: Rollout
    draws: tuple[Draw, ...] = ()


class ProgramRun:
    """Runs of a program, the nominal one first, with assertions about them.

    Args:
        name: of the program, for messages.
        text: of the program.
        folder: that snapshots are relative to.
        page: that a failure is drawn on.
        accept: whether snapshots are written anew.
    """

    def __init__(
        self,
        name: str,
        text: str,
        ways: Sequence[Way],
        knowledge: Knowledge,
        folder: Path,
        page: Path,
        accept: bool = False,
    ) -> None:
        self.name, self.text, self.ways, self.knowledge = name, text, tuple(ways), knowledge
        self.folder, self.page, self.accept = folder, page, accept

    @property
    def rollout(self) -> Rollout:
        """Recording of the run in the world as it is, without a twin's errors."""
        return self.ways[0].rollout

    @property
    def seconds(self) -> float:
        """Duration of the program, without the time in which things came to rest afterwards [s]."""
        return _ends(self.rollout)

    def ends(self, *goals: str) -> ProgramRun:
        """Assert that the program comes to its end, and that goals then hold with their things at rest.

        Args:
            goals: in words, as in scenarios: "part in tray", "not lid on pot", "bottle upright".

        Raises:
            UserError: one is no goal, or names a thing that the world does not have.
        """
        __tracebackhide__ = True
        return self._hold(_called("ends", goals), lambda way: _not_finished(way) or self._goals(way, goals))

    def stops(self, saying: str = "") -> ProgramRun:
        """Assert that the program does not come to its end: it halts by itself, or the controller stops it.

        Args:
            saying: words that the reason, or the last thing that the program logged, must have.
        """
        __tracebackhide__ = True
        return self._hold(f"stops({saying!r})", lambda way: _not_stopped(way, saying))

    def touches(self, one: str, other: str) -> ProgramRun:
        """Assert that two bodies touch at some time.

        Args:
            one, other: things, "hand", or with a part: "tray/rim", "hand/left".
        """
        __tracebackhide__ = True
        for way in self.ways:
            names_of(way.rollout, (one, other))
        return self._hold(f"touches({one!r}, {other!r})", lambda way: _never_touched(way, one, other))

    def never_touches(self, one: str, other: str) -> ProgramRun:
        """Assert that two bodies, named as for ``touches``, never touch."""
        __tracebackhide__ = True
        for way in self.ways:
            names_of(way.rollout, (one, other))
        return self._hold(f"never_touches({one!r}, {other!r})", lambda way: _touched(way, one, other))

    def leaves(self, *things: str, within: Quantity = 0.005) -> ProgramRun:
        """Assert that things never move farther than a distance from where they stood at the start [m]."""
        __tracebackhide__ = True
        most = _quantity(within, "length")
        for thing in things:
            names_of(self.rollout, (thing,))
        return self._hold(_called("leaves", things), lambda way: _moved(way, things, most))

    def pushes(self, at_most: Quantity, *, after: Quantity = 0.0, before: Quantity | None = None) -> ProgramRun:
        """Assert that the contact force at the tool never exceeds a limit between two times.

        Args:
            at_most: what it may be [N].
            after, before: times since the start [s].
        """
        __tracebackhide__ = True
        most = _quantity(at_most, "force")
        first, last = _quantity(after, "time"), np.inf if before is None else _quantity(before, "time")
        return self._hold(f"pushes(at_most={at_most!r})", lambda way: _too_strong(way, most, first, last))

    def takes(self, at_most: Quantity) -> ProgramRun:
        """Assert that the program ends within a time [s]."""
        __tracebackhide__ = True
        most = _quantity(at_most, "time")
        return self._hold(f"takes(at_most={at_most!r})", lambda way: _too_long(way, most))

    def moves(self, at_most: float) -> ProgramRun:
        """Assert that the tool never moves faster than a limit [m/s], whatever speed was commanded."""
        __tracebackhide__ = True
        return self._hold(f"moves(at_most={at_most!r})", lambda way: _too_fast(way, at_most))

    def logs(self, words: str) -> ProgramRun:
        """Assert that the program logs a message that contains some words."""
        __tracebackhide__ = True
        return self._hold(f"logs({words!r})", lambda way: _not_logged(way, words))

    def holds(self, claim: Callable[[Rollout], Any], says: str) -> ProgramRun:
        """Assert that a function of the recorded run returns true.

        Args:
            claim: is given the record, and returns whether it is as it should be: a truth value, or one for each sample (N,), of which
                the first that is false is the moment of a failure.
            says: what it claims, for the message.
        """
        __tracebackhide__ = True
        return self._hold(says, lambda way: _claimed(way, claim, says))

    def matches(
        self,
        snapshot: str | Path,
        *,
        force: Quantity = 3.0,
        time: Quantity = 0.5,
        path: Quantity = 0.005,
        places: Quantity = 0.005,
    ) -> ProgramRun:
        """Assert that the run equals its snapshot, a text file that people review like code.

        A missing one is written, and the assertion fails once. ``pytest --cramlite-accept`` writes them anew.

        Args:
            snapshot: its file, relative to the test's.
            force: by how much peak forces may differ [N].
            time: by how much times may [s].
            path: by how much the tool's path may, at the same share of it [m].
            places: by how much things may end elsewhere [m].
        """
        __tracebackhide__ = True
        file = self.folder / snapshot
        now = taken(self.rollout, _ends(self.rollout))
        if self.accept:
            write_snapshot(file, now)
            return self
        if not file.exists():
            write_snapshot(file, now)
            new = f"there was no snapshot; '{file}' was written: look at it, and run again"
            self._fail(f"matches({str(snapshot)!r})", [(self.ways[0], Miss(new, in_twins=False))])
        allowed = Tolerances(
            _quantity(force, "force"), _quantity(time, "time"), _quantity(path, "length"), _quantity(places, "length")
        )
        found = compare(read_snapshot(file), now, allowed)
        if found:
            accept = "pytest --cramlite-accept takes the new ones"
            self._fail(
                f"matches({str(snapshot)!r})", [(self.ways[0], Miss(f"{'; '.join(found)}; {accept}", in_twins=False))]
            )
        return self

    def _goals(self, way: Way, goals: Iterable[str]) -> Miss | None:
        """Return a finding on the first goal that does not hold; None if all hold."""
        purpose = Purpose(goal=tuple(goals))
        found = judge_rollout(self.text, way.rollout, purpose, self.knowledge).verdict.findings
        wrong = next((f for f in found if not f.passed), None)
        return None if wrong is None else Miss(wrong.reason, _ends(way.rollout), tuple(goals))

    def _hold(self, asked: str, check: Callable[[Way], Miss | None]) -> ProgramRun:
        """Check all runs; fail the assertion if the nominal run or too many twins do not fulfil it."""
        __tracebackhide__ = True
        missed = [(way, miss) for way in self.ways if (miss := check(way)) is not None]
        if missed and (missed[0][0] is self.ways[0] or len(self.ways) - len(missed) < AT_LEAST * len(self.ways)):
            self._fail(asked, missed)
        return self

    def _fail(self, asked: str, missed: Sequence[tuple[Way, Miss]]) -> None:
        """Write a page about the first run that failed an assertion, and raise its error."""
        __tracebackhide__ = True
        way, miss = missed[0]
        lines = [f"{self.name}, {asked}: in {way.name} {miss.reason}", *miss.where(way.rollout, self.text)]
        if len(self.ways) > 1 and miss.in_twins:
            lines.append(
                f"The assertion holds in {len(self.ways) - len(missed)} of {len(self.ways)} runs; a share of {AT_LEAST:.2f} is required."
            )
        if way.draws:
            lines.append("That twin: " + "; ".join(map(str, way.draws[:6])) + (" ..." if len(way.draws) > 6 else ""))
        write_failure_page(self.page, lines, way.rollout, miss, self.text, self.knowledge)
        raise ProgramFailure("\n".join([*lines, f"Drawn on {self.page}"]))


def _called(name: str, words: Iterable[str]) -> str:
    """Return the text of an assertion's call, such as "touches('hand', 'tray')"."""
    return f"{name}({', '.join(map(repr, words))})"


def _ends(rollout: Rollout) -> float:
    """Return the time at which the program ended [s]."""
    lined = np.flatnonzero(rollout.lines)
    return float(rollout.times[lined[-1]]) if len(lined) else float(rollout.times[-1])


def _claimed(way: Way, claim: Callable[[Rollout], Any], says: str) -> Miss | None:
    found = np.asarray(claim(way.rollout), dtype=bool)
    if found.all():
        return None
    when = float(way.rollout.times[int(found.argmin())]) if found.shape == way.rollout.times.shape else None
    return Miss(f"it does not hold that {says}", when)


def _not_finished(way: Way) -> Miss | None:
    rollout = way.rollout
    return (
        None
        if rollout.outcome == "finished"
        else Miss(f"it ended by {rollout.outcome}: {rollout.reason}", _ends(rollout))
    )


def _not_stopped(way: Way, saying: str) -> Miss | None:
    rollout = way.rollout
    if rollout.outcome == "finished":
        return Miss("it came to its end", _ends(rollout))
    said = f"{rollout.outcome}: {rollout.reason} {rollout.messages[-1].text if rollout.messages else ''}".strip()
    return (
        None
        if saying.lower() in said.lower()
        else Miss(f"the program ended by {said}, which does not contain '{saying}'", _ends(rollout))
    )


def _first_touch(rollout: Rollout, one: str, other: str) -> tuple[int, Touch] | None:
    for sample, touches in enumerate(rollout.touches):
        for touch in touches:
            if any(name_is(a, one) and name_is(b, other) for a, b in ((touch.a, touch.b), (touch.b, touch.a))):
                return sample, touch
    return None


def _never_touched(way: Way, one: str, other: str) -> Miss | None:
    return (
        None
        if _first_touch(way.rollout, one, other)
        else Miss(f"'{one}' and '{other}' never touch", about=(one, other))
    )


def _touched(way: Way, one: str, other: str) -> Miss | None:
    found = _first_touch(way.rollout, one, other)
    if found is None:
        return None
    sample, touch = found
    return Miss(f"{said_touch(touch)} with {touch.force:.1f} N", float(way.rollout.times[sample]), (one, other))


def _moved(way: Way, things: Iterable[str], most: float) -> Miss | None:
    for thing in things:
        if (track := way.rollout.poses.get(thing)) is None:
            continue
        far = np.linalg.norm(track[:, :3] - track[0, :3], axis=1)
        if (over := np.flatnonzero(far > most)).size:
            said = f"'{thing}' moves {1000 * far.max():.0f} mm from its place, {1000 * most:.0f} mm are allowed"
            return Miss(said, float(way.rollout.times[over[0]]), (thing,))
    return None


def _too_strong(way: Way, most: float, first: float, last: float) -> Miss | None:
    rollout = way.rollout
    force = np.where((rollout.times >= first) & (rollout.times <= last), rollout.contact_force(), 0.0)
    peak = int(force.argmax())
    if force[peak] <= most:
        return None
    return Miss(f"the tool pushes with {force[peak]:.1f} N, {most:g} N are allowed", float(rollout.times[peak]))


def _too_long(way: Way, most: float) -> Miss | None:
    spent = _ends(way.rollout)
    return Miss(f"the program takes {spent:.2f} s, {most:g} s are allowed", spent) if spent > most else None


def _too_fast(way: Way, most: float) -> Miss | None:
    speeds = tool_speeds(way.rollout)
    peak = int(speeds.argmax())
    if speeds[peak] <= most:
        return None
    return Miss(f"the tool moves with {speeds[peak]:.2f} m/s, {most:g} m/s are allowed", float(way.rollout.times[peak]))


def _not_logged(way: Way, words: str) -> Miss | None:
    if any(words.lower() in m.text.lower() for m in way.rollout.messages):
        return None
    last = way.rollout.messages[-1].text if way.rollout.messages else ""
    return Miss(
        f"no message has '{words}'; " + (f"the last one is '{last}'" if last else "nothing was logged"),
        _ends(way.rollout),
    )


def tool_speeds(rollout: Rollout) -> Floats:
    """Return the speed of the tool at each sample (N,) [m/s]."""
    way = np.diff(rollout.poses["effector"][:, :3], axis=0)
    speeds: Floats = np.concatenate([[0.0], np.linalg.norm(way, axis=1) / np.maximum(np.diff(rollout.times), 1e-9)])
    return speeds


def _quantity(value: Any, kind: str) -> float:
    return parse_quantity(value, kind)
