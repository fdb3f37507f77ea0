"""Lazy import of a package's public names (PEP 562)."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any

NONE: Mapping[str, tuple[str, str]] = MappingProxyType({})
"""Empty table of deprecated names, the default of ``LazyNames``."""


class LazyNames:
    """Table of a package's public names, each with the module that defines it (PEP 562).

    The package writes each name once, where type checkers read it: ``from .module import Name as Name`` under
    ``if TYPE_CHECKING``. Its source is read when a name is first asked for.

    Args:
        package: whose ``__getattr__`` and ``__dir__`` ask.
        deprecated: old name -> the name to use instead, and the version since which the old one warns.
    """

    def __init__(self, package: str, deprecated: Mapping[str, tuple[str, str]] = NONE) -> None:
        self.deprecated = deprecated
        self._package = package

    @cached_property
    def homes(self) -> Mapping[str, str]:
        """Dictionary from each public name to the module of the package that defines it, as a relative import."""
        import ast
        import linecache

        module = sys.modules[self._package]
        source = "".join(linecache.getlines(module.__file__ or "", vars(module)))  # pytest's loader of an installed plugin gives none
        imports = [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.ImportFrom)]
        return {a.name: "." * n.level + (n.module or "") for n in imports for a in n.names if a.asname == a.name}

    def known(self) -> list[str]:
        """Return the names for ``dir()`` of the package: public ones, and those already loaded."""
        return sorted({*vars(sys.modules[self._package]), *self.homes})

    def load(self, name: str) -> Any:
        """Import a public name and store it in the package, so that it is looked up once.

        The name "__all__" stands for the list of all public names.

        Raises:
            AttributeError: the package has no such name.
        """
        if name in self.deprecated:
            return self._instead(name)
        if name == "__all__":
            return sorted(self.homes)
        if name.startswith("__") or name not in self.homes:
            raise AttributeError(f"module '{self._package}' has no attribute '{name}'")
        found = getattr(importlib.import_module(self.homes[name], self._package), name)
        setattr(sys.modules[self._package], name, found)
        return found

    def _instead(self, old: str) -> Any:
        """Warn of a deprecated name each time it is used; return the object of the new name."""
        new, since = self.deprecated[old]
        said = f"{self._package}.{old} is deprecated since cramlite {since}: use {self._package}.{new}"
        warnings.warn(said, DeprecationWarning, stacklevel=3)
        return self.load(new)
