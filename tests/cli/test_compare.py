"""``cramlite compare``: logs of an arm beside the run that was proven."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from cramlite.model import Floats
from cramlite.model.run.rollout import Rollout, load_rollout
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.selection import INSTALLED
from cramlite.scenario.worlds import read_world

FIELDS = ["timestamp", *(f"actual_q_{k}" for k in range(6)), *(f"actual_TCP_force_{k}" for k in range(6))]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run directory."""
    from cramlite.cli.main import main

    folder = tmp_path_factory.mktemp("compare") / "run"
    assert main(["resolve", "grasp_one_thing", "--out", str(folder)]) == 0
    return folder


def rollout_of(run: Path) -> Rollout:
    knowledge = Knowledge(INSTALLED.registry())
    return load_rollout(run / "rollout.npz", read_world(str(run / "world.json"), knowledge, 0))


def log_of(run: Path, to: Path, *, starts: float = 1.3, late: Callable[[Floats], Floats] = lambda t: t, blank: str = ",") -> Path:
    """A log at 125 Hz that begins some time before the program, of an arm that is where the run's is at other times."""
    rollout = rollout_of(run)
    rng = np.random.default_rng(0)
    times = np.arange(0.0, rollout.times[-1] + starts, 0.008)
    at = late(times - starts)
    joints = [np.interp(at, rollout.times, rollout.joints[:, k]) + rng.normal(0, 2e-4, len(at)) for k in range(6)]
    force = np.interp(at, rollout.times, rollout.contact_force())
    rows = np.column_stack([times + 5000.0, *joints, force, *np.zeros((5, len(at)))])
    lines = [blank.join(FIELDS), *(blank.join(f"{v:.6f}" for v in row) for row in rows)]
    to.write_text("\n".join(lines) + "\n")
    return to


@pytest.mark.parametrize("blank", [",", " ", ";"])
def test_the_same_motion_at_another_time_does_not_part(run: Run, ran: Path, tmp_path: Path, blank: str) -> None:
    said = run("compare", ran, log_of(ran, tmp_path / "log.csv", blank=blank))
    assert said.code == 0 and "the run starts at 1.30 s of the log" in said.out
    assert "no joint differs by more than 0.02 rad" in said.out


def test_where_they_part(run: Run, ran: Path, tmp_path: Path) -> None:
    slower = log_of(ran, tmp_path / "slow.csv", late=lambda t: np.where(t < 2.0, t, 2.0 + 0.8 * (t - 2.0)))
    page = tmp_path / "page.html"
    said = run("compare", ran, slower, "--html", page)
    assert said.code == 1 and "log and run diverge at" in said.err and "line" in said.err
    assert page.read_text().count("<polyline") == 2 * (6 + 6 + 1)
    found = json.loads(run("compare", ran, slower, "--json").out)
    assert found["parts"]["difference"] > 0.02 and 1.0 < found["parts"]["time"] < 6.0
    assert run("compare", ran, slower, "--within", "90 deg").code == 0


def test_bad_logs_are_named(run: Run, ran: Path, tmp_path: Path) -> None:
    good = log_of(ran, tmp_path / "log.csv").read_text()
    lines = good.splitlines()
    bad = {
        "no column timestamp": good.replace("timestamp", "time"),
        "no column actual_q_0": good.replace("actual_q_3", "target_q_3"),
        ":4: could not convert": "\n".join([*lines[:3], lines[3].replace(".", "x", 1), *lines[4:]]),
        ":5: 3 numbers where the header names 13": "\n".join([*lines[:4], "1,2,3", *lines[5:]]),
        "do not grow": "\n".join([*lines[:9], lines[5], *lines[9:]]),
        "log the whole program": "\n".join(lines[:30]),
        "no column": "",
    }
    for said, text in bad.items():
        (tmp_path / "bad.csv").write_text(text)
        answer = run("compare", ran, tmp_path / "bad.csv")
        assert answer.code == 2 and said in answer.err, (said, answer.err)
    assert run("compare", ran, tmp_path / "nowhere.csv").code == 2
    assert run("compare", tmp_path, tmp_path / "log.csv").code == 2
    assert run("compare", ran, tmp_path / "log.csv", "--within", "3 kg").code == 2
