"""Files of experiments that were read: what they name, and the files beside them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from ..base.errors import UserError, nearest
from ..base.value import Value

Named = TypeVar("Named")


class ExperimentFile(Value):
    """File of an experiment that was read and checked."""

    path: Path

    def beside(self, name: str) -> Path:
        """Return the path of a file that the experiment names relative to its own folder."""
        return self.path.resolve().parent / name

    def named(self, kind: str, name: str, known: Mapping[str, Named]) -> Named:
        """Return what the file calls so.

        Args:
            kind: what is looked for, for people, e.g. "set".
            known: those that the file has.

        Raises:
            UserError: there is none of the name.
        """
        if name not in known:
            raise UserError(f"{self.path} has no {kind} '{name}'; {nearest(name, known)}.")
        return known[name]
