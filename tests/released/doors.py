"""The four doors as lists: what a release offered, so that the next one is compared with it.

    python tests/released/doors.py                 # how the doors differ from the last released list
    python tests/released/doors.py --write 0.1.0   # at a release: store the list
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

DOORS = ("cramlite", "cramlite.plugin", "cramlite.model", "cramlite.testing")
HERE = Path(__file__).parent
List = Mapping[str, Mapping[str, Any]]
"""Door -> name -> what is promised of it."""


def doors() -> dict[str, dict[str, Any]]:
    """What the doors offer now, deprecated names included."""
    modules = {door: importlib.import_module(door) for door in DOORS}
    with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
        return {door: {name: promised(getattr(module, name)) for name in names(module)} for door, module in modules.items()}


def names(module: ModuleType) -> list[str]:
    """The names that a door offers, old ones included."""
    lazy = getattr(module, "_NAMES", None)
    return sorted({*module.__all__, *(lazy.deprecated if lazy is not None else ())})


def promised(value: Any) -> dict[str, list[str]]:
    """The parameters of a function; those of a class, with its public members; nothing of a constant."""
    if inspect.isclass(value):
        members = sorted(n for n in dir(value) if not n.startswith("_") and not hasattr(Exception, n))
        return {**parameters(value), "members": members}
    return parameters(value) if callable(value) else {}


def parameters(value: Any) -> dict[str, list[str]]:
    """Names of parameters: positional ones in their order, those by keyword only, and those that must be given."""
    try:
        found = [p for p in inspect.signature(value).parameters.values() if not p.name.startswith("_")]
    except (TypeError, ValueError):
        return {}
    return {
        "positional": [p.name for p in found if p.kind <= p.POSITIONAL_OR_KEYWORD],
        "by_keyword": sorted(p.name for p in found if p.kind == p.KEYWORD_ONLY),
        "required": sorted(p.name for p in found if p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)),
    }


def as_text(offered: List) -> str:
    """A list as JSON with one line for each name."""
    parts = []
    for door, promises in offered.items():
        lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(said)}" for name, said in promises.items())
        parts.append(f" {json.dumps(door)}: {{\n{lines}\n }}")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def last_released() -> Path:
    """The list of the highest version."""
    return max(HERE.glob("*.json"), key=lambda p: tuple(map(int, re.findall(r"\d+", p.stem))))


def broken(before: List, now: List) -> Iterator[str]:
    """What somebody who built upon the earlier doors would miss; more names, members and optional parameters break nothing."""
    for door, promises in before.items():
        for name, promise in promises.items():
            if name not in now.get(door, {}):
                yield f"{door}.{name} is gone"
            else:
                yield from (f"{door}.{name}: {said}" for said in _changed(promise, now[door][name]))


def _changed(before: Mapping[str, list[str]], now: Mapping[str, list[str]]) -> Iterator[str]:
    taken = {*now.get("positional", ()), *now.get("by_keyword", ())}
    positional = before.get("positional", [])
    yield from (f"parameter '{n}' is gone" for n in (*positional, *before.get("by_keyword", ())) if n not in taken)
    yield from (f"parameter '{n}' must be given" for n in now.get("required", ()) if n not in before.get("required", ()))
    if now.get("positional", [])[: len(positional)] != positional and taken.issuperset(positional):
        yield "positional parameters stand in another order"
    yield from (f"'{n}' is gone" for n in before.get("members", ()) if n not in now.get("members", ()))


def main() -> None:
    """Compare, or store."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--write", metavar="VERSION")
    version = options.parse_args().write
    if version:
        (HERE / f"{version}.json").write_text(as_text(doors()), encoding="utf-8")
        return
    print("\n".join(broken(json.loads(last_released().read_text(encoding="utf-8")), doors())) or "nothing is lost")


if __name__ == "__main__":
    main()
