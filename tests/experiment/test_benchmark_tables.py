"""Tables, pages and figures of the episodes of a benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, Run
from msgspec.json import encode as json_bytes
from msgspec.structs import replace

from cramlite import UserError
from cramlite.base.rate import Rate
from cramlite.experiment.benchmark.outcomes import explained, outcomes_page, why
from cramlite.experiment.benchmark.report import markdown
from cramlite.experiment.benchmark.results import Attempt, EpisodeResult, plain_reason
from cramlite.experiment.benchmark.spec import BenchmarkExperiment, read_benchmark
from cramlite.experiment.benchmark.tables import tables
from cramlite.experiment.figure import read_figure
from cramlite.experiment.store import Store

SMALL = ROOT / "tests" / "helpers" / "small_benchmark" / "experiment.yaml"


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
        Store(tmp_path, "episodes", EpisodeResult).results()


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
