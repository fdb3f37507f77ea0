"""Which plugins an engine has, as the command line or an embedder chooses them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError, nearest
from ..base.value import Value

if TYPE_CHECKING:
    from ..engine.engine import Engine
    from ..scenario.scenario import Scenario
    from .registry import Registry



class PluginChoice(Value):
    """A choice among plugins; a plain value that any process can be given.

    Args:
        files: plugin modules to load by path.
        blocked: names of plugins that are not loaded, be they installed or in a file.
        preferred: names of plugins that are asked first.
    """

    files: tuple[Path, ...] = ()
    blocked: tuple[str, ...] = ()
    preferred: tuple[str, ...] = ()

    def but(self, blocked: tuple[str, ...], preferred: tuple[str, ...]) -> PluginChoice:
        """This choice, and those of the names that it does not have yet."""
        return PluginChoice(self.files, _joined(self.blocked, blocked), _joined(self.preferred, preferred))

    def asked_by(self, scenario: Scenario) -> PluginChoice:
        """This choice, and what a scenario blocks and prefers.

        Raises:
            UserError: it names a plugin that there is not; with file and line.
        """
        from .entry_points import plugin_names

        block, prefer = scenario.spec.block, scenario.spec.prefer
        known = plugin_names(self.files) if block or prefer else set()
        for key, names in (("block", block), ("prefer", prefer)):
            for k, name in enumerate(names):
                if name not in known:
                    raise UserError(
                        f"{scenario.where(key, k)}: there is no plugin '{name}' to {key}; {nearest(name, known)}."
                    )
        return self.but(block, prefer)

    def registry(self, *, strict: bool = True) -> Registry:
        """A registry of these plugins.

        Args:
            strict: a file that cannot be used is refused; False: it is listed with what is wrong.

        Raises:
            UserError: a file or a name that there is not, one that is both blocked and preferred, or, if strict, a file
                that cannot be used.
        """
        from .registry import Registry

        return Registry(self.files, self.blocked, self.preferred, strict)

    def engine(self, ontologies: tuple[Path, ...] = (), rules: Path | None = None) -> Engine:
        """An engine with these plugins; its arguments are those of `Engine`.

        Raises:
            UserError: as `registry`.
        """
        from ..engine.engine import Engine

        return Engine(
            files=self.files, blocked=self.blocked, preferred=self.preferred, ontologies=ontologies, rules=rules
        )


INSTALLED = PluginChoice()
"""Every plugin that is installed, and no other."""


def _joined(names: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*names, *more)))
