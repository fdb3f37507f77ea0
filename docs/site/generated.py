"""Pages of the reference that are written from the code when the site is built: Python names, rules of tasks, schemas."""

from __future__ import annotations

import importlib
import inspect
import json
import pkgutil
import re
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import cramlite
import cramlite.model
import cramlite.plugin
import cramlite.testing
from cramlite.model import Value


def on_files(files: Any, config: Any) -> Any:
    """MkDocs asks for further files: the generated pages."""
    from mkdocs.structure.files import File

    for name, make in PAGES.items():
        files.append(File.generated(config, name, content=make()))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """What the tests read in comments is shown: the file that a block is, and the exit code of a command."""
    markdown = re.sub(r"<!-- file: (.*?) -->\n\n?```(\w+)\n", r'```\2 title="\1"\n', markdown)
    markdown = re.sub(
        r"<!-- output -->\n\n?```(\w+)\n", r'```\1 title="prints, among other lines (... is anything)"\n', markdown
    )
    return re.sub(r"<!-- exit: (\d) -->\n\n?```(\w+)\n", r'```\2 title="ends with exit code \1"\n', markdown)


def predicates_page() -> str:
    """Every predicate that rules may ask for, as the installed plugins declare them."""
    from cramlite import Engine

    parts = ["# Predicates", "", "What [rule files](rules.md) may ask for; written from the shipped plugins.", ""]
    parts += ["| predicate | arguments | gives a number | only in | holds when |", "|---|---|---|---|---|"]
    for p in sorted(Engine().knowledge.predicates, key=lambda p: p.name):
        phases = "" if len(p.phases) == 3 else ", ".join(sorted(p.phases))
        parts.append(f"| `{p.name}` | {p.arity} | {'yes' if p.value else ''} | {phases} | {plain(p.doc)} |")
    return "\n".join(parts) + "\n"


def python_page() -> str:
    """Every public name with its signature and docstring."""
    parts = ["# Python names", "", "Everything public, from four modules; written from the code."]
    for module in (cramlite, cramlite.plugin, cramlite.model, cramlite.testing):
        parts += ["", f"## {module.__name__}"]
        for name in module.__all__:
            parts += ["", *described(module, name)]
    return "\n".join(parts) + "\n"


def described(module: ModuleType, name: str) -> list[str]:
    """A heading, the signature, the docstring, and the public methods of a class."""
    value = getattr(module, name)
    if not inspect.isclass(value) and not inspect.isroutine(value):
        said = json.dumps(value) if isinstance(value, str | tuple) else type(value).__name__
        return [f"### {name}", "", f"`{said}`", "", plain(constant_doc(module, name))]
    found = [f"### {name}", "", *signature(name, value), "", plain(inspect.getdoc(value) or "")]
    found += attributes(value)
    for method, function in methods(value):
        found += ["", f"**`{method}{signature_of(function)}`**", "", plain(inspect.getdoc(function) or "")]
    return found


def attributes(value: Any) -> list[str]:
    """Class attributes that a subclass sets, with their defaults and the text under them in the source."""
    hints = vars(value).get("__annotations__", {}) if inspect.isclass(value) else {}
    own = [n for n, h in hints.items() if str(h).startswith("ClassVar")]
    source = inspect.getsource(value) if own else ""
    lines = []
    for name in own:
        doc = re.search(rf'^    {name}: ClassVar[^\n]*\n    """(.*?)"""', source, re.MULTILINE | re.DOTALL)
        said = " ".join(doc[1].split()) if doc else ""
        lines.append(f"- `{name}` = `{getattr(value, name)!r}`{': ' + plain(said) if said else ''}")
    return ["", "**Attributes**", "", *lines] if lines else []


def methods(value: Any) -> list[tuple[str, Any]]:
    """Public methods that a class defines itself and documents."""
    if not inspect.isclass(value):
        return []
    protocol = getattr(value, "_is_protocol", False)
    own = [(n, getattr(f, "__func__", f)) for n, f in vars(value).items() if not n.startswith("_")]
    own = [(n, getattr(f, "fget", f)) for n, f in own]
    return [(n, f) for n, f in own if inspect.isfunction(f) and (protocol or inspect.getdoc(f))]


def signature(name: str, value: Any) -> list[str]:
    if getattr(value, "_is_protocol", False):
        return ["Any object with these members will do."]
    if isinstance(value, type) and issubclass(value, Value):
        lines = [f"    {p.name}: {p.annotation}{default(p)}" for p in inspect.signature(value).parameters.values()]
        return ["```python", f"{name}(", *[line + "," for line in lines], ")", "```"]
    return ["```python", f"{name}{signature_of(value)}", "```"]


LONGEST = 60
"""Characters of a default that is written out."""


def default(parameter: inspect.Parameter) -> str:
    if parameter.default is inspect.Parameter.empty:
        return ""
    made = callable(parameter.default) or "Factory" in type(parameter.default).__name__
    return " = ..." if made else f" = {parameter.default!r}"


def signature_of(value: Any) -> str:
    try:
        said = inspect.signature(value)
        short = [p.replace(default=...) if len(repr(p.default)) > LONGEST else p for p in said.parameters.values()]
        plain_types = re.sub(r"(: |-> )'([^']+)'", r"\1\2", str(said.replace(parameters=short)))
        return re.sub(r" at 0x\w+", "", plain_types).replace("Ellipsis", "...")
    except (TypeError, ValueError):
        return "(...)"


def constant_doc(module: ModuleType, name: str) -> str:
    """The text under a constant or an alias of a type, in the source of the module that defines it."""
    homes = {n: home for home, names in vars(module).get("_HOMES", {}).items() for n in names.split()}
    known = [importlib.import_module(homes[name], module.__name__)] if name in homes else list(parts_of(module))
    for source in map(inspect.getsource, known):
        found = re.search(rf'^{name}(?:: [^\n=]+)? = (?:(?!\n\n).)*?\n"""(.*?)"""', source, re.MULTILINE | re.DOTALL)
        if found:
            return " ".join(found[1].split())
    return ""


def parts_of(module: ModuleType) -> Iterator[ModuleType]:
    """The modules of a package."""
    for part in pkgutil.iter_modules(getattr(module, "__path__", ())):
        yield importlib.import_module(f"{module.__name__}.{part.name}")


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
    from cramlite.scenario.schema import SCHEMAS

    parts = ["# JSON Schemas", "", "`cramlite schema KIND` prints them for editors; see [commands](cli.md#schema)."]
    for kind, make in SCHEMAS.items():
        parts += ["", f"## {kind}", "", "```json", json.dumps(make(), indent=1), "```"]
    return "\n".join(parts) + "\n"


def errors_page() -> str:
    """The errors that reach a person, each with its exit code."""
    from cramlite.base import errors

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
    "reference/predicates.md": predicates_page,
    "reference/python.md": python_page,
    "reference/schema.md": schema_page,
}
