"""Runs: the same for any number of workers, resumed after anything, and what is broken is said. Real demonstrations are
recorded and interpreted; the budget leaves no room for programs, so that a run takes seconds."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import Run
from helpers.as_a_user import hears_ctrl_c
from helpers.quick_experiment import order, quick_experiment, told

from cramlite.experiment.cluster_tasks import run_trial
from cramlite.experiment.demonstrations.results import DemonstrationResult
from cramlite.experiment.demonstrations.spec import read_experiment
from cramlite.experiment.demonstrations.trials import Demonstrations
from cramlite.experiment.experiment_file import find_experiment
from cramlite.experiment.figure import read_figure
from cramlite.experiment.order import Order
from cramlite.experiment.run import run_experiment
from cramlite.experiment.store import Store, locked
from cramlite.plugin import UserError


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    return quick_experiment(tmp_path / "quick")


@pytest.mark.heavy
def test_any_number_of_workers_finds_the_same_and_finished_work_is_not_redone(experiment: Path, tmp_path: Path) -> None:
    said: list[str] = []
    one = run_experiment(order(experiment, tmp_path / "one"), said.append)
    run_experiment(order(experiment, tmp_path / "two", 2), lambda _: None)
    assert told(tmp_path / "one") == told(tmp_path / "two")
    assert len(told(tmp_path / "one")) == 6 and "[3/3]" in said[-1] and "left" in said[-1]
    assert all(r.candidates >= 1 and not r.solved and "expanded" in r.results[0].reason for r in one.values())
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "one").rglob("*.json") if p.name != "manifest.json"}
    (tmp_path / "one" / "results" / "O2-01" / "result.json").unlink()  # as if it had been killed there
    again = run_experiment(order(experiment, tmp_path / "one"), said.append)
    assert list(again) == [r.name for r in again.values()] == ["O1-01", "O2-01", "O3-01"]
    redone = [p for p, t in before.items() if p.stat().st_mtime_ns != t]
    assert [p.name for p in redone] == ["result.json"]  # its candidate was finished, and was read


@pytest.mark.heavy
def test_a_figure_is_written_with_the_tables(experiment: Path, tmp_path: Path, run: Run) -> None:
    file = tmp_path / "quick.yaml"
    done = run("experiment", experiment, "--out", tmp_path / "out", "--no-pictures", "--workers", "1", "--figure", file, "--seen", "yes")
    assert done.code == 0, done.err
    found = read_figure(file)
    assert (found.seeds, found.seen) == ("1000 to 1200, 3 demonstrations", "yes") and (found.cpu_s or 0) > 0
    assert {(n.part, n.hits, n.of) for n in found.numbers if n.what == "all"} >= {("came off", 3, 3), ("solved", 0, 3)}


@pytest.mark.parametrize("expansions", [pytest.param(400, marks=pytest.mark.heavy), 2])
def test_a_set_may_stop_at_the_first_candidate_that_succeeds(experiment: Path, tmp_path: Path, expansions: int) -> None:
    path = experiment / "experiment.yaml"
    text = path.read_text().replace("about: quick", "until_solved: true, about: quick")
    text = text.replace("expansions: 2", f"expansions: {expansions}").replace("first: 1000", "first: 1002")  # has two readings
    path.write_text(text.replace("most_candidates: 1", "most_candidates: 2"))
    asked = Order(Demonstrations(path, pictures=False), tmp_path / "out")
    found = run_trial(asked, asked.trials.names[0])
    assert found.candidates >= 2
    assert (found.solved, found.tried, len(found.results)) == ((True, 1, 1) if expansions == 400 else (False, 2, 2))
    assert not multiprocessing.active_children()  # a worker that had one left would never end


DIES = """
import os
from pathlib import Path
from cramlite.plugin import hookimpl

@hookimpl(tryfirst=True)
def read_episode(path):
    mark = Path({mark!r})
    if path.name == "O2-01" and (not mark.exists() or {always}):
        mark.write_text("")
        os._exit(9)
"""


@pytest.mark.heavy
@pytest.mark.parametrize("always", [False, True])
def test_a_worker_that_dies_is_replaced(experiment: Path, tmp_path: Path, always: bool) -> None:
    plugin = tmp_path / "dies.py"
    plugin.write_text(DIES.format(mark=str(tmp_path / "mark"), always=always))
    said: list[str] = []
    found = run_experiment(order(experiment, tmp_path / "out", 1, plugin), said.append)
    assert any("a worker died during O2-01 (1 of 2)" in line for line in said)
    assert found["O1-01"].candidates >= 1 and found["O3-01"].candidates >= 1
    if always:
        assert "worker: the process died 2 times" in found["O2-01"].reason and found["O2-01"].candidates == 0
    else:
        assert found["O2-01"].candidates >= 1


WAITS = """
import time
from pathlib import Path
from cramlite.plugin import hookimpl

@hookimpl(tryfirst=True)
def read_episode(path):
    while path.name == "O3-01" and Path({mark!r}).exists():
        time.sleep(0.1)
"""


def start(experiment: Path, out: Path, plugin: Path) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "cramlite", "experiment", experiment, "--out", out, "--workers", "1", "--plugin", plugin]
    return subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, preexec_fn=hears_ctrl_c)


def wait_for(path: Path) -> None:
    for _ in range(600):
        if path.exists():
            return
        time.sleep(0.1)
    raise AssertionError(f"{path} never came")


def children(parent: int) -> list[int]:
    listed = list(Path("/proc").glob("[0-9]*/stat"))
    pairs = [p.read_text().rpartition(")")[2].split() for p in listed if p.exists()]
    return [int(p.parent.name) for p, fields in zip(listed, pairs, strict=False) if int(fields[1]) == parent]


@pytest.mark.heavy
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize(("how", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGKILL, -9, marks=pytest.mark.heavy)])
def test_ctrl_c_and_kill_lose_nothing(experiment: Path, tmp_path: Path, how: int, code: int) -> None:
    out, mark, plugin = tmp_path / "out", tmp_path / "mark", tmp_path / "waits.py"
    plugin.write_text(WAITS.format(mark=str(mark)))
    mark.write_text("the last demonstration is not read while this is here")
    running = start(experiment, out, plugin)
    try:
        wait_for(out / "results" / "O1-01" / "result.json")
        workers = children(running.pid)
        os.kill(running.pid, how)
        _, said = running.communicate(timeout=60)
    finally:
        running.kill()
    assert running.returncode == code
    assert how == signal.SIGKILL or "interrupted; what was written so far is kept" in said
    assert workers
    for _ in range(600):  # a worker that did not follow its parent would wait for the mark for ever
        if not any(Path(f"/proc/{w}").exists() and "Z" not in Path(f"/proc/{w}/stat").read_text() for w in workers):
            break
        time.sleep(0.1)
    else:
        raise AssertionError("a worker goes on without its parent")
    before = (out / "results" / "O1-01" / "result.json").stat().st_mtime_ns
    mark.unlink()
    assert len(run_experiment(order(experiment, out, 1, plugin), lambda _: None)) == 3
    assert (out / "results" / "O1-01" / "result.json").stat().st_mtime_ns == before


@pytest.mark.heavy
def test_what_is_changed_foreign_or_damaged_is_said(experiment: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = run_experiment(order(experiment, out), lambda _: None)
    path = out / "results" / "O1-01" / "result.json"
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2])
    with pytest.raises(UserError, match=r"O1-01/result.json' is damaged .* Delete this one file"):
        run_experiment(order(experiment, out), lambda _: None)
    path.unlink()
    again = run_experiment(order(experiment, out), lambda _: None)
    assert len(found) == 3 and all(again[name] == found[name] for name in ("O2-01", "O3-01"))
    scenario = experiment / "scenario.yaml"
    scenario.write_text(scenario.read_text().replace("mass: 300 g", "mass: 310 g"))
    with pytest.raises(UserError, match=r"another run .different: files."):
        run_experiment(order(experiment, out), lambda _: None)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    with pytest.raises(UserError, match="not empty and is no run directory"):
        run_experiment(order(experiment, tmp_path / "mine"), lambda _: None)


@pytest.mark.heavy
def test_two_runs_in_one_directory_are_told_apart(experiment: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run_experiment(order(experiment, out), lambda _: None)
    before = told(out)
    with locked(out), pytest.raises(UserError, match=r"Another experiment .* is running"):  # as if one were still at it
        run_experiment(order(experiment, out), lambda _: None)
    assert told(out) == before
    run_experiment(order(experiment, out), lambda _: None)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_said(tmp_path: Path) -> None:
    (tmp_path / "results" / "O1-01").mkdir(parents=True)
    (tmp_path / "results" / "O1-01" / ".x.json.part").symlink_to("/dev/full")
    with pytest.raises(
        UserError, match=r"x.json' cannot be written: No space left on device. What was written before is kept"
    ):
        Store(tmp_path, "results", DemonstrationResult).write("O1-01", "x.json", "{}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("first: 1000", "first: 51000", "share the seed 51000"),
        ("goal: ", "gaol: ", "gaol"),
        ("{sequences: 1,", "{sequence: 1,", r"experiment.yaml:\d+: no budget 'sequence'; did you mean 'sequences'"),
        ("hanger, O1", "x", ""),
    ],
)
def test_experiment_files_are_checked(experiment: Path, old: str, new: str, said: str) -> None:
    path = experiment / "experiment.yaml"
    path.write_text(path.read_text().replace(old, new))
    if not said:
        assert read_experiment(path)
        return
    with pytest.raises(UserError, match=said):
        read_experiment(path)


def test_what_a_set_says_of_the_budget_goes_first() -> None:
    shipped = read_experiment(find_experiment("hang_onto_hanger"))
    main, separation, first = shipped.budget("main"), shipped.budget("separation"), shipped.budget("main", "other_candidates")
    assert (main.sequences, main.proofs, main.expansions) == (2, 4, 400)
    assert (separation.sequences, separation.proofs, separation.expansions) == (1, 1, 400)
    assert (first.sequences, first.proofs) == (1, 4)


def test_names_that_there_are_not(experiment: Path) -> None:
    with pytest.raises(UserError, match="did you mean 'fetch_from_hanger'"):
        find_experiment("fetch_from_hangr")
    found = read_experiment(experiment / "experiment.yaml")
    with pytest.raises(UserError, match="no set 'man'; did you mean 'main'"):
        found.choose("man")
    with pytest.raises(UserError, match="no ablation 'serch'; did you mean 'search'"):
        found.ablation("serch")
