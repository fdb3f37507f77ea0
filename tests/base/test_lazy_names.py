"""Public names are imported when they are first used; an old name works on, and warns."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

SOURCE = """
from typing import TYPE_CHECKING

from cramlite.base.lazy_names import LazyNames

if TYPE_CHECKING:
    from os import path
    from .where import New as New, Other as One

names = LazyNames(__name__, {"Old": ("New", "0.2")})
__getattr__, __dir__ = names.load, names.known
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A package of one public name, which had another name before."""
    folder = tmp_path / "renamed_names"
    folder.mkdir()
    (folder / "__init__.py").write_text(SOURCE, encoding="utf-8")
    (folder / "where.py").write_text("class New: pass\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("renamed_names", "renamed_names.where"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return "renamed_names"


def test_an_old_name_is_the_new_thing_and_warns_where_it_is_used(package: str) -> None:
    module = __import__(package)
    with pytest.warns(DeprecationWarning, match=r"^renamed_names\.Old is deprecated since cramlite 0\.2: use renamed_names\.New$") as said:
        found = module.Old
    assert found is module.New and found.__name__ == "New"
    assert [w.filename for w in said] == [__file__]
    with pytest.warns(DeprecationWarning, match=r"use renamed_names\.New"):
        _ = module.Old  # again, since the next user may be somebody else


def test_names_are_those_that_are_exported_and_loaded_when_asked_for(package: str) -> None:
    module = __import__(package)
    assert module.__all__ == ["New"]  # neither an import of one's own nor another name
    assert "New" in dir(module) and "New" not in vars(module) and f"{package}.where" not in sys.modules
    scope: dict[str, object] = {}
    exec(f"from {package} import *", scope)
    assert scope["New"] is vars(module)["New"]


@pytest.mark.parametrize("name", ["One", "Other", "path", "nothing", "__wrapped__"])
def test_a_name_that_is_none_is_refused(package: str, name: str) -> None:
    with pytest.raises(AttributeError, match=f"module 'renamed_names' has no attribute '{name}'"):
        getattr(__import__(package), name)
