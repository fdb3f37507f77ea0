"""Experiments on benchmarks, with a small one: a process that speaks as LIBERO's does, and simulates with our MuJoCo."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT, Run
from helpers.as_a_user import hears_ctrl_c
from helpers.short_runs import good
from msgspec.structs import replace

from cramlite import Engine, UserError
from cramlite.base.rate import Rate
from cramlite.engine.recovery.next_program import attempt_of
from cramlite.engine.recovery.replanning import BACK, Round
from cramlite.experiment.benchmark.going_on import _missed
from cramlite.experiment.benchmark.play import Trial, play
from cramlite.experiment.benchmark.protocol import connect
from cramlite.experiment.benchmark.results import EpisodeResult
from cramlite.experiment.benchmark.spec import BenchmarkExperiment, Episode, read_benchmark
from cramlite.experiment.benchmark.tables import tables
from cramlite.experiment.benchmark.trials import Episodes
from cramlite.experiment.order import Order
from cramlite.experiment.run import STOPPED, run_experiment
from cramlite.experiment.store import Store
from cramlite.plugin.selection import PluginChoice

SMALL = ROOT / "tests" / "helpers" / "small_benchmark" / "experiment.yaml"


DEADLY = """
import os, sys
from pathlib import Path
from cramlite.experiment.benchmark.protocol import module_of

SmallBenchmark = module_of(Path("{beside}") / "connection.py").SmallBenchmark

class Deadly(SmallBenchmark):
    def reset(self, suite, task, state):
        self.what = task, state
        return super().reset(suite, task, state)

    def setting(self, engine, folder, twins):
        if self.what == (1, 0):
            os._exit(1)
        if self.what == (1, 1):
            raise ValueError("a bug")
        return super().setting(engine, folder, twins)

def connect(environment):
    return Deadly()
"""


def played(order: Order, say: Callable[[str], None]) -> tuple[EpisodeResult, ...]:
    """The results of a run, by the names of the episodes."""
    return tuple(run_experiment(order, say).values())


def results_in(out: Path) -> tuple[EpisodeResult, ...]:
    """The results that a directory holds."""
    return tuple(Store(out, "episodes", EpisodeResult).results().values())


@pytest.fixture(scope="module")
def small() -> BenchmarkExperiment:
    return read_benchmark(SMALL)


@pytest.mark.heavy
def test_episodes_are_proven_played_and_judged_once(run: Run, tmp_path: Path, small: BenchmarkExperiment) -> None:
    """The goal of task 0 is reached; the benchmark of task 1 looks elsewhere; the goal of task 2 has no words; task 3 cannot begin."""
    out = tmp_path / "out"
    asked = ["experiment", SMALL, "--suite", "table", "--out", out]
    done = run(*asked, "--tasks", "0:3", "--workers", "1")
    assert done.code == 0, done.err
    true, never, wordless = results_in(out)
    assert true.proven and true.attempt is not None and true.attempt.outcome == "finished" and true.rest() and not true.failure
    assert {"planning", "proof", "planning, until the first program"} <= true.seconds.keys() and true.wall > 0
    assert true.goal == ("block_1_main in tray_1_main/contain_region",) and 0 < (true.attempt.first or 0) < true.attempt.steps < 400
    assert never.proven and never.attempt is not None and never.attempt.outcome == "finished"  # our proof says so
    assert never.attempt.first is None and not never.first(unlimited=True) and never.failure == "goal"
    assert never.attempt.ours and true.attempt.ours is None  # it is where it should be, for all that we know
    assert not wordless.proven and wordless.attempt is None and wordless.failure == "goal" and "has no words" in wordless.reason
    counted = json.loads((out / "tables.json").read_text())["tables"]
    assert counted["passing_was_right"]["hits"] == 1 and counted["passing_was_right"]["total"] == 2 and counted["refusals"] == 1
    assert counted["whole"]["rest"] == {"hits": 1, "total": 3, "rate": 1 / 3, "interval": counted["whole"]["rest"]["interval"]}
    for name in ("scenario.yaml", "scene.xml", "program.json", "program.npz"):
        assert (out / "episodes" / "table-0-0" / name).exists()
    # again: nothing is played twice, what is missing is played, and an episode that cannot begin is told
    before = {p: p.stat().st_mtime_ns for p in out.glob("episodes/*/result.json")}
    (out / "episodes" / "table-2-0" / "result.json").unlink()
    done = run(*asked, "--tasks", "0,2,3", "--workers", "1")
    assert done.code == 2 and "task 3 of 'table' is broken" in done.err and "1 of 2 trials could not begin" in done.err
    after = {p: p.stat().st_mtime_ns for p in out.glob("episodes/*/result.json")}
    assert len(after) == 3 and {p for p in before if before[p] == after[p]} == {p for p in before if p.parent.name != "table-2-0"}
    done = run(*asked, "--tasks", "1", "--fail")
    assert done.code == 1
    assert "1 of 1 episodes failed the benchmark's check at rest within their budget: table 1 0 task 1: finished" in done.err
    done = run("experiment", SMALL, "--out", out)  # the tables of what is there
    assert done.code == 0 and "1 of 3" in done.out and "benchmark" not in done.err
    html = (out / "report.html").read_text()
    assert "failed: goal" in html and "never true" in html and not re.search(r'(src|href)="(?!data:|#)', html)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("die 1", "ended with exit code 1: segmentation fault"), ("hang 1", "has not answered for 1.2 s"),
        ("garbage 1", "which is no JSON"), ("die 3", "segmentation fault"),
    ],
)  # fmt: skip
def test_a_benchmark_that_goes_before_anything_moved_gives_no_result(
    what: str, said: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    monkeypatch.setenv("SMALL_BENCHMARK", what)
    monkeypatch.setenv("SMALL_PATIENCE", "0.2" if "hang" in what else "20")
    trial = Trial(small, Episode("table", 0, 0), tmp_path, pictures=False)
    with pytest.raises(UserError) as caught:
        play(trial)
    assert said in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.heavy
def test_a_benchmark_that_goes_while_the_robot_moves_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    monkeypatch.setenv("SMALL_BENCHMARK", "garbage 60")
    found = play(Trial(small, Episode("table", 0, 1), tmp_path, pictures=False))
    assert found.proven and found.attempt is not None and found.attempt.outcome == "broken off" and found.failure == "benchmark"
    assert not found.first(unlimited=True) and "which is no state message" in found.attempt.reason
    monkeypatch.delenv("SMALL_BENCHMARK")
    again = play(Trial(small, Episode("table", 2, 0), tmp_path, pictures=False))  # another process
    assert again.failure == "goal"


@pytest.mark.heavy
def test_a_benchmark_that_dies_while_the_robot_moves_is_counted_apart(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    monkeypatch.setenv("SMALL_BENCHMARK", "die 60")
    order = Order(Episodes(small, small.episodes("table", "0", "1"), pictures=False), tmp_path, workers=1)
    (found,) = played(order, lambda _: None)
    assert found.apart and found.failure == "benchmark died" and found.attempt is not None and "exit code 1" in found.attempt.reason
    monkeypatch.delenv("SMALL_BENCHMARK")
    assert played(order, lambda _: None) == (found,)  # it is not played again


@pytest.mark.heavy
@pytest.mark.parametrize("what", ["", "stop 60"])
def test_a_protective_stop_ends_an_episode_that_is_watched(
    what: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    monkeypatch.setenv("SMALL_BENCHMARK", what)
    order = Order(Episodes(small, small.episodes("watched", "0", "0"), pictures=False), tmp_path, workers=1)
    (found,) = played(order, lambda _: None)
    assert found.proven and found.attempt is not None
    if not what:
        assert found.rest() and not found.attempt.notices, found.attempt.reason
        return
    assert found.attempt.outcome == "protective stop" and [n.kind for n in found.attempt.notices] == ["ProtectiveStop"]
    assert "somebody pressed the button; a protective stop waits for a person" in found.attempt.reason
    assert not found.attempt.thought and not list(tmp_path.rglob("round_2")) and not found.rest()


@pytest.mark.heavy
def test_where_a_thing_comes_and_nothing_has_moved_the_same_program_is_finished(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    monkeypatch.setenv("SMALL_BENCHMARK", "come 60")
    order = Order(Episodes(small, small.episodes("watched", "0", "0"), pictures=False), tmp_path, workers=1)
    (found,) = played(order, lambda _: None)  # a process of its own
    assert found.attempt is not None and [n.kind for n in found.attempt.notices] == ["ObjectAppeared"]
    assert found.rest() and not found.attempt.reason and "rest of the same program" in found.attempt.decisions[0]
    folder = tmp_path / "episodes" / "watched-0-0"
    first, rest = (json.loads((folder / name).read_text())["steps"] for name in ("program.json", "round_2/program.json"))
    assert 1 < len(rest) < len(first) and rest[1:] == first[1 - len(rest) :]  # the step under way may begin in its middle
    assert [p.parent for p in folder.rglob("scene.xml")] == [folder], "the scene's file is read once"


@pytest.mark.parametrize(
    ("task", "outcome", "back", "missed"),
    [(0, "finished", False, True), (2, "finished", False, False), (0, "noticed", False, False), (2, "finished", True, True)],
)
def test_a_program_that_ended_short_of_its_goal_is_noticed(
    task: int, outcome: str, back: bool, missed: bool, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    """The block still stands beside the tray; of a goal without words nobody knows whether it holds, and the way back was none to it."""
    base = good()
    assert base.rollout is not None
    attempt = attempt_of(base, base.world)
    attempt = replace(attempt, code=replace(attempt.code, origins={1: BACK})) if back else attempt
    done = Round(attempt, replace(base.rollout, outcome=outcome))
    benchmark = connect(small.beside(small.spec.benchmark), None)
    benchmark.reset("watched", task, 0)
    notice = _missed(benchmark, Engine.with_plugins(PluginChoice((small.beside(small.spec.plugins[0]),))), done, tmp_path)
    benchmark.close()
    assert (notice is not None and notice.kind == "GoalMissed") if missed else notice is None


@pytest.mark.heavy
def test_a_worker_that_dies_after_the_robot_moved_has_failed_at_once(tmp_path: Path, small: BenchmarkExperiment) -> None:
    folder, told = tmp_path / "deadly", list[str]()
    folder.mkdir()
    (folder / "experiment.yaml").write_text(SMALL.read_text().replace("plugins: [../../../", f"plugins: [{ROOT}/"))
    dies = "    def play(self, program, setting):\n        os._exit(1)\n\ndef connect"
    (folder / "connection.py").write_text(DEADLY.format(beside=SMALL.parent).replace("def connect", dies))
    deadly = read_benchmark(folder / "experiment.yaml")
    order = Order(Episodes(deadly, deadly.episodes("table", "0", "0"), pictures=False), tmp_path / "out", workers=1)
    (found,) = played(order, told.append)
    assert found.failure == "defect" and found.reason == STOPPED and not found.apart
    assert sum("a worker died" in line for line in told) == 1


def test_an_episode_that_was_stopped_after_the_robot_moved_is_a_failure_and_not_played_again(
    tmp_path: Path, small: BenchmarkExperiment
) -> None:
    """Two were under way when a run was stopped by hand; the robot of one had moved. Nothing is asked for now but the tables."""
    assert played(Order(Episodes(small, ()), tmp_path), lambda _: None) == ()
    for state, marks in ((0, ("begun", "moved")), (1, ("begun",))):
        (tmp_path / "episodes" / f"table-0-{state}").mkdir(parents=True)
        for mark in marks:
            (tmp_path / "episodes" / f"table-0-{state}" / mark).write_text("1")
    (found,) = played(Order(Episodes(small, ()), tmp_path), lambda _: None)
    assert (found.state, found.failure, found.reason, found.budget) == (0, "defect", STOPPED, 400)
    assert not found.rest(unlimited=True) and not (tmp_path / "episodes" / "table-0-0" / "moved").exists()
    assert tables([found], small).whole.rest == Rate(0, 1)
    (tmp_path / "episodes" / "table-0-0" / "moved").write_text("1")  # a mark beside a result says nothing
    assert played(Order(Episodes(small, ()), tmp_path), lambda _: None) == (found,)


@pytest.mark.heavy
def test_what_kills_its_worker_or_breaks_here_is_a_failure_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    """Episodes of task 2, whose goal has no words: its search takes no time."""
    folder, said = tmp_path / "deadly", list[str]()
    folder.mkdir()
    (folder / "experiment.yaml").write_text(SMALL.read_text().replace("plugins: [../../../", f"plugins: [{ROOT}/"))
    (folder / "connection.py").write_text(DEADLY.format(beside=SMALL.parent))
    deadly = read_benchmark(folder / "experiment.yaml")
    order = Order(Episodes(deadly, deadly.episodes("table", "1:3", "0:2")), tmp_path / "out", workers=1)
    kinds = {(r.task, r.state): (r.failure, r.reason) for r in played(order, said.append)}
    assert kinds[1, 0] == ("defect", "the process died 2 times (out of memory, or killed)")
    assert kinds[1, 1] == ("defect", "ValueError: a bug (defect.txt has the traceback)")
    assert kinds[2, 0][0] == kinds[2, 1][0] == "goal" and sum("begun anew" in line for line in said) == 2
    assert "raise ValueError" in (tmp_path / "out" / "episodes" / "table-1-1" / "defect.txt").read_text()


def descendants(process: int) -> set[int]:
    """Processes that one started, and those that they did."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
            parents[int(stat.parent.name)] = 0 if state == "Z" else int(parent)
    found, more = set[int](), {process}
    while more := {one for one, parent in parents.items() if parent in more} - found:
        found |= more
    return found


@pytest.mark.heavy
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize(("how", "code"), [pytest.param(signal.SIGINT, 130, marks=pytest.mark.heavy), (signal.SIGKILL, -9)])
def test_ctrl_c_and_kill_end_all_processes_and_keep_what_is_done(how: int, code: int, tmp_path: Path, small: BenchmarkExperiment) -> None:
    """The first episode has no words and takes no time, its benchmark hangs in the second one's reset, its sixth request."""
    out = tmp_path / "out"
    words = [sys.executable, "-m", "cramlite", "experiment", SMALL, "--suite", "table", "--tasks", "2", "--states", "0:2", "--out", out]
    hangs = {**os.environ, "SMALL_BENCHMARK": "hang 6"}
    words += ["--workers", "1"]
    running = subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=hangs, preexec_fn=hears_ctrl_c)
    try:
        begun = out / "episodes" / "table-2-1" / "begun"
        assert wait_until(begun.exists), running.communicate()[1]
        left = descendants(running.pid)
        assert any("simulator.py" in Path(f"/proc/{p}/cmdline").read_text() for p in left)
        os.kill(running.pid, how)
        running.communicate(timeout=60)
    finally:
        running.kill()
    assert running.returncode == code
    assert wait_until(lambda: not any(is_running(p) for p in left))
    (done,) = results_in(out)
    assert (done.task, done.state, done.failure) == (2, 0, "goal")


def is_running(process: int) -> bool:
    """Whether a process is there, and not only waited for."""
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"


def wait_until(true: Callable[[], bool]) -> bool:
    """Whether it comes true within a minute."""
    return any(true() or time.sleep(0.1) for _ in range(600))


# Input
