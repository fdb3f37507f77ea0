"""Run directories: whole files, one directory for each run, and a message for what is broken."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite.base.run_directory import RunDirectory, content_key, read_json
from cramlite.plugin import UserError


def test_a_run_is_complete_only_for_its_own_key(tmp_path: Path) -> None:
    run = RunDirectory(tmp_path / "run", {"seed": 0})
    assert not run.complete
    run.write("a/b.txt", "text")
    assert not RunDirectory(tmp_path / "run", {"seed": 0}).complete
    run.finish()
    assert RunDirectory(tmp_path / "run", {"seed": 0}).complete
    with pytest.raises(UserError, match="another run \\(different: seed\\)"):
        RunDirectory(tmp_path / "run", {"seed": 1})


def test_nothing_half_written_stays(tmp_path: Path) -> None:
    run = RunDirectory(tmp_path, {})
    run.write("x.json", "1")
    run.write("x.json", b"22")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["manifest.json", "x.json"]
    assert (tmp_path / "x.json").read_text() == "22"


def test_folders_that_are_no_run(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "x").write_text("mine")
    with pytest.raises(UserError, match="not empty"):
        RunDirectory(tmp_path / "other", {})
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot be used"):
        RunDirectory(tmp_path / "file", {})
    for content in ("[1]", '{"key": [2]}', "{}"):
        (tmp_path / "other" / "manifest.json").write_text(content)
        with pytest.raises(UserError, match="is no run directory"):
            RunDirectory(tmp_path / "other", {})
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "manifest.json").write_text("{")
    with pytest.raises(UserError, match="cannot be used"):
        RunDirectory(tmp_path / "broken", {})


def test_a_key_follows_content_and_names(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("1")
    first = content_key(tmp_path)
    assert content_key(tmp_path) == first
    (tmp_path / "a").write_text("2")
    assert content_key(tmp_path) != first
    (tmp_path / "a").write_text("1")
    (tmp_path / "a").rename(tmp_path / "b")
    assert content_key(tmp_path) != first


def test_json_that_is_missing_or_broken(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="There is no trace"):
        read_json(tmp_path / "trace.json", "trace")
    (tmp_path / "trace.json").write_text("{")
    with pytest.raises(UserError, match="damaged"):
        read_json(tmp_path / "trace.json", "trace")
