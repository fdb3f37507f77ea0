"""What a user sees of an episode: repairs, and what was inferred, in words and as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from test_dropouts import shipped, unseen
from test_from_motion import SAMPLES, TIMES, lifted, poses, shaken
from test_tracks import dump, tf

from cramlite.cli.main import main
from cramlite.model import Floats
from cramlite_plugins.episodes.formats.neem import write_neem


def test_repairs_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_neem(unseen(shipped(), "tea", 4.5, 0.6, "missing"), tmp_path)
    assert main(["interpret", str(tmp_path)]) == 0
    assert "repaired     4.50 to    5.10 s  'tea' vanished for 0.600 s" in capsys.readouterr().out
    assert main(["interpret", str(tmp_path), "--json"]) == 0
    (repair,) = json.loads(capsys.readouterr().out)["repairs"]
    assert (repair["start"], repair["end"]) == (4.5, 5.1)


def test_nothing_repaired_is_nothing_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_neem(shipped(), tmp_path)
    assert main(["interpret", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["repairs"] == []


UP = np.array([0, 0, 1, 0, 0, 0, 0])  # at the origin a tracker saw nothing
BESIDE = np.array([0.1, 0, 0.05, 0, 0, 0, 0])


def recorded(folder: Path, *paths: tuple[str, Floats]) -> Path:
    """A recording of poses alone, as trackers write it."""
    rows = (tf(name, "map", float(t), p.tolist()) for name, path in paths for t, p in zip(TIMES, path, strict=True))
    return dump(folder, b"".join(rows))


@pytest.mark.parametrize("moves", [shaken, lambda t: 0 * t])
def test_actions_of_a_recording_are_named(
    moves: Callable[[Floats], Floats], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = poses(lifted, moves) + UP
    folder = recorded(tmp_path, ("RightHand", path + BESIDE), ("jar", path))
    assert main(["interpret", str(folder)]) == 0
    said = capsys.readouterr().out
    done = ("jar is lifted off support(jar)", "Shaking of jar, inferred", "jar is put down on support(jar)")
    places = [said.find(words) for words in done]
    assert -1 not in (places[0], places[2]) and places[0] < places[2]
    assert (places[0] < places[1] < places[2]) == (moves is shaken)


def test_a_recording_without_events_is_said_to_have_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = recorded(tmp_path, ("ee_link", poses(lifted) + UP))
    assert main(["interpret", str(folder)]) == 2
    assert "has no events" in capsys.readouterr().err


@pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")
def test_inferred_actions_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interpret", str(SAMPLES / "pouring_shaking")]) == 0
    said = capsys.readouterr().out
    done = ("salt_container is lifted off", "Shaking of salt_container, inferred", "salt_container is put down on")
    places = [said.find(words) for words in done]
    assert -1 not in places
    assert places == sorted(places)


@pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")
@pytest.mark.parametrize("name", ["lar_run1", "GttFys24Hbn_SM.owl"])
def test_what_holds_no_events_is_said(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interpret", str(SAMPLES / name)]) == 2
    assert "has no events" in capsys.readouterr().err
