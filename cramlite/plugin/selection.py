"""Selection of an engine's plugins, from the command line or from an embedding program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..base.value import Value

if TYPE_CHECKING:
    from .registry import Registry


class PluginChoice(Value):
    """Selection of plugins: a plain value that can be sent to any process.

    Args:
        files: plugin modules to load by path.
        blocked: names of plugins that are not loaded, be they installed or in a file.
        preferred: names of plugins that are asked first.
        models: libraries of known kinds that plugins read.
    """

    files: tuple[Path, ...] = ()
    blocked: tuple[str, ...] = ()
    preferred: tuple[str, ...] = ()
    models: tuple[Path, ...] = ()

    @classmethod
    def of(cls, registry: Registry) -> PluginChoice:
        """Return the selection of plugins from which a registry was made."""
        return cls(tuple(registry.files), tuple(registry.blocked), tuple(registry.preferred), registry.models)

    def extended(self, blocked: tuple[str, ...], preferred: tuple[str, ...], models: tuple[Path, ...] = ()) -> PluginChoice:
        """Return this selection extended by further names to block and to prefer, and by further libraries."""
        more = tuple(dict.fromkeys((*self.models, *models)))
        return PluginChoice(self.files, _joined(self.blocked, blocked), _joined(self.preferred, preferred), more)

    def registry(self, *, strict: bool = True) -> Registry:
        """Return a registry of the selected plugins.

        Args:
            strict: a file that cannot be used is refused; False: it is listed with what is wrong.

        Raises:
            UserError: a file or a name that there is not, one that is both blocked and preferred, or, if strict, a file
                that cannot be used.
        """
        from .registry import Registry

        return Registry(self.files, self.blocked, self.preferred, strict, models=self.models)


INSTALLED = PluginChoice()
"""Every plugin that is installed, and no other."""


def _joined(names: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*names, *more)))
