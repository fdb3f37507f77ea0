"""Plugins that a source tree declares and its installation does not know, since that was made before they were declared."""

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
    """Plugin that its distribution declares in its project file, but not in its installed metadata."""

    name: str
    distribution: str
    version: str
    file: Path

    @property
    def reason(self) -> str:
        """Sentence on why the plugin is not loaded, and on the remedy."""
        return (
            f"'{self.file}' declares it, and what is installed of {self.distribution} was made before that and does not; "
            f"install it again: pip install -e {self.file.parent}"
        )


def unknown_plugins() -> Iterator[Unknown]:
    """Yield the plugins that editable installations do not know, since one copies its entry points only when it is installed."""
    for dist in importlib.metadata.distributions():
        project = _project(dist)
        if project is None:
            continue
        installed = {(p.name, p.value) for p in dist.entry_points if p.group == GROUP}
        for name, value in sorted(_declared(project, dist.name).items()):
            if (name, value) not in installed:
                yield Unknown(name, dist.name, dist.version, project)


def _project(dist: importlib.metadata.Distribution) -> Path | None:
    """The project file of a distribution whose source tree is used as it is; None for any other."""
    try:
        origin = json.loads(dist.read_text("direct_url.json") or "{}")
        url = urlsplit(origin["url"])
        editable = origin["dir_info"]["editable"] is True
    except (ValueError, TypeError, LookupError):  # no such file, or one that is not what pip writes
        return None
    return Path(url2pathname(url.path)) / "pyproject.toml" if editable and url.scheme == "file" else None


def _declared(project: Path, distribution: str) -> dict[str, str]:
    """Entry points of plugins in a project file; none where it cannot be read or is of another distribution."""
    try:
        said = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
        found = said["entry-points"][GROUP] if said["name"] == distribution else {}
    except (OSError, ValueError, TypeError, LookupError):  # no tree any more, or what it declares is elsewhere
        return {}
    return found if isinstance(found, dict) else {}
