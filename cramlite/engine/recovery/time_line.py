"""Time line of an execution with replanning: faults, notices, decisions and resumptions, for people and
programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from msgspec import DecodeError, json

from ...base.errors import NoSolution, UserError
from ...base.run_directory import write_whole
from ...base.value import Value
from ...model.episode import Event
from ...model.run.readings import Notice

if TYPE_CHECKING:
    from ...model.run.rollout import Rollout
    from ..solution import Solution
    from .going_on import GoingOn, Stretch

FILE = "time_line.json"
What = Literal["fault", "notice", "decision", "resumption", "end"]
CLASSES = {"fault": "Fault", "decision": "Decision", "resumption": "Resumption"}
"""Ontology class of each kind of time-line entry, except notices, which state their own."""
INSTANT = 0.001
"""Length of an event that is an instant [s]."""


class Moment(Value):
    """Entry in the time line of an execution: a fault, notice, decision or resumption, or the end.

    Args:
        time: since the first program's start, while programs ran [s]: thinking takes none of it.
        round: the program that ran, from 1.
        what: kind of the moment.
        said: in a clause.
        notice: of a "notice", with its class and numbers.
        thought: CPU time that a "decision" took [s].
        since: since the start of the program that ran [s].
        thing: that a fault or a notice is about; "" for none.
    """

    time: float
    round: int
    what: What
    said: str
    notice: Notice | None = None
    thought: float = 0.0
    since: float = 0.0
    thing: str = ""

    def __str__(self) -> str:
        """Return the entry of the execution's time line as a line of text."""
        spent = f" ({self.thought:.1f} s of CPU time)" if self.what == "decision" else ""
        return f"{self.time:8.2f} s  round {self.round}  {self.what:<10} {self.said}{spent}"


def time_line(stretches: Iterable[Stretch]) -> Iterator[Moment]:
    """Generate the entries of an execution's time line: faults, notices, decisions, resumptions and the end,
    in order."""
    begun = 0.0
    for number, stretch in enumerate(stretches, 1):
        rollout = stretch.round.rollout
        lasted = float(rollout.times[-1])
        ended, things = begun + lasted, {str(f): f.thing for f in stretch.round.attempt.world.faults}
        if number > 1:
            origins = stretch.round.attempt.code.origins
            yield Moment(begun, number, "resumption", origins[min(origins)] if origins else "")
        for fault in rollout.faults:
            yield Moment(begun + fault.time, number, "fault", fault.text, since=fault.time, thing=things.get(fault.text, ""))
        if stretch.notice is None:
            yield Moment(ended, number, "end", stretch.round.said, since=lasted)
        else:
            notice = stretch.notice
            yield Moment(begun + notice.time, number, "notice", str(notice), notice, since=notice.time, thing=notice.thing)
            yield Moment(ended, number, "decision", stretch.decision, thought=stretch.thought, since=lasted)
        begun = ended


def gone_on(going: GoingOn, solution: Solution, told: Callable[[Stretch], object] = lambda _: None) -> tuple[list[Moment], str]:
    """Execute a proven program and, after each stop, the program that follows, to the end.

    Args:
        told: is given each stretch when it has ended.

    Returns:
        The time line, and why the execution could not go on: "" where it came to its end.
    """
    done, why = list["Stretch"](), ""
    try:
        for stretch in going.execute(solution):
            done.append(stretch)
            told(stretch)
    except NoSolution as error:
        why = str(error)
    return list(time_line(done)), why


def events_of(moments: Iterable[Moment], round_: int, rollout: Rollout) -> tuple[Event, ...]:
    """Return the faults, notices, decisions and resumption around one run of an execution with replanning,
    as events."""
    things, found = {t.name for t in rollout.world.things}, list[Event]()
    for number, moment in enumerate(moments):
        kind = moment.notice.kind if moment.notice else CLASSES.get(moment.what)
        if moment.round != round_ or kind is None:
            continue
        roles = {"object": moment.thing} if moment.thing in things else {}
        found.append(Event(f"{moment.what}_{number}", f"cram:{kind}", "situation", moment.since, moment.since + INSTANT, roles))
    return tuple(found)


def write_time_line(moments: Iterable[Moment], folder: Path) -> None:
    """Write a time line into a folder of a run.

    Raises:
        UserError: it cannot be written.
    """
    write_whole(folder / FILE, json.format(json.encode(list(moments)), indent=1))


def read_time_line(folder: Path) -> Sequence[Moment]:
    """Read the time line of a run.

    Raises:
        UserError: it has none.
    """
    try:
        return json.decode((folder / FILE).read_bytes(), type=list[Moment])
    except OSError:
        raise UserError(f"'{folder}' has no {FILE}: 'cramlite execute PROGRAM --replan SCENARIO --out {folder}' writes one.") from None
    except DecodeError as error:
        raise UserError(f"'{folder / FILE}' is no time line: {error}.") from None
