"""Plugins that a source tree declares but its installation does not list, because it was installed before they were declared."""

from __future__ import annotations

import importlib.metadata
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from ..base.value import Value
from .entry_points import GROUP


class Unknown(Value):
    """Plugin that its distribution's project file declares, but its installed metadata does not."""

    name: str
    distribution: str
    version: str
    file: Path

    @property
    def reason(self) -> str:
        """Sentence on why the plugin is not loaded, with the remedy."""
        return (
            f"'{self.file}' declares this plugin, but {self.distribution} was installed before that and does not list it; "
            f"install it again: pip install -e {self.file.parent}"
        )


def unknown_plugins() -> Iterator[Unknown]:
    """Yield the plugins that editable installations do not list, since entry points are copied only at
    installation."""
    for dist in importlib.metadata.distributions():
        project = _project(dist)
        if project is None:
            continue
        installed = {(p.name, p.value) for p in dist.entry_points if p.group == GROUP}
        for name, value in sorted(_declared(project, dist.name).items()):
            if (name, value) not in installed:
                yield Unknown(name, dist.name, dist.version, project)


def _project(dist: importlib.metadata.Distribution) -> Path | None:
    """Return the project file of an editable installation; None for any other distribution."""
    try:
        origin = json.loads(dist.read_text("direct_url.json") or "{}")
        url = urlsplit(origin["url"])
        editable = origin["dir_info"]["editable"] is True
    except (ValueError, TypeError, LookupError):  # no such file, or one that is not what pip writes
        return None
    return Path(url2pathname(url.path)) / "pyproject.toml" if editable and url.scheme == "file" else None


def _declared(project: Path, distribution: str) -> dict[str, str]:
    """Return the entry points of plugins in a project file; empty if the file cannot be read or is of another
    distribution."""
    try:
        said = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
        found = said["entry-points"][GROUP] if said["name"] == distribution else {}
    except (OSError, ValueError, TypeError, LookupError):  # no tree any more, or what it declares is elsewhere
        return {}
    return found if isinstance(found, dict) else {}
