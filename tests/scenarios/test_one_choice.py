"""What a scenario blocks, prefers, budgets and adds to the ontologies holds from the command line, Python and ``serve`` alike."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Budget, Engine, Entry, Finished, Trace, failure_text, find_scenario, read_scenario, trace_text
from cramlite.base.json_text import as_json, plain_json
from cramlite.cli.main import main
from cramlite.cli.serving.serve import Service
from cramlite.planning.search.budget import budget_of
from cramlite.plugin import UserError

BLOCKS = """\
scenario: one_of_two
tasks:
  - {{task: Grasping, Patient: it}}
objects:
  it: {{types: [{type}]}}
robot: {{type: ur5e}}
{asked}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: left, model: block, type: {type}, at: {{position: [0.5, 0.2, 51 mm]}}, with: {{size: [50 mm, 50 mm, 100 mm]}}}}
  - {{name: right, model: block, type: {type}, at: {{position: [0.5, -0.2, 51 mm]}}, with: {{size: [50 mm, 50 mm, 100 mm]}}}}
"""
CANDLE = """\
@prefix cram: <http://cramlite.org/ont/cram.owl#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
cram:Candle a owl:Class ; rdfs:subClassOf cram:Product .
"""
TAKES = """\
from cramlite.plugin import Grounding, hookimpl


@hookimpl
def resolve_object(designator, belief, context):
    yield Grounding("{side}", reason="{side} is taken")
"""
SIDES = ("left", "right")


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    (tmp_path / "mine.ttl").write_text(CANDLE)
    written = [tmp_path / f"takes_{side}.py" for side in SIDES]
    for path, side in zip(written, SIDES, strict=True):
        path.write_text(TAKES.format(side=side))
    return written


def _scenario(folder: Path, asked: str, type_: str = "cram:Tin") -> Path:
    path = folder / "one_of_two.yaml"
    path.write_text(BLOCKS.format(asked=asked, type=type_))
    return path


def _command(path: Path, files: list[Path], out: Path, capsys: pytest.CaptureFixture[str]) -> str:
    named = [word for file in files for word in ("--plugin", str(file))]
    code = main(["resolve", str(path), "--verbose", "--no-report", "--out", str(out), *named])
    said = capsys.readouterr().err.rsplit("cramlite: ", 1)[-1]
    return (out / "program.script").read_text() if code == 0 else said


def _python(path: Path, files: list[Path]) -> str:
    engine, scenario, trace = Engine(files=files), read_scenario(path), Trace()
    try:
        solution = next(engine.resolve(scenario, trace=trace), None)
        return solution.code if solution else failure_text(trace, engine.suited(scenario).registry.faults)
    except UserError as error:
        return str(error)


def _served(path: Path, files: list[Path]) -> str:
    asked = json.dumps({"id": 1, "method": "resolve", "params": {"scenario": str(path)}})
    out = io.StringIO()
    Service(Engine(files=files), io.StringIO(asked + "\n"), out).run()
    answer = json.loads(out.getvalue().splitlines()[-1])
    return str(answer["result"]["code"] if "result" in answer else answer["error"]["message"])


def _alike(path: Path, files: list[Path], out: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """What all three say: the program, or why there is none."""
    said, python, served = _command(path, files, out, capsys), _python(path, files), _served(path, files)
    assert python == served
    assert said.startswith(python)
    return python


@pytest.mark.parametrize("side", SIDES)
def test_prefer(side: str, files: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = _alike(_scenario(tmp_path, f"prefer: [takes_{side}]"), files, tmp_path / "run", capsys)
    other = next(s for s in SIDES if s != side)
    assert f"grasp({side})" in found or side in found
    assert other not in found


NO_PLUGIN = "yaml:7: there is no plugin 'objets' to block; did you mean 'objects'?"


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("asked", "says"), [("block: [pushing]", "def "), ("block: [objects]", "no plugin resolves"), ("block: [objets]", NO_PLUGIN)]
)
def test_block(asked: str, says: str, tmp_path: Path, files: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert says in _alike(_scenario(tmp_path, asked), [], tmp_path / "run", capsys)


@pytest.mark.parametrize(
    ("asked", "says"),
    [("budget: {expansions: 2}", "expansions = 2"), ("budget: {expansions: 0}", "yaml:7: a budget is at least 1"),
     ("budget: {expansions: 1000001}", "yaml:7: a budget is at most 1000000, not 1000001: a million expansions take hours")],
)
def test_budget(asked: str, says: str, tmp_path: Path, files: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert says in _alike(_scenario(tmp_path, asked), [], tmp_path / "run", capsys)


@pytest.mark.heavy
@pytest.mark.parametrize(("asked", "says"), [("ontologies: [mine.ttl]", "def "), ("", "unknown class 'cram:Candle'")])
def test_ontologies(asked: str, says: str, tmp_path: Path, files: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert says in _alike(_scenario(tmp_path, asked, "cram:Candle"), [], tmp_path / "run", capsys)


def test_a_file_may_say_that_seconds_have_no_limit(tmp_path: Path) -> None:
    assert budget_of(read_scenario(_scenario(tmp_path, "budget: {seconds: 0}"))) == Budget()
    with pytest.raises(UserError, match="yaml:7: a budget is at least 1"):
        budget_of(read_scenario(_scenario(tmp_path, "budget: {seconds: -1}")))


def test_a_budget_of_the_caller_wins(tmp_path: Path) -> None:
    scenario = read_scenario(_scenario(tmp_path, "budget: {expansions: 2}"))
    assert next(Engine().resolve(scenario), None) is None
    assert next(Engine().resolve(scenario, budget=Budget())).verdict.passed


def test_the_engine_of_a_scenario(tmp_path: Path, files: list[Path]) -> None:
    engine, plain = Engine(), read_scenario(_scenario(tmp_path, ""))
    assert engine.suited(plain) is engine
    asks = read_scenario(_scenario(tmp_path, "{block: [pushing], ontologies: [mine.ttl]}"[1:-1].replace(", onto", "\nonto")))
    own = engine.suited(asks)
    assert own is engine.suited(asks) and own is own.suited(asks) and own is not engine
    assert "pushing" not in {i.name for i in own.registry.infos} and "pushing" in {i.name for i in engine.registry.infos}
    (tmp_path / "mine.ttl").write_text(CANDLE + "\n")
    assert "cram:Candle" in engine.suited(asks).knowledge.taxonomy.classes


@pytest.mark.parametrize("value", [0, -1, 2.5, "3", True, None, 1_000_001, 10**26])
@pytest.mark.parametrize("name", ["expansions", "proofs", "samples", "sequences"])
def test_a_budget_is_a_whole_number_from_1_to_a_million(name: str, value: object) -> None:
    assert getattr(Budget(**{name: 1}), name) == 1 and getattr(Budget(**{name: 1_000_000}), name) == 1_000_000
    with pytest.raises(UserError, match=f"Budget\\({name}=.*at least 1"):
        Budget(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [-1, 1.5, "x", None, True])
def test_a_seed_is_a_whole_number(seed: object, tmp_path: Path) -> None:
    engine, scenario = Engine(), read_scenario(_scenario(tmp_path, ""))
    with pytest.raises(UserError, match="The seed is"):
        next(engine.resolve(scenario, seed=seed))  # type: ignore[arg-type]
    setting = engine.setting(scenario, seed=1)
    with pytest.raises(UserError, match="The seed is"):
        next(engine.resolve(scenario, setting=setting, seed=seed))  # type: ignore[arg-type]


def test_no_tasks_are_no_goal(tmp_path: Path) -> None:
    engine = Engine()
    setting = engine.setting(read_scenario(_scenario(tmp_path, "")))
    with pytest.raises(UserError, match="There is no task"):
        next(engine.resolve([], setting=setting))


@pytest.mark.parametrize("method", ["resolve", "plans"])
@pytest.mark.parametrize(("name", "says"), [("world", "'world'; the setting is given as setting="), ("setings", "'setings'$")])
def test_an_argument_that_there_is_not(method: str, name: str, says: str, tmp_path: Path) -> None:
    engine, scenario = Engine(), read_scenario(_scenario(tmp_path, ""))
    setting = engine.setting(scenario)
    asked = {"setting": setting, "trace": Trace(), name: setting}
    with pytest.raises(TypeError, match=says):
        next(getattr(engine, method)(scenario, **asked))
    del asked[name]
    assert next(getattr(engine, method)(scenario, **asked))


def test_a_goal_without_a_setting_says_how_to_give_one() -> None:
    with pytest.raises(UserError, match=r"pass setting=engine\.setting\(scenario\)"):
        next(Engine().resolve([]))


def test_what_ended_a_search(tmp_path: Path) -> None:
    """Not all that was refused was every alternative: after one program of several the message, the trace and the report say so."""
    scenario, trace, engine = read_scenario(find_scenario("tasks/grasping_fails")), Trace(), Engine()
    assert next(engine.resolve(scenario, trace=trace, budget=Budget(proofs=1)), None) is None
    assert trace_text(trace, "budget") == "!  budget proofs = 1: so many programs were made, the budget of one task sequence"
    said = failure_text(trace, ()).splitlines()[0]
    assert "budget proofs = 1" in said and "budget: {proofs: 2}" in said
    done = Finished(engine, None, engine.setting(scenario), trace, None, None, None)  # type: ignore[arg-type]
    page = next(s for _, s in engine.registry.collect("report_sections") if s.title == "Summary").render(done)
    assert "proofs = 1" in page and "every alternative was refused" not in page


def test_a_search_that_was_not_cut_short(tmp_path: Path) -> None:
    trace = Trace()
    path = tmp_path / "far.yaml"
    path.write_text(_scenario(tmp_path, "").read_text().replace("[0.5, ", "[1.5, "))
    assert next(Engine().resolve(read_scenario(path), trace=trace), None) is None
    assert failure_text(trace, ()).startswith("No solution: every alternative was refused.")
    assert not trace_text(trace, "budget")


PLAIN = st.recursive(
    st.floats() | st.text(max_size=3) | st.none() | st.booleans() | st.integers(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


@examples(50)
@given(PLAIN)
def test_json_has_no_infinity(value: object) -> None:
    for text in (as_json({"value": value}), plain_json([Entry(1, 0, 1, "a", "b", "chosen", "c", "d", float("inf")), value])):
        json.loads(text, parse_constant=_no_number)
    assert as_json(float("nan")) == as_json(np.float32("inf")) == "null"
    assert json.loads(as_json(value)) == value or "null" in as_json(value)


def _no_number(text: str) -> None:
    raise AssertionError(f"{text} is no JSON")
