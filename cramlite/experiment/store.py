"""Result store of a run: the directory belongs to one run, and every file in it is complete."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, Any, TypeVar

from msgspec import DecodeError, json

from ..base.errors import UserError
from ..base.file_lock import lock
from ..base.json_text import as_json
from ..base.run_directory import content_key, write_whole
from ..plugin.registry import Registry
from ..version import VERSION

LOCK, BEGUN, MOVED = "lock", "begun", "moved"
"""Names of marker files: of a run in progress, of a trial in progress, and of a trial that must not be repeated because its robot has
moved."""
RECORDED = "demonstrations"
T = TypeVar("T")


class Store:
    """Result store: a folder for each trial, whose ``result.json`` is written when the trial has ended.

    Args:
        path: run directory, which belongs to the run already.
        trials: name of the folder in it that holds those of the trials.
        result: type of a result.
    """

    def __init__(self, path: Path, trials: str, result: type[Any]) -> None:
        self.path, self.trials, self.result = path, path / trials, result

    def folder(self, trial: str) -> Path:
        """Return the folder of a trial."""
        return self.trials / trial

    def write(self, trial: str, name: str, content: str | bytes) -> Path:
        """Write a file of a trial atomically, and return its path."""
        return write_whole(self.folder(trial) / name, content)

    def save(self, trial: str, value: Any, piece: str = "result") -> None:
        """Write a part of a trial's results to a JSON file with the part's name; the part "result" marks the trial as
        ended."""
        self.write(trial, f"{piece}.json", as_json(value))

    def read(self, trial: str, piece: str, kind: type[T]) -> T | None:
        """Read a part of a trial's results from the JSON file with the part's name; None if there is no such file.

        Raises:
            UserError: it is damaged.
        """
        path = self.folder(trial) / f"{piece}.json"
        try:
            return json.decode(path.read_bytes(), type=kind)
        except FileNotFoundError:
            return None
        except (OSError, DecodeError) as error:
            said = str(error).splitlines()[0]
            raise UserError(
                f"'{path}' is damaged ({said}). Delete this one file and start the experiment again: only that part of the "
                "trial is done anew, and everything else is kept."
            ) from error

    def results(self) -> dict[str, Any]:
        """Read the results of all finished trials, by the trials' names.

        Raises:
            UserError: one is damaged.
        """
        names = sorted(p.parent.name for p in self.trials.glob("*/result.json"))
        return {name: self.read(name, "result", self.result) for name in names}

    def mark(self, trial: str) -> None:
        """Write the marker that a trial has begun, with this process's id, into the trial's folder."""
        self.write(trial, BEGUN, str(os.getpid()))

    def unmark(self, trial: str, *marks: str) -> None:
        """Remove marker files from a trial's folder; without names, the marker that the trial has begun."""
        for mark in marks or (BEGUN,):
            (self.folder(trial) / mark).unlink(missing_ok=True)

    def marked(self, how: str) -> list[str]:
        """Return the trials without a result whose folder has a marker file of a given name."""
        found = sorted(p.parent for p in self.trials.glob(f"*/{how}"))
        return [folder.name for folder in found if not (folder / "result.json").exists()]

    def receive(self, trial: str, files: Mapping[str, bytes]) -> None:
        """Write the files of a trial that ran on another machine; its result is written last.

        A half-received trial has no result and so counts as not done.

        Args:
            files: by their names in the directory of the run.
        """
        place = f"{self.trials.name}/{trial}"
        recorded, whole = f"{RECORDED}/{trial}", f"{place}/result.json"
        for name in (n for n in files if n.startswith(f"{place}/") and n != whole):
            write_whole(self.path / name, files[name])
        with tempfile.TemporaryDirectory(dir=self.path, prefix=".arriving-") as folder:
            for name in (n for n in files if n.startswith(f"{recorded}/")):
                write_whole(Path(folder) / name, files[name])
            if (Path(folder) / recorded).is_dir():
                self.adopt(Path(folder) / recorded, recorded)
        write_whole(self.path / whole, files[whole])

    def adopt(self, folder: Path, name: str) -> Path:
        """Move a folder that is complete into the run directory, over an older one of the same name; return its new
        path."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        folder.replace(target)
        return target


def locked(path: Path) -> IO[str]:
    """Lock a directory for this process; the lock is released when the process ends, however it ends.

    Raises:
        UserError: another process has it.
    """
    file = (path / LOCK).open("a+", encoding="utf-8")
    try:
        lock(file)
    except OSError as error:
        file.seek(0)
        raise UserError(
            f"Another experiment (process {file.read().strip() or 'unknown'}) is running in '{path}'; nothing was done. "
            "Wait for it, or choose another directory with --out."
        ) from error
    file.truncate(0)
    file.write(str(os.getpid()))
    file.flush()
    return file


def run_key(experiment: str, files: Iterable[Path], registry: Registry, **asked: Any) -> dict[str, Any]:
    """Return the key that identifies a run's results: it is the same on all machines that have the
    same files, code and options.

    Args:
        files: that the experiment reads.
        registry: plugins, whose source counts as the core's does.
        asked: whatever else changes results.
    """
    code = {Path(__file__).resolve().parents[1], *(Path(i.file).resolve().parent for i in registry.infos)}
    return {"cramlite": VERSION, "experiment": experiment, "files": content_key(*files), "code": _code_key(code), **asked}


def _code_key(folders: Iterable[Path]) -> str:
    """Return a hash of all Python source below some folders."""
    digest = hashlib.blake2b(digest_size=16)
    for folder in sorted(folders):
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()
