"""JSON lines of a benchmark's process: it reads requests, one JSON object a line, and answers each with one line.

The benchmarks' scripts beside this file share it. They run in environments of their own, so nothing of cramlite is imported here.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

REQUESTS = ("reset", "hello", "scene", "look", "step", "check", "cameras")


class Refused(Exception):
    """A request that cannot be served; the message is for people."""


def answer(simulator: Any, ask: dict[str, Any]) -> dict[str, Any]:
    """Call the simulator's method that a request names; all but ``reset`` need a running episode (``env``).

    Raises:
        Refused: there is no such request, or no episode yet.
    """
    name = ask.pop("ask", None)
    if name not in REQUESTS:
        raise Refused(f"there is no request '{name}'")
    if name != "reset" and simulator.env is None:
        raise Refused(f"'{name}' needs an episode; 'reset' begins one")
    said: dict[str, Any] = getattr(simulator, name)(**ask)
    return said


def serve(simulator: Any) -> None:
    """Answer requests until the input ends, or ``end`` is asked; the output of simulators goes to standard
    error."""
    lines = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        try:
            ask = json.loads(line)
            if ask.get("ask") == "end":
                return
            said = answer(simulator, ask)
        except Refused as refused:
            said = {"error": str(refused)}
        except (ValueError, TypeError, AttributeError) as error:
            said = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(said), file=lines, flush=True)
