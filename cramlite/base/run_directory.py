"""Run directory: the files of one ``cramlite resolve`` or experiment, and the manifest of its inputs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import UserError

MANIFEST = "manifest.json"


def require_vacant(folder: Path | None, done: str) -> None:
    """Raise UserError where a folder to be written exists and is not empty; None stands for no folder.

    Args:
        done: what then was not done: "run" or "written".
    """
    if folder is not None and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"'{folder}' exists and is not an empty folder; nothing was {done}. Choose another --out.")


class RunDirectory:
    """Folder with the files of one ``cramlite resolve`` or one experiment.

    Args:
        path: created if it does not exist.
        key: what the run depends on; a folder that holds another run is refused.

    Raises:
        UserError: the folder holds something else, or cannot be written.
    """

    def __init__(self, path: Path, key: Mapping[str, Any]) -> None:
        self.path = path
        manifest = path / MANIFEST
        try:
            path.mkdir(parents=True, exist_ok=True)
            known = json.loads(manifest.read_text(encoding="utf-8")) if manifest.is_file() else None
            foreign = not _is_manifest(known) and any(path.iterdir())
        except (OSError, ValueError) as error:
            raise UserError(
                f"The run directory '{path}' cannot be used: {error}. Choose another one with --out."
            ) from error
        if foreign:
            raise UserError(
                f"'{path}' is not empty and is no run directory; nothing was written. Choose another one with --out."
            )
        self.key = dict(key)
        self.complete = bool(known and known.get("complete") and known.get("key") == self.key)
        if known and known.get("key") != self.key:
            changed = [k for k in self.key if known.get("key", {}).get(k) != self.key[k]]
            raise UserError(
                f"'{path}' holds another run (different: {', '.join(changed)}); nothing was written. "
                "Choose another directory with --out, or delete this one."
            )
        self.refused: list[int] = list(known.get("refused", [])) if known else []
        self.spent: dict[str, dict[str, Any]] = dict(known.get("spent", {})) if known else {}
        self._save(complete=self.complete)

    def _save(self, *, complete: bool) -> None:
        self.write(MANIFEST, json.dumps({"key": self.key, "complete": complete, "refused": self.refused, "spent": self.spent}, indent=1))

    def refuse(self, number: int, spent: Mapping[str, Any]) -> None:
        """Record a refused candidate sequence and the work spent on it, so that a resumed run goes on with
        the next one."""
        self.refused = [*(n for n in self.refused if n != number), number]
        self.spent[str(number)] = dict(spent)
        self._save(complete=False)

    def finish(self) -> None:
        """Record that the run is complete."""
        self.complete = True
        self._save(complete=True)

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file of the run atomically."""
        return write_whole(self.path / name, content)


def _is_manifest(known: Any) -> bool:
    return isinstance(known, dict) and isinstance(known.get("key"), dict)


def write_whole(target: Path, content: str | bytes) -> Path:
    """Write a file atomically, through a temporary one, so that an interruption leaves no half of it.

    Raises:
        UserError: it cannot be written.
    """
    temporary = target.with_name(f".{target.name}.part")
    data = content.encode() if isinstance(content, str) else content
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(data)
        temporary.replace(target)
    except OSError as error:
        raise UserError(f"'{target}' cannot be written: {error.strerror}. What was written before is kept.") from error
    return target


def content_key(*paths: Path) -> str:
    """Return a hash over files and folders, by name and content."""
    digest = hashlib.blake2b(digest_size=16)
    for path in paths:
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        for file in files:
            digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def read_json(path: Path, what: str) -> Any:
    """Read a JSON file of a run directory.

    Raises:
        UserError: it is missing or broken.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(
            f"There is no {what} at '{path}'; give a directory that 'cramlite resolve --out' wrote."
        ) from error
    except ValueError as error:
        raise UserError(
            f"'{path}' is not valid JSON ({error}); the run directory is damaged, run 'cramlite resolve' again."
        ) from error
