"""Files of experiments: found, read and checked, with the files that they name and those beside them."""

from __future__ import annotations

from collections.abc import Mapping
from os.path import normpath
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from ..base.errors import UserError, nearest
from ..base.resources import data_folder
from ..base.spec import Spec
from ..base.value import Value
from ..base.yaml_file import explain_validation, line_of, load_yaml

FILE = "experiment.yaml"
RENAMED = {"judge": "benchmark", "judges": "validators"}
"""Former keys of experiment files, which are still read, with their present names."""
Named = TypeVar("Named")
S = TypeVar("S", bound=Spec)


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
        """Return the entry with a given name from a section of the file, such as ``sets``.

        Args:
            kind: what is looked for, for people, e.g. "set".
            known: those that the file has.

        Raises:
            UserError: there is none of the name.
        """
        if name not in known:
            raise UserError(f"{self.path} has no {kind} '{name}'; {nearest(name, known)}.")
        return known[name]


def find_experiment(name: str) -> Path:
    """Find an experiment's file by the path of the file, by its folder, or by the name of a shipped
    experiment.

    Raises:
        UserError: there is none; lists the shipped ones, the nearest first.
    """
    shipped = {p.parent.name: p for p in data_folder("experiments").glob(f"*/{FILE}")}
    for path in (Path(name), Path(name) / FILE, shipped.get(Path(name).name)):
        if path is not None and path.is_file():
            return path
    raise UserError(f"There is no experiment '{name}', and none of that name is shipped; {nearest(name, shipped)}.")


def is_benchmark(path: Path) -> bool:
    """Return whether an experiment's file names a benchmark.

    Raises:
        UserError: it cannot be read, or is no YAML.
    """
    data = load_yaml(path)
    return isinstance(data, Mapping) and not {"benchmark", "judge"}.isdisjoint(data)


def old_keys(path: Path) -> list[str]:
    """Return a warning for each key of an experiment's file that has another name now.

    Raises:
        UserError: it cannot be read, or is no YAML.
    """
    data = load_yaml(path)
    found = [old for old in RENAMED if isinstance(data, Mapping) and old in data]
    return [f"{path}:{line_of(data, (old,))}: the key '{old}' is called '{RENAMED[old]}' now; write that in its place" for old in found]


def read_spec(path: Path, kind: type[S]) -> tuple[S, Mapping[str, Any]]:
    """Read an experiment's file; return its specification, and its data with line numbers.

    Raises:
        UserError: not YAML, an unknown key, or a wrong value: with file and line.
    """
    data = load_yaml(path)
    if not isinstance(data, Mapping):
        raise UserError(f"{path}:1: an experiment is a mapping that begins with 'experiment: NAME'.")
    _rename(data)
    try:
        return kind.model_validate(data), data
    except ValidationError as error:
        raise explain_validation(path, data, error, list(kind.model_fields)) from error


def _rename(data: Any) -> None:
    """Give keys of older files the name that they have now, in their place; a file with both names is refused later."""
    for old in RENAMED.keys() & data.keys():
        if RENAMED[old] not in data:
            data[RENAMED[old]], data.lines[RENAMED[old]] = data.pop(old), data.lines.pop(old)
