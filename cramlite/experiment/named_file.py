"""Files of experiments that were read: what they name, and the files beside them."""

from __future__ import annotations

from collections.abc import Mapping
from os.path import normpath
from pathlib import Path
from typing import TypeVar

from ..base.errors import UserError, nearest
from ..base.resources import data_folder
from ..base.value import Value

Named = TypeVar("Named")


class ExperimentFile(Value):
    """File of an experiment that was read and checked."""

    path: Path

    def beside(self, name: str) -> Path:
        """Return the path of a file that the experiment names relative to its own folder.

        One of a neighbouring folder that is not there is that of the shipped experiments: a copy elsewhere still has it.
        """
        folder = self.path.resolve().parent
        own, shipped = folder / name, Path(normpath(data_folder("experiments") / folder.name / name))
        neighbour = Path(name).parts[:1] == ("..",)
        return shipped if neighbour and not own.exists() and shipped.exists() else own

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
