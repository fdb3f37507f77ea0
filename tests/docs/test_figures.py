"""Figures are files with measurements; the page is made from them, marks old ones, and the README quotes none of those."""

from __future__ import annotations

import argparse
import importlib.util
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest
from conftest import ROOT

from cramlite.experiment.figure import Figure, figure_text, read_figure, write_figure
from cramlite.experiment.measured import rate, repeated, revision, value
from cramlite.plugin import UserError

FILES = sorted((ROOT / "docs" / "figures").glob("*.yaml"))
BENCHMARKS = ROOT / "tests" / "benchmarks"
DECISIONS = ROOT / "docs" / "explanation" / "decisions"
NO_MEASUREMENT = {
    "figure", "flying_gripper", "grasp_objects", "kitchen_drawing", "learning_demonstrations", "motion_demonstrations", "panda_arm",
    "planning_peer", "planning_problems", "pose_views", "same_outputs", "screwing_demonstrations", "wheels",
}  # fmt: skip
"""Modules beside the benchmarks: what these share, a comparison of two checkouts, and a page of wheels."""
OVER_SEEDS = "from seeds import"
"""Benchmarks over seeds have the command line of ``seeds.py``, which writes their figures."""


def loaded(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SITE = loaded(ROOT / "docs" / "site" / "figures.py")
PAGE = ROOT / "docs" / SITE.PAGE


# Files


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_a_file_is_written_as_it_is_read(path: Path) -> None:
    assert figure_text(read_figure(path)) == path.read_text()
    assert path.stat().st_size < 16_000


def test_the_interval_belongs_to_the_rate(tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text("title: t\ncommand: c\nnumbers:\n  - {what: solved, hits: 40, of: 40, low: 0.5, high: 1}\n")
    with pytest.raises(UserError, match=r"wrong.yaml:4: .*the Wilson interval of 40 of 40 is 0.912 to 1.0, not 0.5"):
        read_figure(path)
    path.write_text("title: t\ncommand: c\nnumbers:\n  - {what: solved, hits: 40, of: 40}\n")
    assert (read_figure(path).numbers[0].low, read_figure(path).numbers[0].high) == (0.912, 1.0)


@pytest.mark.parametrize(
    ("number", "said"),
    [
        ("{what: a, hits: 3}", "a number is given by 'hits' and 'of'"), ("{what: a}", "or by 'value'"),
        ("{what: a, hits: 1, of: 2, value: 3}", "or by 'value'"), ("{what: a, hits: 3, of: 2}", "3 of 2 is no rate"),
        ("{what: a, valeu: 3}", "did you mean"), ("{what: a, value: .nan}", "not finite"), ("{what: a, hits: -1, of: 2}", "hits"),
    ],
)  # fmt: skip
def test_a_wrong_number_is_refused_with_its_line(number: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(f"title: t\ncommand: c\nnumbers:\n  - {number}\n")
    with pytest.raises(UserError, match=re.escape(said)) as raised:
        read_figure(path)
    assert "wrong.yaml:4" in str(raised.value)


def small(**changed: object) -> Figure:
    numbers = (rate("proven", 9, 10, "1 x", x=1), rate("proven", 5, 10, "2 x", x=2), value("time", 1.23456, "s", "1 x"))
    return Figure.model_validate({"title": "Small", "command": "python it.py", "numbers": numbers} | changed)


def test_what_is_written_by_hand_stays_and_the_rest_is_new(tmp_path: Path) -> None:
    path = tmp_path / "small.yaml"
    by_hand = {"title": "A title", "about": "What it is.", "plot": {"x": "errors", "y": "share"}, "given": "poses"}
    beside = [{"who": "they", "said": "9 %", "given": "cameras"}]
    write_figure(path, small(**by_hand, beside=beside, commit="0374154", seeds="1 to 10", seen="no"))
    write_figure(path, small(title="small", commit="abcdef1", seeds="11 to 20"))
    found = read_figure(path)
    assert (found.title, found.about, found.given, found.beside[0].who) == ("A title", "What it is.", "poses", "they")
    assert found.plot is not None and (found.commit, found.seeds, found.seen) == ("abcdef1", "11 to 20", None)


# The page


def test_the_page_shows_every_file_once_and_is_short() -> None:
    text = PAGE.read_text()
    assert sorted(m[2] for m in SITE.LINK.finditer(text)) == [p.stem for p in FILES]
    assert len(text.splitlines()) <= 300
    assert len(re.findall(r"figures/\w+\.yaml", text)) == len(FILES)  # no link that is hidden in a sentence


def test_the_tables_of_the_page_say_what_the_files_say() -> None:
    page = PAGE.read_text()
    said = SITE.shown(page)
    assert not SITE.LINK.search(said)
    assert "| bad ones refused | 78 of 78 (1.00, .95 to 1.00) |" in said
    assert "| published | figure | given | source |" in said and "camera pictures, joint positions, the instruction" in said
    ago = re.compile(r"\d+ commits ago")
    assert said.count("(**age unknown**)") + len(ago.findall(said)) - len(ago.findall(page)) == len(FILES)


def repository(folder: Path, commits: int) -> list[str]:
    """A repository with so many commits; the oldest first."""

    def git(*words: str) -> str:
        asked = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b.c", *words]
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()

    git("init", "-q")
    for k in range(commits):
        git("commit", "-q", "--allow-empty", "-m", str(k))
    return git("rev-list", "--reverse", "HEAD").splitlines()


def test_what_is_old_is_marked_and_what_history_does_not_know_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there, nowhere = tmp_path / "there", tmp_path / "nowhere"
    there.mkdir()
    nowhere.mkdir()
    commits = repository(there, 4)
    assert [SITE.age(c, there) for c in commits] == [3, 2, 1, 0]
    assert SITE.age("0" * 40, there) is None and SITE.age(commits[0], nowhere) is None
    (there / "inside").mkdir()
    assert SITE.age(commits[0], there / "inside") is None  # a copy without history inside another repository
    assert revision(there) == (commits[-1][:8], False) and revision(there / "inside") == (None, False)
    monkeypatch.setattr(SITE, "OLD", 2)
    monkeypatch.setattr(SITE, "age", lambda commit, age=SITE.age: age(commit, there))
    shown = [SITE.block("A", "a", small(commit=c)) for c in (*commits, None, "0" * 40)]
    assert ["**old**" in s for s in shown] == [True, False, False, False, False, False]
    assert ["**age unknown**" in s for s in shown] == [False] * 4 + [True, True]
    assert "3 commits ago" in shown[0] and "with changes" in SITE.block("A", "a", small(commit=commits[0], changed=True))


def test_a_plot_is_the_same_each_time_and_shows_each_point_with_its_interval() -> None:
    figure = small(plot={"x": "errors < 4", "y": "share"})
    assert SITE.plot(figure) == SITE.plot(figure)
    drawn = ElementTree.fromstring(SITE.plot(figure))
    circles = drawn.findall(".//{*}circle")
    assert len(circles) == 2 and "errors < 4" in [t.text for t in drawn.findall(".//{*}text")]
    (x1, y1), (x2, y2) = ((float(c.get("cx", "")), float(c.get("cy", ""))) for c in circles)
    assert x1 < x2 and y1 < y2  # the higher rate is drawn higher
    bars = [p.get("d", "") for p in drawn.findall(".//{*}path") if p.get("opacity")]
    low, high = re.findall(r"[\d.]+", bars[0])[1:]
    assert float(high) < y1 < float(low)


@pytest.mark.parametrize(("most", "top"), [(1.0, 1), (0.5, 0.6), (5.5, 6), (236, 400), (7, 8), (9.5, 10), (10, 10), (52, 60)])
def test_the_axis_holds_the_largest_number(most: float, top: float) -> None:
    assert SITE.nice(most) == pytest.approx(top)


# The README


def stale(text: str, age: Callable[[str], int | None] = SITE.age) -> list[str]:
    """Rates of a page outside code that link to no figure that has them, or to an old one."""
    wrong = []
    plain = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    quoted = re.compile(r"\[(\d+) of (\d+)[^\]]*\]\(docs/figures/(\w+)\.yaml\)")
    for hits, of, name in quoted.findall(plain):
        figure = read_figure(ROOT / "docs" / "figures" / f"{name}.yaml")
        if (int(hits), int(of)) not in {(n.hits, n.of) for n in figure.numbers}:
            wrong.append(f"{name} has no {hits} of {of}")
        ago = age(figure.commit) if figure.commit else None
        if figure.commit is None or (ago is not None and ago > SITE.OLD):
            wrong.append(f"{name} was measured {ago} commits ago: measure again, or leave it out")
    rest = re.sub(r"8 of 9 runs must succeed", "", quoted.sub("", plain))  # a rule, no measurement
    return wrong + re.findall(r"\d+ of \d+|\d+(?:\.\d+)? ?%", rest)


def test_the_readme_quotes_no_rate_that_is_old_or_of_no_figure() -> None:
    assert stale((ROOT / "README.md").read_text()) == []


def test_a_rate_that_is_old_or_of_no_figure_is_noticed() -> None:
    good = "[40 of 40 episodes](docs/figures/libero_new.yaml) true"
    assert stale(good, lambda _: SITE.OLD) == [] and stale(good, lambda _: None) == []
    assert "measured 301 commits ago" in stale(good, lambda _: SITE.OLD + 1)[0]
    assert stale(good.replace("40 of 40", "39 of 40"), lambda _: 0) == ["libero_new has no 39 of 40"]
    assert stale("we did 12 of 13, or 92 %", lambda _: 0) == ["12 of 13", "92 %"]


# Benchmarks


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("*.py")), ids=lambda p: p.stem)
def test_every_benchmark_can_write_its_figure(path: Path) -> None:
    text = path.read_text()
    if path.stem in NO_MEASUREMENT or (OVER_SEEDS in text and "ArgumentParser" not in text):
        return
    assert re.search(r"\badd_figure\(", text) and re.search(r"\bwrite\((options|arguments|asked|given|chosen), ", text)


def test_a_benchmark_writes_what_it_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    monkeypatch.setattr("figure.FOLDER", tmp_path)
    program = loaded(BENCHMARKS / "robot_code.py")
    asked = ["robot_code.py", "mutations", "--count", "3", "--figure", "tried", "--seen", "no"]
    monkeypatch.setattr(sys, "argv", asked)
    program.main()
    found = read_figure(tmp_path / "tried.yaml")
    assert found.command == "python tests/benchmarks/robot_code.py mutations --count 3" and found.seen == "no"
    assert found.seeds == "seed 0" and sum(n.hits or 0 for n in found.numbers) == 3 and (found.cpu_s or 0) > 0
    assert "cores" in (found.machine or "") and "MuJoCo" in (found.machine or "")
    monkeypatch.setattr(sys, "argv", [*asked[:5], "../tried"])
    with pytest.raises(SystemExit):
        program.main()
    assert "'../tried' is no name of a figure" in capsys.readouterr().err
    (tmp_path / "tried.yaml").write_text("title: [\n")
    monkeypatch.setattr(sys, "argv", asked)
    with pytest.raises(SystemExit):  # before anything is measured
        program.main()
    assert "not valid YAML" in capsys.readouterr().err


def test_seeds_of_a_range_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import figure

    options = argparse.Namespace(figure=tmp_path / "it.yaml", seen=None)
    figure.write(options, [figure.rate("solved", 1, 2)], range(5, 15))
    assert read_figure(tmp_path / "it.yaml").seeds == "5 to 14"
    figure.write(argparse.Namespace(figure=None, seen=None), [])  # nothing was asked for


def test_a_command_is_said_as_others_would_give_it() -> None:
    given = ["/home/me/scenes/cup.yaml", "--figure", "cups", "--count", "3", "--seen=no", "--note", "two words"]
    assert repeated("python it.py", given) == "python it.py cup.yaml --count 3 --note 'two words'"


# Decisions


def test_decisions_are_few_and_ten_lines_each() -> None:
    records = sorted(p for p in DECISIONS.glob("*.md") if p.name != "index.md")
    assert 8 <= len(records) <= 15
    listed = re.findall(r"\]\((\w+\.md)\)", (DECISIONS / "index.md").read_text())
    shown = re.findall(r"decisions/(\w+\.md)", (ROOT / "mkdocs.yml").read_text())
    assert sorted(listed) == [p.name for p in records] and sorted(shown) == sorted([*listed, "index.md"])
    assert [p.name for p in records if len(p.read_text().splitlines()) > 10] == []
