"""A demonstration is read and interpreted once for everything that a command does with it."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run

from cramlite import Engine, find_scenario, read_scenario
from cramlite.plugin import UserError

COUNTS = """
from pathlib import Path
from cramlite.plugin import hookimpl

@hookimpl
def read_episode(path):
    with Path({log!r}).open("a") as log:
        log.write(path.name + "\\n")
"""


@pytest.fixture
def counter(tmp_path: Path) -> Path:
    """A plugin that is asked for every episode, reads none, and writes down that it was asked."""
    path = tmp_path / "counts.py"
    path.write_text(COUNTS.format(log=str(tmp_path / "log")))
    return path


def reads(counter: Path) -> int:
    return len((counter.parent / "log").read_text().splitlines())


def seen(folder: Path) -> Path:
    """The demonstration with a camera: its likeliest plan says what is looked for. The budget leaves no room for a program."""
    shipped = find_scenario("fetch_from_hanger_camera")
    text = shipped.read_text().replace("demonstration: ", f"demonstration: {shipped.parent}/")
    path = folder / "seen.yaml"
    path.write_text(text + "\nbudget: {expansions: 1, sequences: 1}\n")
    return path


@pytest.mark.heavy
def test_a_command_reads_a_demonstration_once(tmp_path: Path, run: Run, counter: Path) -> None:
    """What to look for, what to plan, and the page about the refusal are all about the same reading."""
    done = run("resolve", seen(tmp_path), "--plugin", counter, "--out", tmp_path / "run")
    assert done.code == 1, done.err
    assert "What it may mean" in (tmp_path / "run" / "report.html").read_text("utf-8")
    assert reads(counter) == 1


@pytest.mark.heavy
def test_an_engine_reads_a_demonstration_once_and_another_engine_reads_it_again(tmp_path: Path, counter: Path) -> None:
    engine, scenario = Engine(files=[counter]), read_scenario(seen(tmp_path))
    other = Engine(files=[counter])
    reading = engine.read(scenario)
    assert not (tmp_path / "log").exists()  # nothing is read before it is needed
    setting = engine.setting(scenario)
    assert reads(counter) == 1
    assert list(engine.resolve(scenario, setting=setting)) == []
    assert list(engine.resolve(reading)) == []
    assert list(engine.resolve(reading, setting=setting)) == []
    assert reads(counter) == 1
    assert engine.read(reading) is reading
    episode = engine.read(reading.episode)  # type: ignore[arg-type]
    assert episode.episode is reading.episode and reads(counter) == 1
    other.setting(scenario)
    assert reads(counter) == 2


def test_the_reading_of_something_else_has_no_setting(tmp_path: Path) -> None:
    engine = Engine()
    with pytest.raises(UserError, match="that of a scenario, not of list"):
        engine.setting(engine.read([]))
