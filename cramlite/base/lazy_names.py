"""Lazy import of a package's public names (PEP 562)."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

NONE: Mapping[str, tuple[str, str]] = MappingProxyType({})
"""No deprecated name."""


class LazyNames:
    """Table of a package's public names, each with the module that defines it (PEP 562).

    Args:
        package: whose ``__getattr__`` asks.
        homes: module, relative to the package -> names, separated by blanks.
        deprecated: old name -> the name to use instead, and the version since which the old one warns.
    """

    def __init__(self, package: str, homes: Mapping[str, str], deprecated: Mapping[str, tuple[str, str]] = NONE) -> None:
        self.deprecated = deprecated
        self._package = package
        self._home_of = {name: module for module, names in homes.items() for name in names.split()}

    def load(self, name: str) -> Any:
        """Import a name, and keep it in the package so that it is looked up once.

        Raises:
            AttributeError: the package has no such name.
        """
        if name in self.deprecated:
            return self._instead(name)
        if name not in self._home_of:
            raise AttributeError(f"module '{self._package}' has no attribute '{name}'")
        found = getattr(importlib.import_module(self._home_of[name], self._package), name)
        setattr(sys.modules[self._package], name, found)
        return found

    def _instead(self, old: str) -> Any:
        """Warn of a deprecated name whoever uses it, each time; give what the new name stands for."""
        new, since = self.deprecated[old]
        said = f"{self._package}.{old} is deprecated since cramlite {since}: use {self._package}.{new}"
        warnings.warn(said, DeprecationWarning, stacklevel=4)
        return self.load(new)
