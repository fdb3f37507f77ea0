"""Discovery of plugins: entry points of installed packages, and files that a user names."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import sys
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

from ..base.value import Value
from .validation import NoModule, made_for_another_version

GROUP = "cramlite"
OWN_DISTRIBUTION = "cramlite"


class Point(Value):
    """Entry point of a plugin, with the name and version of its distribution.

    They are kept here because reading them takes long.
    """

    name: str
    value: str
    distribution: str
    version: str
    dist: importlib.metadata.Distribution | None
    load: Callable[[], Any]

    def defines(self, function: str) -> bool:
        """Check whether the source of the plugin's module defines a function, without loading the module."""
        try:
            spec = importlib.util.find_spec(self.value.partition(":")[0])
        except Exception:  # its package breaks when it is imported: nobody can read what its module would define
            return False
        text = Path(spec.origin).read_text(encoding="utf-8") if spec is not None and spec.origin else ""
        return f"\ndef {function}(" in text

    def taken(self) -> str:
        """Return the message for a plugin file that has the name of this installed plugin, which is not allowed."""
        return (
            f"there is a plugin '{self.name}' already, of {self.distribution} {self.version} ({self.value}), and two of one name "
            f"cannot be told apart; rename the file, and if it is to replace that one, add --block {self.name}"
        )

    def outdated(self) -> str:
        """Return why the plugin's distribution is not made for this cramlite version; "" if it is."""
        return "" if self.dist is None or self.distribution == OWN_DISTRIBUTION else made_for_another_version(self.dist)


def entry_points() -> list[Point]:
    """List the entry points of all plugins, those of third parties first.

    They are sorted, because a file system lists distributions in no fixed order.

    They are read again once a folder of ``sys.path`` has changed, as an installation changes it.
    """
    return list(_installed(tuple((folder, _changed_at(folder)) for folder in sys.path)))


def _changed_at(folder: str) -> int:
    """Return the time at which a folder last changed [ns]; 0 if there is no folder."""
    try:
        return os.stat(folder or ".").st_mtime_ns
    except OSError:
        return 0


@lru_cache(maxsize=4)
def _installed(_folders: tuple[tuple[str, int], ...]) -> list[Point]:
    known: dict[int, tuple[str, str]] = {}
    found: dict[tuple[str, str], Point] = {}
    for point in importlib.metadata.entry_points(group=GROUP):
        if id(point.dist) not in known:
            known[id(point.dist)] = (point.dist.name, point.dist.version) if point.dist else ("?", "?")
        name, version = known[id(point.dist)]
        found[(point.name, point.value)] = Point(point.name, point.value, name, version, point.dist, point.load)
    return sorted(found.values(), key=lambda p: (p.distribution == OWN_DISTRIBUTION, p.distribution, p.name))


def plugin_names(files: Iterable[Path] = ()) -> set[str]:
    """Return the names of all installed plugins and of some plugin files."""
    return {p.name for p in entry_points()} | {f.stem for f in files}


def module_from(file: Path) -> ModuleType:
    """Import the module in a file.

    Raises:
        NoModule: by its name it is none.
        Exception: whatever the module raises when it is imported.
    """
    spec = importlib.util.spec_from_file_location(f"cramlite_file_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise NoModule(f"the file is no Python module; a module's name ends in '.py', not in '{file.suffix}'")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
