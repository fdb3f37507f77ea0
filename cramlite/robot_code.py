"""Code: a program's text, and which line came from which step."""

from __future__ import annotations

from .value import Value


class Code(Value):
    """A program's text.

    Args:
        language: e.g. "urscript".
        text: what a robot is given.
        origins: line (from 1) -> origin of the step it came from.
        suffix: of its file, e.g. ".script".
    """

    language: str
    text: str
    origins: dict[int, str]
    suffix: str

    def task_of(self, line: int) -> str:
        """The task whose code the line is in: the last origin at or before it."""
        before = [k for k in self.origins if k <= line]
        return self.origins[max(before)].split("/")[0] if before else ""
