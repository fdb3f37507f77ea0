"""Pages of the reference that are written from the code when the site is built: Python names, rules of tasks,
schemas; and the page of measured numbers."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import re
from collections.abc import Callable, Iterator
from functools import cached_property, partial
from itertools import pairwise
from types import FunctionType, ModuleType
from typing import Any, get_args

import figures  # beside this file, where MkDocs looks while it loads a hook
import tables

import cramlite
import cramlite.model
import cramlite.plugin
import cramlite.testing
from cramlite.model import Value

DOORS = (cramlite, cramlite.plugin, cramlite.model, cramlite.testing)
"""The public modules, in the order of the page of Python names."""


def on_files(files: Any, config: Any) -> Any:
    """Add the generated pages and plots to the files of the site; a hook of MkDocs."""
    from mkdocs.structure.files import File

    for name, make in PAGES.items():
        files.append(File.generated(config, name, content=make()))
    for name, svg in figures.plots():
        files.append(File.generated(config, name, content=svg))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Fill in the tables that are made from code or from files of measured numbers.

    Comments for tests (names of files, exit codes) become titles of blocks.
    """
    markdown = tables.filled(markdown)
    if page.file.src_uri == figures.PAGE:
        markdown = figures.shown(markdown)
    markdown = re.sub(r"<!-- file: (.*?) -->\n\n?```(\w+)\n", r'```\2 title="\1"\n', markdown)
    markdown = re.sub(
        r"<!-- output -->\n\n?```(\w+)\n", r'```\1 title="prints, among other lines (... is anything)"\n', markdown
    )
    return re.sub(r"<!-- exit: (\d) -->\n\n?```(\w+)\n", r'```\2 title="ends with exit code \1"\n', markdown)


def predicates_page() -> str:
    """Return the page of all predicates that rules may use, as the installed plugins declare them."""
    from cramlite import Engine

    parts = ["# Predicates", "", "What [rule files](rules.md) may ask for; written from the shipped plugins.", ""]
    parts += ["| predicate | arguments | gives a number | only in | holds when |", "|---|---|---|---|---|"]
    for p in sorted(Engine().knowledge.predicates, key=lambda p: p.name):
        phases = "" if len(p.phases) == 3 else ", ".join(sorted(p.phases))
        parts.append(f"| `{p.name}` | {p.arity} | {'yes' if p.value else ''} | {phases} | {plain(p.doc)} |")
    return "\n".join(parts) + "\n"


def locations_page() -> str:
    """Return the page of all relations of locations, as the installed plugins declare them."""
    from cramlite import Engine

    parts = ["# Locations", "", "Relations that [motions](motions.md#where-motions-lead) lead to; written from the shipped plugins.", ""]
    parts += ["| relation | of | parameters | place |", "|---|---|---|---|"]
    kinds = sorted(Engine().knowledge.location_kinds.values(), key=lambda k: k.name)
    for kind in kinds:
        named = ", ".join(f"`{name}`" for name in kind.explained)
        parts.append(f"| `{kind.name}` | {kind.of} | {named} | {plain(kind.summary)} |")
    for parameters in dict.fromkeys(k.parameters for k in kinds):
        taking = [k for k in kinds if k.parameters is parameters]
        if explained := taking[0].explained:
            parts += ["", f"## {', '.join(k.name for k in taking)}", "", "| parameter | type | default | meaning |", "|---|---|---|---|"]
            parts += [f"| `{name}` | {type_} | {given} | {plain(explained[name])} |" for name, type_, given in fields_of(parameters)]
    return "\n".join(parts) + "\n"


def fields_of(kind: type[Value]) -> list[tuple[str, str, str]]:
    """Return name, type and default of each field of a value class."""
    found = inspect.signature(kind).parameters.values()
    return [
        (p.name, f"`{p.annotation}`".replace("|", "\\|"), "" if p.default is p.empty else f"`{p.default!r}`") for p in found
    ]


QUIET = "---\nsearch:\n  boost: 0.3\n---\n\n"
"""Front matter that ranks a generated page below hand-written pages in the site's search."""


def python_page() -> str:
    """Return the index of public names: each with the first sentence of its docstring and a link to its module's page."""
    parts = [f"{QUIET}# Python names", "", "Everything public, written from the code. Each door has a page:", ""]
    parts += [f"- [`{m.__name__}`]({door(m)}): {plain((inspect.getdoc(m) or '').split(chr(10))[0])}" for m in DOORS]
    parts += ["", "| name | from | what it is |", "|---|---|---|"]
    for module, name in sorted(public_names(), key=lambda pair: pair[1].lower()):
        value = getattr(module, name)
        doc = constant_doc(module, name) if is_constant(value) else inspect.getdoc(value) or ""
        first = re.split(r"(?<=[.:]) |\n\n", " ".join(doc.split("\n\n")[0].split()))[0]
        parts.append(f"| [`{name}`]({door(module)}#{name.lower()}) | `{module.__name__}` | {plain(first)} |".replace(" | None", ""))
    return "\n".join(parts) + "\n"


def door(module: ModuleType) -> str:
    """Return the path of a public module's page, relative to the index."""
    return f"python/{module.__name__.rpartition('.')[2]}.md"


def door_page(module: ModuleType) -> str:
    """Return the page of a public module: every name with its signature and docstring."""
    parts = [f"{QUIET}# {module.__name__}", "", plain(inspect.getdoc(module) or "")]
    also = [n for n in module.__all__ if (module, n) not in public_names()]
    if also:
        parts += ["", f"Also here, described elsewhere: {', '.join(f'`{n}`' for n in also)}."]
    for _, name in (pair for pair in public_names() if pair[0] is module):
        parts += ["", *described(module, name)]
    return re.sub("(?m)^### ", "## ", "\n".join(parts)) + "\n"


def public_names() -> list[tuple[ModuleType, str]]:
    """Return every public name with the first public module that has it; equal names of different things are kept apart."""
    first = {(name, id(getattr(module, name))): module for module in reversed(DOORS) for name in module.__all__}
    found = [(module, name) for module in DOORS for name in module.__all__]
    return [(module, name) for module, name in found if first[name, id(getattr(module, name))] is module]


def described(module: ModuleType, name: str) -> list[str]:
    """Return the description of a public name: heading, signature, docstring, and the public methods of a class."""
    value = getattr(module, name)
    if is_constant(value):
        return [f"### {name}", "", f"`{constant_text(value)}`", "", plain(constant_doc(module, name))]
    found = [f"### {name}", "", *signature(name, value), "", plain(inspect.getdoc(value) or "")]
    found += attributes(value)
    for property_, function in members(value, PROPERTIES):
        found += ["", f"**`{property_}: {returned(function)}`** (property)", "", plain(inspect.getdoc(function) or "")]
    for method, function in members(value, METHODS):
        found += ["", f"**`{method}{signature_of(function)}`**", "", plain(inspect.getdoc(function) or "")]
    return found


def attributes(value: Any) -> list[str]:
    """Return the class attributes that a subclass sets, with their defaults and the strings under them in the source."""
    hints = vars(value).get("__annotations__", {}) if inspect.isclass(value) else {}
    own = [n for n, h in hints.items() if str(h).startswith("ClassVar")]
    source = inspect.getsource(value) if own else ""
    lines = []
    for name in own:
        doc = re.search(rf'^    {name}: ClassVar[^\n]*\n    """(.*?)"""', source, re.MULTILINE | re.DOTALL)
        said = " ".join(doc[1].split()) if doc else ""
        lines.append(f"- `{name}` = `{getattr(value, name)!r}`{': ' + plain(said) if said else ''}")
    return ["", "**Attributes**", "", *lines] if lines else []


PROPERTIES, METHODS = (property, cached_property), (FunctionType, classmethod, staticmethod)


def members(value: Any, kinds: tuple[type, ...]) -> list[tuple[str, Any]]:
    """Return the documented public methods, or properties, that a class defines itself, each with its function."""
    if not inspect.isclass(value):
        return []
    protocol = getattr(value, "_is_protocol", False)
    own = [(n, member) for n, member in vars(value).items() if not n.startswith("_") and isinstance(member, kinds)]
    found = [(n, getattr(m, "fget", getattr(m, "func", getattr(m, "__func__", m)))) for n, m in own]
    return [(n, f) for n, f in found if protocol or inspect.getdoc(f)]


def returned(function: Any) -> str:
    """Return the type of a property, as text."""
    return str(inspect.signature(function).return_annotation).strip("'")


def signature(name: str, value: Any) -> list[str]:
    if getattr(value, "_is_protocol", False):
        return ["Any object with these members will do."]
    if isinstance(value, type) and issubclass(value, Value):
        lines = [f"    {p.name}: {p.annotation}{default(p)}" for p in inspect.signature(value).parameters.values()]
        return ["```python", f"{name}(", *[line + "," for line in lines], ")", "```"]
    return ["```python", f"{name}{signature_of(value)}", "```"]


LONGEST = 60
"""Largest length of a default value that a signature shows in full [characters]."""


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


def is_constant(value: Any) -> bool:
    """Check whether a public name stands for a constant or a type alias, and not for a class or function."""
    return not isinstance(value, type) and not inspect.isfunction(value)


def constant_text(value: Any) -> str:
    """Return a constant as JSON, a type alias as it is written, any other value by its class."""
    if isinstance(value, str | int | float | tuple):
        return json.dumps(value)
    if hasattr(value, "__metadata__"):  # of ``Annotated``, the type alone
        return str(value.__origin__.__name__)
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", str(value)) if get_args(value) else type(value).__name__


def constant_doc(module: ModuleType, name: str) -> str:
    """Return the text that explains a constant: the string below it in the module that defines it."""
    return next((doc for source in sources(module, name) for doc in texts_under(source, name)), "")


def sources(module: ModuleType, name: str) -> Iterator[str]:
    """Give the source of the module that defines a public name; if that is unknown, of the public module and all submodules."""
    lazy = getattr(module, "_NAMES", None)
    home = lazy.homes.get(name) if lazy is not None else None
    found = [importlib.import_module(home, module.__name__)] if home else []
    for defining in found or [module, *(m for m in vars(module).values() if inspect.ismodule(m))]:
        yield inspect.getsource(defining)


def texts_under(source: str, name: str) -> Iterator[str]:
    """Yield the strings right below assignments to a name in Python source; such a string documents the name."""
    body = ast.parse(source).body
    for statement, below in pairwise(body):
        targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
        names = {n.id for target in targets if target is not None for n in ast.walk(target) if isinstance(n, ast.Name)}
        text = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) and below.value.value
        if name in names and isinstance(text, str):
            yield inspect.cleandoc(text)


def plain(text: str) -> str:
    """Return a docstring as Markdown: its sections as bold words, their entries as a list."""
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
    """Return the page of the JSON Schemas that ``cramlite schema`` prints."""
    from cramlite.scenario.schema import SCHEMAS

    parts = ["# JSON Schemas", "", "`cramlite schema KIND` prints them for editors; see [commands](cli/resolve.md#schema)."]
    for kind, make in SCHEMAS.items():
        parts += ["", f"## {kind}", "", "```json", json.dumps(make(), indent=1), "```"]
    return "\n".join(parts) + "\n"


def errors_page() -> str:
    """Return the page of the errors that reach a person, each with its exit code."""
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
        *described(cramlite, "Unresolvable"),
    ]
    return "\n".join(parts) + "\n"


PAGES: dict[str, Callable[[], str]] = {
    "reference/errors.md": errors_page,
    "reference/locations.md": locations_page,
    "reference/predicates.md": predicates_page,
    "reference/python.md": python_page,
    **{f"reference/{door(module)}": partial(door_page, module) for module in DOORS},
    "reference/schema.md": schema_page,
}
