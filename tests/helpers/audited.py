"""What Python's own audit events (PEP 578) say that a piece of code did: files opened, imports, processes, sockets, code compiled."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

OUTSIDE = ("ctypes.", "exec", "compile", "import", "marshal.", "open", "os.", "pickle.", "shutil.", "socket.", "subprocess.", "urllib.")
"""Prefixes of audit events by which code reaches files, imports, processes or the network."""
_listening: list[list[tuple[str, Any]]] = []


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    for heard in _listening:
        heard.append((event, arguments[:1]))


@contextmanager
def audited() -> Iterator[list[tuple[str, Any]]]:
    """Collect the audit events of a ``with`` block: their names, and the first argument of each."""
    if not hasattr(sys, "_cramlite_audited"):  # a hook cannot be taken away again
        sys._cramlite_audited = True  # type: ignore[attr-defined]
        sys.addaudithook(_hook)
    heard: list[tuple[str, Any]] = []
    _listening.append(heard)
    try:
        yield heard
    finally:
        _listening.remove(heard)


def beyond(heard: list[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Return the audit events by which code reached files, imports, processes or the network."""
    return [e for e in heard if e[0].startswith(OUTSIDE)]
