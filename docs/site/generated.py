"""Pages of the reference that are written from the code when the site is built: Python names, rules of tasks, schemas."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import json
import re
from collections.abc import Callable
from typing import Any

import cramlite
import cramlite.testing


def on_files(files: Any, config: Any) -> Any:
    """MkDocs asks for further files: the generated pages."""
    from mkdocs.structure.files import File

    for name, make in PAGES.items():
        files.append(File.generated(config, name, content=make()))
    return files


def python_page() -> str:
    """Every public name with its signature and docstring."""
    parts = ["# Python names", "", "Everything public, from `cramlite` and `cramlite.testing`; written from the code."]
    for module in (cramlite, cramlite.testing):
        parts += ["", f"## {module.__name__}"]
        for name in module.__all__:
            parts += ["", *described(name, getattr(module, name))]
    return "\n".join(parts) + "\n"


def described(name: str, value: Any) -> list[str]:
    """A heading, the signature, the docstring, and the public methods of a class."""
    if not callable(value):
        said = json.dumps(value) if isinstance(value, str | tuple) else type(value).__name__
        return [f"### {name}", "", f"`{said}`", "", plain(constant_doc(name))]
    found = [f"### {name}", "", *signature(name, value), "", plain(inspect.getdoc(value) or "")]
    for method, function in methods(value):
        found += ["", f"**`{method}{signature_of(function)}`**", "", plain(inspect.getdoc(function) or "")]
    return found


def methods(value: Any) -> list[tuple[str, Any]]:
    """Public methods that a class defines itself and documents."""
    if not inspect.isclass(value):
        return []
    own = [(n, getattr(f, "__func__", f)) for n, f in vars(value).items() if not n.startswith("_")]
    return [(n, f) for n, f in own if inspect.isfunction(f) and inspect.getdoc(f)]


def signature(name: str, value: Any) -> list[str]:
    if dataclasses.is_dataclass(value):
        lines = [f"    {f.name}: {f.type}{default(f)}" for f in dataclasses.fields(value)]
        return ["```python", f"{name}(", *[line + "," for line in lines], ")", "```"]
    return ["```python", f"{name}{signature_of(value)}", "```"]


def default(field: Any) -> str:
    if field.default is not dataclasses.MISSING:
        return f" = {field.default!r}" if not callable(field.default) else " = ..."
    return "" if field.default_factory is dataclasses.MISSING else " = ..."


def signature_of(value: Any) -> str:
    try:
        return re.sub(r" at 0x\w+", "", str(inspect.signature(value)).replace("'", ""))
    except (TypeError, ValueError):
        return "(...)"


def constant_doc(name: str) -> str:
    """The text under a constant."""
    for module in ("errors", "testing"):
        source = inspect.getsource(importlib.import_module(f"cramlite.{module}"))
        if found := re.search(rf'^{name} = .*?"""(.*?)"""', source, re.MULTILINE | re.DOTALL):
            return found[1]
    return ""


def plain(text: str) -> str:
    """A docstring as Markdown: its sections as bold words, their entries as a list."""
    lines = []
    for line in text.splitlines():
        if re.fullmatch(r"(Args|Returns|Raises|Example):", line):
            lines += ["", f"**{line[:-1]}**", ""]
        elif entry := re.match(r"    (\w[\w, *]*): (.*)", line):
            lines.append(f"- `{entry[1]}`: {entry[2]}")
        else:
            lines.append(line.strip() if line.startswith("    ") and not line.strip().startswith(">>>") else line)
    return "\n".join(lines).replace("``", "`").replace("<", "&lt;")


def schema_page() -> str:
    """The JSON Schemas as ``cramlite schema`` prints them."""
    from cramlite.schema import SCHEMAS

    parts = ["# JSON Schemas", "", "`cramlite schema KIND` prints them for editors; see [commands](cli.md#schema)."]
    for kind, make in SCHEMAS.items():
        parts += ["", f"## {kind}", "", "```json", json.dumps(make(), indent=1), "```"]
    return "\n".join(parts) + "\n"


def errors_page() -> str:
    """The errors that reach a person, each with its exit code."""
    from cramlite import errors

    parts = [
        "# Errors", "", "An error is for a person: where, what, what would be right, what next. A traceback is a defect.", "",
        "| error | exit code | meaning |", "|---|---|---|",
    ]  # fmt: skip
    for error in (errors.NoSolution, errors.UserError, errors.PluginError):
        parts.append(f"| `{error.__name__}` | {error.exit_code} | {inspect.getdoc(error)} |")
    parts += [
        "",
        "All are `CramliteError`. A plugin says that something is impossible with",
        "",
        *described("Unresolvable", errors.Unresolvable),
    ]
    return "\n".join(parts) + "\n"


PAGES: dict[str, Callable[[], str]] = {
    "reference/errors.md": errors_page,
    "reference/python.md": python_page,
    "reference/schema.md": schema_page,
}
