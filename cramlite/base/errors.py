"""Errors that reach a person, and the exit code of each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

InTheWay = tuple[str | tuple[str, ...], ...] | None
"""Names of things, or groups of names, that the validity of a refusal depends on, besides the choices made in the search. The refusal
holds while each group has a thing that no task has changed; a name alone is a group of one. () where no other thing matters, None where
that is not known."""


LONG = re.compile(r"(?<![^\s(])'(?=\S)[^'\n]{400,}'(?=[\s;,.:)]|$)|[(\[][-+\d.,\se]{400,}[)\]]|\S{400,}")
"""Pattern of the overlong parts of an error message: a quoted text, a list of numbers or a word of at least 400 characters."""
BEGINNING, END = 100, 40
"""Numbers of characters kept from the beginning and from the end of a part of a message that is shortened."""


class CramliteError(Exception):
    """Base of all errors for people; the message is one paragraph with the place, the defect, the right input
    and the next step.

    What nobody would read is cut.
    """

    exit_code = 2

    def __str__(self) -> str:
        return LONG.sub(_cut, super().__str__())


def _cut(found: re.Match[str]) -> str:
    """Return the beginning and the end of a long text, and between them how many characters the whole text has."""
    return f"{found[0][:BEGINNING]}... ({len(found[0])} characters) ...{found[0][-END:]}"


class UserError(CramliteError):
    """Unusable input: a scenario, episode, rule, ontology, mesh or option."""


class ProcessGone(UserError):
    """Error: a process that acts as a robot or as the simulator of a benchmark has ended, or no longer replies."""


class NoSolution(CramliteError):
    """No proven program: every alternative was refused; the message holds the nearest miss."""

    exit_code = 1


class PluginError(CramliteError):
    """Defect of a plugin: the message names the plugin, its version, the hook and the designator."""

    exit_code = 3


DEFECTS = (Exception, SystemExit)
"""Exception types that count as a defect when a plugin's code raises them. SystemExit is one of them, since a search that a plugin ends
by it would look solved (exit code 0)."""


class Unresolvable(Exception):
    """Infeasibility of a designator, raised by the plugin that is responsible for the designator.

    It means "this query is mine, and what it asks for is impossible".

    Where it depends on the tasks before, use ``because_of_earlier_tasks``.

    Args:
        reason: a short clause with numbers and units, e.g. "reach 0.91 m > 0.85 m of arm 'ur5e'".
        because: names of the designators or roles whose choices this depends on; empty means all earlier ones.
        numbers: those of the reason, by name, with units in the names, e.g. {"reach_m": 0.91, "limit_m": 0.85}.
        blocking: what stands in the way, closed or full (``InTheWay``), so that it may be possible once a task has changed it.
        collision: the ``cramlite.model.Collision`` that is to blame, to be drawn in the report; None where there is none.
        remedy: the ``cramlite.model.Remedy``: what is missing and what to try; None where that is not known.
    """

    def __init__(
        self, reason: str, because: tuple[str, ...] = (), numbers: Mapping[str, float] | None = None,
        *, blocking: InTheWay = None, collision: object = None, remedy: object = None,
    ) -> None:  # fmt: skip
        super().__init__(reason)
        self.reason, self.because, self.numbers = reason, because, checked_numbers(numbers or {})
        self.blocking, self.collision, self.remedy, self.earlier_tasks = blocking, collision, remedy, False

    @classmethod
    def because_of_earlier_tasks(
        cls, reason: str, also: tuple[str, ...] = (), *, blocking: InTheWay = None, collision: object = None, remedy: object = None
    ) -> Unresolvable:
        """Make the error for a designator that is infeasible, but might be feasible after other choices for earlier
        tasks.

        Such choices are the objects, places and motions of these tasks.

        Args:
            reason: as above.
            also: names of the designators or roles whose choices it depends on beside that.
            blocking, collision, remedy: as above.
        """
        made = cls(reason, also, blocking=blocking, collision=collision, remedy=remedy)
        made.earlier_tasks = True
        return made


def checked_numbers(numbers: Mapping[str, float]) -> Mapping[str, float]:
    """Check that the numbers of a refusal's reason are a mapping of names to numbers, and return them.

    Raises:
        TypeError: they are no mapping of names to numbers; the plugin that gives them is to blame.
    """
    if not isinstance(numbers, Mapping):
        raise TypeError(f"numbers must be a mapping such as {{'reach_m': 0.91}}, not {numbers!r}"[:200])
    for name, value in numbers.items():
        if not isinstance(name, str) or not isinstance(value, int | float) or isinstance(value, bool):
            raise TypeError(f"numbers must each have a name, such as {{'reach_m': 0.91}}, not {{{name!r}: {value!r}}}"[:200])
    return numbers


LONGEST_LIST = 60
"""Largest number of names in a list: a longer one hides the right name."""


def nearest(name: str, valid: object) -> str:
    """List the valid names for a message, the most similar first: "did you mean 'x'? valid are: ...".

    Of more than ``LONGEST_LIST`` names only the nearest few are listed.
    """
    import difflib

    names = sorted(str(v) for v in valid)  # type: ignore[attr-defined]
    hint = did_you_mean(name, names)
    if len(names) > LONGEST_LIST:
        some = difflib.get_close_matches(name, names, n=6, cutoff=0.0)
        return f"{hint}of {len(names)} names the nearest are: {', '.join(some)}"
    return f"{hint}valid are: {', '.join(names) or 'none'}"


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """Return "did you mean 'x'? ", or "" where no valid name is similar."""
    import difflib

    written = {v.casefold(): v for v in sorted(valid)}
    close = difflib.get_close_matches(name.casefold(), written, n=1, cutoff=0.5)
    return f"did you mean '{written[close[0]]}'? " if close else ""
