"""Files that a client of a server may read: those in the server's folder, and those shipped with cramlite;
links that lead out of that folder are refused."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...base.errors import UserError
from ...base.resources import shipped_scenario
from ...base.value import Value
from ...base.yaml_file import parse_yaml
from ...scenario.scenario import INLINE, Scenario, read_scenario, scenario_from, started_by

LONGEST_NAME = 300
"""Largest number of characters in a file name that a client gives: a path within one folder is shorter."""


def _texts(data: Any) -> Iterator[str]:
    """Yield every string in nested lists and mappings, keys of mappings excepted."""
    if isinstance(data, str):
        yield data
    elif isinstance(data, Mapping | list):
        for part in data.values() if isinstance(data, Mapping) else data:
            yield from _texts(part)


def quoted(text: str) -> str:
    """Return a text of a client in quotes for a message: on one line, and cut after 80 characters."""
    shown = ascii(text[:80])
    return f"{shown[:-1]}...{shown[-1]}" if len(text) > 80 else shown


class ClientFiles(Value):
    """Files that a client of a server may read.

    Args:
        folder: whose files may be read; relative names start here.
        runs: folder of the run directories.
    """

    folder: Path
    runs: Path

    def scenario(self, name: str) -> Path:
        """Find a scenario file in the server's folder, or a shipped one by its name.

        Raises:
            UserError: there is none, or it lies elsewhere.
        """
        path = inside(self.folder, name)
        return path if path.is_file() else shipped_scenario(name)

    def read(self, said: str | Mapping[str, Any], goal: Sequence[str] = ()) -> Scenario:
        """Read a scenario by its name, from data, or from the text of a file; relative paths in data or text
        count from the server's folder.

        Args:
            goal: what is asked in it; data that only says where starts from that.

        Raises:
            UserError: it cannot be used, or a file that it names lies elsewhere.
        """
        if isinstance(said, str) and "\n" not in said:
            return read_scenario(self.scenario(said))
        path = self.folder / INLINE
        data = parse_yaml(said, path) if isinstance(said, str) else said
        for text in _texts(data):
            self._require_inside(text)
        return scenario_from(path, started_by(data, goal) if goal else data)

    def _require_inside(self, text: str) -> None:
        """Refuse a text that, taken as a path, leads out of the server's folder."""
        path = Path(os.path.normpath(self.folder / text))
        if not path.is_relative_to(self.folder) or (os.path.lexists(path) and not path.resolve().is_relative_to(self.folder.resolve())):
            raise UserError(
                f"{quoted(text)} is outside the folder of this server; a scenario that is given as data may name only files in "
                "that folder, by relative paths."
            )

    def episode(self, name: str) -> Path:
        """Find an episode, which is a file or a folder, in the server's folder.

        Raises:
            UserError: there is none, or it lies elsewhere.
        """
        path = inside(self.folder, name)
        if not path.exists():
            raise UserError(f"There is no episode at {quoted(name)} in the folder of this server; name one relative to it.")
        return path

    def run(self, name: str) -> Path:
        """Find a run directory by its name.

        Raises:
            UserError: there is none.
        """
        path = inside(self.runs, name)
        if name not in self.run_names:
            raise UserError(f"There is no run {quoted(name)}; there are: {', '.join(self.run_names) or 'none yet'}.")
        return path

    @property
    def run_names(self) -> list[str]:
        """Names of the runs, in alphabetical order."""
        from ...base.run_directory import MANIFEST

        return sorted(p.parent.name for p in self.runs.glob(f"*/{MANIFEST}") if not p.parent.is_symlink())


def inside(folder: Path, name: str) -> Path:
    """Return the path of a name in a folder, with every link followed.

    Raises:
        UserError: it is outside, or can be no name of a file.
    """
    if len(name) > LONGEST_NAME or not name.isprintable() or not name:
        raise UserError(f"{quoted(name)} cannot be the name of a file; it has at most {LONGEST_NAME} printable characters.")
    try:
        path = (folder / name).resolve()
    except (OSError, RuntimeError) as error:  # a circle of links
        raise UserError(f"{quoted(name)} cannot be followed: {error}.") from error
    if not path.is_relative_to(folder.resolve()):
        raise UserError(
            f"{quoted(name)} is outside the folder of this server, so it is not read; the folder is chosen at the server's start "
            "(cramlite mcp --folder)."
        )
    return path
