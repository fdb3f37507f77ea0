"""Modules that packages of others build upon have their old names, too."""

from __future__ import annotations

import sys
from importlib import import_module

import pytest


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("simulation.simulator", "simulator.simulator"),
        ("simulation.robot_files.robot_file", "imports.robots.robot_file"),
        ("simulation.robot_files.agreement", "imports.robots.agreement"),
    ],
)
def test_an_old_name_is_the_same_module_and_warns(old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, f"cramlite_plugins.{old}", raising=False)
    with pytest.warns(DeprecationWarning, match=rf"cramlite_plugins\.{old} is now cramlite_plugins\.{new}: write this name in its place"):
        found = import_module(f"cramlite_plugins.{old}")
    assert found is import_module(f"cramlite_plugins.{new}")
