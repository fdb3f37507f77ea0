"""Lazy import of a package's public names (PEP 562)."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from typing import Any


class LazyNames:
    """Table of a package's public names, each with the module that defines it (PEP 562).

    Args:
        package: whose ``__getattr__`` asks.
        homes: module, relative to the package -> names, separated by blanks.
    """

    def __init__(self, package: str, homes: Mapping[str, str]) -> None:
        self._package = package
        self._home_of = {name: module for module, names in homes.items() for name in names.split()}

    def load(self, name: str) -> Any:
        """Import a name, and keep it in the package so that it is looked up once.

        Raises:
            AttributeError: the package has no such name.
        """
        if name not in self._home_of:
            raise AttributeError(f"module '{self._package}' has no attribute '{name}'")
        found = getattr(importlib.import_module(self._home_of[name], self._package), name)
        setattr(sys.modules[self._package], name, found)
        return found
