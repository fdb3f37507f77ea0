"""What a user sees of an episode: repairs, and what was inferred, in words and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from test_dropouts import shipped, unseen
from test_from_motion import SAMPLES

from cramlite.cli.main import main
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


@pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")
def test_inferred_actions_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interpret", str(SAMPLES / "pouring_shaking")]) == 0
    said = capsys.readouterr().out
    places = [said.find(f"{task} of salt_container, inferred") for task in ("PickingUp", "Shaking", "PuttingDown")]
    assert -1 not in places
    assert places == sorted(places)


@pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")
@pytest.mark.parametrize("name", ["lar_run1", "GttFys24Hbn_SM.owl"])
def test_what_holds_no_events_is_said(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interpret", str(SAMPLES / name)]) == 2
    assert "has no events" in capsys.readouterr().err
