"""Public names are imported when they are first used; an old name works on, and warns."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cramlite.base.lazy_names import LazyNames

SOURCE = """
from cramlite.base.lazy_names import LazyNames

names = LazyNames(__name__, {".where": "New"}, {"Old": ("New", "0.2")})


def __getattr__(name):
    return names.load(name)
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A package of one public name, which had another one."""
    folder = tmp_path / "renamed_names"
    folder.mkdir()
    (folder / "__init__.py").write_text(SOURCE, encoding="utf-8")
    (folder / "where.py").write_text("class New: pass\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "renamed_names", raising=False)
    return "renamed_names"


def test_an_old_name_is_the_new_thing_and_warns_where_it_is_used(package: str) -> None:
    module = __import__(package)
    with pytest.warns(DeprecationWarning, match=r"^renamed_names\.Old is deprecated since cramlite 0\.2: use renamed_names\.New$") as said:
        found = module.Old
    assert found is module.New and found.__name__ == "New"
    assert [w.filename for w in said] == [__file__]
    with pytest.warns(DeprecationWarning, match=r"use renamed_names\.New"):
        _ = module.Old  # again, since the next user may be somebody else


def test_a_name_that_is_none_is_refused() -> None:
    with pytest.raises(AttributeError, match="module 'nowhere' has no attribute 'New'"):
        LazyNames("nowhere", {}).load("New")
