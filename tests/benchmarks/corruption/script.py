"""Text of a generated URScript program, by the steps that its comments name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence

from msgspec.structs import replace

from cramlite.base.value import Value

STEP = re.compile(r"^\s*# (\d+\.[^:\s]+): ")
"""Comment before the code of a step; the group is the step's origin."""

SECTION = re.compile(r"^  # ---- (\d+)\.")
"""Comment before the code of a task; the group is the task's number."""

END = "  kill watchdog_thread"
"""First line after the last task."""

Numbers = list[float]


class Script(Value):
    """Program text as lines; every edit returns another script.

    Args:
        lines: without line ends.
    """

    lines: tuple[str, ...]

    @property
    def text(self) -> str:
        """The text."""
        return "\n".join(self.lines) + "\n"

    def origins(self) -> tuple[str, ...]:
        """Return the origins of the steps that the comments name, in their order."""
        return tuple(m[1] for line in self.lines if (m := STEP.match(line)))

    def block(self, name: str, nth: int = 0) -> slice:
        """Find a step's comment and code.

        Args:
            name: its origin, or how that ends.
            nth: which of several, -1 for the last.
        """
        found = [k for k, line in enumerate(self.lines) if (m := STEP.match(line)) and m[1].endswith(name)]
        start = found[nth]
        end = next(k for k in range(start + 1, len(self.lines)) if self._ends(k))
        return slice(start, end)

    def _ends(self, k: int) -> bool:
        line = self.lines[k]
        return not line.strip() or line.startswith(END) or bool(STEP.match(line) or SECTION.match(line))

    def section(self, number: int) -> slice:
        """Find all lines of a task, from its comment to the next task's, or to the end of the last one."""
        starts = {int(m[1]): k for k, line in enumerate(self.lines) if (m := SECTION.match(line))}
        end = starts.get(number + 1, self.lines.index(END))
        return slice(starts[number], end)

    def spliced(self, place: slice, lines: Iterable[str]) -> Script:
        """Replace lines."""
        return replace(self, lines=(*self.lines[: place.start], *lines, *self.lines[place.stop :]))

    def after(self, name: str, lines: Iterable[str], nth: int = -1) -> Script:
        """Insert lines behind a step's code; they have no comment of their own."""
        end = self.block(name, nth).stop
        return self.spliced(slice(end, end), lines)

    def within(self, name: str, lines: Iterable[str], nth: int = 0) -> Script:
        """Insert lines between a step's comment and its code."""
        start = self.block(name, nth).start + 1
        return self.spliced(slice(start, start), lines)

    def without(self, name: str, nth: int = -1) -> Script:
        """Delete a step: its comment and its code."""
        return self.spliced(self.block(name, nth), ())

    def code(self, name: str, nth: int = -1) -> tuple[str, ...]:
        """Return a step's lines behind its comment."""
        return self.lines[self.block(name, nth)][1:]

    def coded(self, name: str, lines: Iterable[str], nth: int = -1) -> Script:
        """Keep a step's comment and replace its code."""
        place = self.block(name, nth)
        return self.spliced(slice(place.start + 1, place.stop), lines)

    def substituted(self, name: str, old: str, new: str, nth: int = -1) -> Script:
        """Replace a regular expression in a step's code, which must have it."""
        code = self.code(name, nth)
        changed = tuple(re.sub(old, new, line) for line in code)
        if changed == code:
            raise ValueError(f"'{old}' is not in the code of '{name}'")
        return self.coded(name, changed, nth)

    def variables(self, ending: str) -> tuple[str, ...]:
        """Return the names of poses and joint positions with an ending, in their order."""
        return tuple(
            m[1]
            for line in self.lines
            if (m := re.match(r"  global (\w+) = p?\[", line)) and re.search(ending + "$", m[1])
        )

    def numbers(self, name: str) -> Numbers:
        """Return a pose or joint positions by the full name of the variable."""
        return [float(n) for n in self._value(name)[2].split(",")]

    def with_numbers(self, name: str, change: Callable[[Numbers], Sequence[float]]) -> Script:
        """Change a pose or joint positions."""
        k, before, _ = self._value(name)
        numbers = ", ".join(f"{n:.6f}" for n in change(self.numbers(name)))
        return self.spliced(slice(k, k + 1), [f"{before}{numbers}]"])

    def _value(self, name: str) -> tuple[int, str, str]:
        for k, line in enumerate(self.lines):
            if m := re.match(rf"(  global {name} = p?\[)([^\]]*)\]", line):
                return k, m[1], m[2]
        raise KeyError(name)


def script_of(text: str) -> Script:
    """Read a program's text."""
    return Script(tuple(text.splitlines()))
