"""Screwing a lid by two turns: people show it, and others show something else."""

from __future__ import annotations

import math
import tempfile
from functools import cache
from pathlib import Path

import pytest
from motion_demonstrations import WRONG, Shown_, shown

from cramlite import Engine

ENGINE = Engine()
TURNS = {"": -2.0, "half a turn": -0.5, "the wrong way": 2.0, "in the air": 0.0, "to and fro": 0.0}


@cache
def person(seed: int, wrong: str = "") -> Shown_:
    with tempfile.TemporaryDirectory() as folder:
        found = shown(ENGINE, "screwing", seed, Path(folder), {"screwing": WRONG["screwing"][wrong]} if wrong else None)
    assert not found.failure
    return found


@pytest.mark.heavy
@pytest.mark.parametrize("wrong", ["", *WRONG["screwing"]])
def test_the_lid_turns_as_people_mean_it(wrong: str) -> None:
    episode = person(4, wrong).episode
    values = episode.extras["joint:lid"]
    held = [e for e in episode.of("state") if e.type == "cram:GraspState" and e.roles["object"] == "lid"]
    assert (values[-1] - values[0]) / math.tau == pytest.approx(TURNS[wrong], abs=0.1)
    assert len(held) >= 5 if wrong in ("", "the wrong way") else len(held) == {"half a turn": 2, "in the air": 0, "to and fro": 1}[wrong]
