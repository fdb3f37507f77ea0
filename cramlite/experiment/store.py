"""Result store of an experiment: one run, one process that writes, every finished piece whole."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, TypeVar

from msgspec import DecodeError, json

from ..base.errors import UserError
from ..base.file_lock import lock
from ..base.json_text import as_json
from ..base.run_directory import write_whole
from .results import CandidateResult, DemonstrationResult

LOCK = "lock"
T = TypeVar("T", CandidateResult, DemonstrationResult)


class Store:
    """Result store: results by demonstration and candidate, as files.

    ``DEMONSTRATION/result.json`` is written when all its candidates are, ``DEMONSTRATION/K.json`` when the K-th is;
    beside it are ``K.script``, the text that was executed, and ``K.jpg``, how that ended.

    Args:
        path: of the directory, which belongs to the run already.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def folder(self, demonstration: str) -> Path:
        """Return the folder of a demonstration."""
        return self.path / "results" / demonstration

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file of the run atomically, and return its path."""
        return write_whole(self.path / name, content)

    def save(self, demonstration: str, name: str, result: CandidateResult | DemonstrationResult) -> None:
        """Write a result of a demonstration as JSON."""
        self.write(f"results/{demonstration}/{name}.json", as_json(result))

    def save_failure(self, demonstration: str, failure: str) -> None:
        """Write what a demonstration did not bring about."""
        self.write(f"results/{demonstration}/recorded", failure)

    def failure(self, demonstration: str) -> str:
        """Read what a demonstration did not bring about; "" where it came off."""
        return (self.folder(demonstration) / "recorded").read_text(encoding="utf-8")

    def candidate(self, demonstration: str, number: int) -> CandidateResult | None:
        """Read the result of a candidate; None if it is not finished."""
        return _read(self.folder(demonstration) / f"{number}.json", CandidateResult)

    def demonstration(self, demonstration: str) -> DemonstrationResult | None:
        """Read the result of a demonstration; None if it is not finished."""
        return _read(self.folder(demonstration) / "result.json", DemonstrationResult)

    def mark(self, demonstration: str) -> None:
        """Mark a demonstration as taken on by this worker process."""
        self.write(f"results/{demonstration}/worker", str(os.getpid()))

    def unmark(self, demonstration: str) -> None:
        """Remove the mark of a worker."""
        (self.folder(demonstration) / "worker").unlink(missing_ok=True)

    def unfinished(self) -> list[str]:
        """Return the names of demonstrations that a worker took on and did not finish."""
        return sorted(p.parent.name for p in (self.path / "results").glob("*/worker"))

    def receive(self, demonstration: str, files: Mapping[str, bytes]) -> None:
        """Take over the files of a trial that ran elsewhere; its result is written last, so that half of them count for nothing.

        Args:
            files: by their names in the directory of the run.
        """
        recorded, whole = f"demonstrations/{demonstration}", f"results/{demonstration}/result.json"
        own = [n for n in files if n.startswith(f"results/{demonstration}/") and n != whole]
        for name in own:
            self.write(name, files[name])
        with tempfile.TemporaryDirectory(dir=self.path, prefix=".arriving-") as folder:
            for name in (n for n in files if n.startswith(f"{recorded}/")):
                write_whole(Path(folder) / name, files[name])
            if (Path(folder) / recorded).is_dir():
                self.adopt(Path(folder) / recorded, recorded)
        self.write(whole, files[whole])

    def adopt(self, folder: Path, name: str) -> Path:
        """Move a complete folder to its place in the run, and return its path."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        folder.replace(target)
        return target


def _read(path: Path, kind: type[T]) -> T | None:
    """A result; None if it is not there.

    Raises:
        UserError: it is damaged.
    """
    try:
        return json.decode(path.read_bytes(), type=kind)
    except FileNotFoundError:
        return None
    except (OSError, DecodeError) as error:
        said = str(error).split("\n")[0]
        raise UserError(
            f"'{path}' is damaged ({said}). Delete this one file and start the experiment again: only that piece is done "
            "anew, and everything else is kept."
        ) from error


def locked(path: Path) -> IO[str]:
    """Lock a directory for this process; the lock is given back when the process ends, however it ends.

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


def code_key(folders: Iterable[Path]) -> str:
    """Return a hash over all Python source below some folders."""
    digest = hashlib.blake2b(digest_size=16)
    for folder in sorted(set(folders)):
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()
