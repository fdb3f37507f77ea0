"""What an editable installation does not know of its source tree is told, and nothing else is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run

from cramlite.plugin.registry import Registry
from cramlite.plugin.source_trees import unknown_plugins

HOOK = "from cramlite.plugin import hookimpl\n\n\n@hookimpl\ndef task_types():\n    return []\n"
DECLARED = '[project]\nname = "shop"\n[project.entry-points.cramlite]\nold_shop = "old_shop"\nnew_shop = "new_shop"\n'
Install = Callable[..., Path]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Install a distribution 'shop' that knows the plugin 'old_shop', with a source tree that declares 'new_shop' as well."""

    def make(project: str | None = DECLARED, *, editable: object = True, url: str = "", known: str = "old_shop = old_shop") -> Path:
        tree, site = tmp_path / "a tree", tmp_path / "site"
        info = site / "shop-1.2.dist-info"
        info.mkdir(parents=True)
        tree.mkdir()
        for name in ("old_shop", "new_shop"):
            (site / f"{name}.py").write_text(HOOK)
        if project is not None:
            (tree / "pyproject.toml").write_text(project)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: shop\nVersion: 1.2\nRequires-Dist: cramlite\n")
        (info / "entry_points.txt").write_text(f"[cramlite]\n{known}\n")
        (info / "direct_url.json").write_text(json.dumps({"url": url or tree.as_uri(), "dir_info": {"editable": editable}}))
        monkeypatch.syspath_prepend(str(site))
        monkeypatch.setenv("PYTHONPATH", str(site))
        return tree

    return make


def names() -> list[str]:
    return [u.name for u in unknown_plugins() if u.distribution == "shop"]


def test_what_was_declared_after_the_installation_is_named_with_what_to_do(install: Install) -> None:
    tree = install()
    (found,) = (u for u in unknown_plugins() if u.distribution == "shop")
    assert (found.name, found.version, found.file) == ("new_shop", "1.2", tree / "pyproject.toml")
    assert found.reason.endswith(f"install it again: pip install -e {tree}")


def test_a_plugin_that_is_elsewhere_now_is_not_known_either(install: Install) -> None:
    install(known="old_shop = old_shop_of_before\nnew_shop = new_shop")
    assert names() == ["old_shop"]


def test_an_installation_that_knows_all_is_not_named(install: Install) -> None:
    install(known="old_shop = old_shop\nnew_shop = new_shop")
    assert names() == []


@pytest.mark.parametrize("given", [
    {"editable": False}, {"editable": None}, {"url": "https://example.org/shop.git"}, {"project": None}, {"project": "[project"},
    {"project": DECLARED.replace('"shop"', '"another"')}, {"project": '[project]\nname = "shop"\n'}, {"project": "project = 3\n"},
    {"project": '[project]\nname = "shop"\nentry-points.cramlite = 3\n'},
])  # fmt: skip
def test_of_a_copy_and_of_a_tree_that_says_nothing_nothing_is_said(install: Install, given: dict[str, object]) -> None:
    install(**given)
    assert names() == []


def test_this_installation_knows_all_of_its_own() -> None:
    assert [u for u in unknown_plugins() if u.distribution == "cramlite"] == [], "install it again: pip install -e ."


def test_the_registry_lists_it_as_not_loaded(install: Install) -> None:
    install()
    told = Registry()
    told.examine()
    assert [f.plugin for f in told.faults if "but shop" in f.error] == ["new_shop"]
    assert [i.fault != "" for i in told.infos if i.name in ("old_shop", "new_shop")] == [False, True]
    assert not Registry().faults, "other commands do not look for it"


@pytest.mark.heavy
def test_plugins_and_doctor_tell_it(install: Install, run: Run) -> None:
    tree = install()
    listed, examined = run("plugins"), run("doctor")
    assert listed.code == 3 and "new_shop (shop 1.2)" in listed.out
    assert f"NOT LOADED: '{tree}/pyproject.toml' declares this plugin" in listed.out
    assert examined.code == 1 and "pip install -e" in examined.out.splitlines()[-1]
    assert run("tasks").err == ""
