"""Every public name is documented, and is on the page of Python names that the site has."""

from __future__ import annotations

import importlib.util
import inspect
import re
from types import ModuleType
from typing import Any

import pytest
from conftest import ROOT
from pydantic import BaseModel

from cramlite.model import Value
from cramlite.plugin import hookspecs


def _generated() -> ModuleType:
    spec = importlib.util.spec_from_file_location("generated", ROOT / "docs" / "site" / "generated.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "docs" / "site"))  # as MkDocs does while it loads a hook
        spec.loader.exec_module(module)
    return module


GENERATED = _generated()
NAMES: list[tuple[ModuleType, str]] = GENERATED.public_names()


def _fields(value: type) -> tuple[str, ...]:
    """The public fields of a value or of a specification."""
    if issubclass(value, BaseModel):
        return tuple(value.model_fields)
    return tuple(f for f in value.__struct_fields__ if f[0] != "_") if issubclass(value, Value) else ()


def _undocumented(value: Any) -> list[str]:
    """Names without a docstring of their own: the class or function, or a public method, field or property that it defines."""
    found = [] if _own_doc(value) else [value.__name__]
    if not inspect.isclass(value):
        return found
    said = " ".join(_own_doc(c) for c in value.__mro__ if c not in (*Value.__mro__, *BaseModel.__mro__))
    for name in _fields(value):
        if not re.search(rf"\b{name}\b", said):
            found.append(f"field {name}")
    return found


@pytest.mark.parametrize(("module", "name"), NAMES, ids=[n for _, n in NAMES])
def test_no_field_is_documented_that_there_is_not(module: ModuleType, name: str) -> None:
    value = getattr(module, name)
    if inspect.isclass(value) and issubclass(value, Value | BaseModel):
        listed = re.search(r"^Args:\n((?:    .*\n?)+)", inspect.getdoc(value) or "", re.MULTILINE)
        lines = re.findall(r"^    ([a-z_]+(?:, [a-z_]+)*): ", listed[1] if listed else "", re.MULTILINE)
        said = {name for line in lines for name in line.split(", ")}
        assert said <= set(_fields(value))


def _own_doc(value: Any) -> str:
    """A docstring that a person wrote, and no base class's."""
    return (vars(value).get("__doc__") if inspect.isclass(value) else inspect.getdoc(value)) or ""


@pytest.mark.parametrize(("module", "name"), NAMES, ids=[n for _, n in NAMES])
def test_every_public_name_is_documented(module: ModuleType, name: str) -> None:
    value = getattr(module, name)
    if GENERATED.is_constant(value):
        assert GENERATED.constant_doc(module, name)
    else:
        assert _undocumented(value) == []


def test_what_is_not_documented_is_seen() -> None:
    class Bare(Value):
        size: float

    class Spec(BaseModel):
        """Something with a name."""

        name: str
        size: float

    assert _undocumented(Bare) == ["Bare", "field size"]
    assert _undocumented(Spec) == ["field size"]


@pytest.mark.parametrize("hook", [n for n, f in vars(hookspecs).items() if hasattr(f, "cramlite_spec")])
def test_every_hook_is_documented(hook: str) -> None:
    assert len(inspect.getdoc(getattr(hookspecs, hook)) or "") > 40


def test_the_page_of_python_names_has_all() -> None:
    page = "\n".join(GENERATED.door_page(door) for door in GENERATED.DOORS)
    heads = re.findall(r"^## (\w+)$", page, re.MULTILINE)
    assert heads == [n for _, n in NAMES]
    listed = re.findall(r"^\| \[`(\w+)`\]", GENERATED.python_page(), re.MULTILINE)
    assert sorted(listed) == sorted(heads)
    assert "- `places` = `False`: True for tasks that choose where to put something" in page  # each with its own text
    assert 'sample_robot(backend: str = \'\')' in page
    assert " at 0x" not in page  # the same page from every build


@pytest.mark.parametrize("name", _generated().PAGES)
def test_every_page_is_made(name: str) -> None:
    page = _generated().PAGES[name]()
    assert re.match(r"(---\n.*?---\n\n)?# ", page, re.DOTALL) and len(page.splitlines()) > 10


def test_the_navigation_has_every_page() -> None:
    text = (ROOT / "mkdocs.yml").read_text()
    listed = set(re.findall(r": ([\w/-]+\.md)$", text, re.MULTILINE))
    there = {p.relative_to(ROOT / "docs").as_posix() for p in (ROOT / "docs").rglob("*.md")}
    assert listed == there | set(GENERATED.PAGES)
