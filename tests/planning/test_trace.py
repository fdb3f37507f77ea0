"""The trace: its readers decide on kinds and numbers, whatever the words say, and its file is read back or refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run
from msgspec.structs import replace

from cramlite import Entry, Trace, how_it_ended, nearest_miss
from cramlite.model import Verdict
from cramlite.planning.trace import read_trace
from cramlite.plugin import Finding, Refused, Unresolvable, UserError

SCENARIO = "tasks/opening_blocked"


def spent() -> Trace:
    """Two task sequences, each cut short by a budget."""
    trace = Trace()
    trace.spent("expansions", 3, "3 nodes were expanded")
    trace.candidate = 2
    trace.spent("proofs", 8, "so many programs were made")
    return trace


def garbled(entries: list[Entry]) -> list[Entry]:
    return [replace(e, designator="x", text="expansions = many", reason="1 of 2") for e in entries]


def test_a_spent_budget_is_known_by_its_numbers() -> None:
    said = how_it_ended(spent().entries)
    assert "its budget expansions = 3 and proofs = 8," in said
    assert "'budget: {expansions: 6, proofs: 16}'" in said and "Budget(expansions=6, proofs=16)" in said
    assert how_it_ended(garbled(spent().entries)) == said


def test_words_alone_end_nothing() -> None:
    """A thing that is called budget, and what looks like its text."""
    trace = Trace()
    trace.add(0, "budget", "expansions = 3", "capped", "engine", "stopped by the caller", kind="object")
    assert how_it_ended(trace.entries).startswith("every alternative that was tried was refused; limits")


def capped(trace: Trace) -> None:
    node = trace.add(0, "tea", "tea", "asked", "engine", "", kind="object")
    trace.add(node, "tea", "", "capped", "engine", "8 alternatives tried, the rest left out", kind="object", numbers={"tried": 8})


def test_what_a_wider_round_takes_up_is_not_left_out() -> None:
    trace = Trace()
    capped(trace)
    trace.widened("Grasping tea", 2)
    assert how_it_ended(trace.entries) == "every alternative was refused"
    assert how_it_ended(garbled(trace.entries)) == "every alternative was refused"
    capped(trace)
    assert "limits left others out" in how_it_ended(trace.entries), "the wider round left some out, too"


def test_a_wider_round_makes_up_for_no_other_sequence_and_no_budget() -> None:
    trace = Trace()
    capped(trace)
    trace.candidate = 2
    capped(trace)
    trace.widened("Grasping tea", 2)
    assert "limits left others out" in how_it_ended(trace.entries), "the first sequence was not tried again"
    trace.spent("sequences", 2, "2 task sequences were tried, the rest left out")
    trace.widened("Grasping tea", 4)
    assert "its budget sequences = 2" in how_it_ended(trace.entries)


@pytest.mark.parametrize(
    ("reasons", "alike"),
    [(("12 mm", "13 mm", "14 mm"), True), (("12 mm", "13 mm"), False), (("1 mm", "2 mm", "too hot"), False)],
)
def test_no_budget_is_to_be_raised_where_all_attempts_failed_by_one_cause(reasons: tuple[str, ...], alike: bool) -> None:
    trace = Trace()
    for trace.candidate, reason in enumerate(reasons, 1):
        trace.add(0, "in(tray)", "", "impossible", "locations", reason, kind="location")
    trace.spent("sequences", len(reasons), "the rest left out")
    said = how_it_ended(trace.entries)
    assert said.startswith("all 3 attempts failed by one cause") == alike == ("budget" not in said)
    trace.spent("expansions", 3, "3 nodes were expanded")
    assert "budget" in how_it_ended(trace.entries), "what was not searched to its end may still succeed"


def test_a_stop_is_known_by_its_kind() -> None:
    trace = spent()
    trace.stopped()
    said = how_it_ended(trace.entries)
    assert said == "the search was stopped by the caller before every alternative was tried"
    assert how_it_ended(garbled(trace.entries)) == said


def test_a_proof_that_failed_is_nearest_and_a_thing_called_proof_is_not() -> None:
    trace = Trace()
    node = trace.add(0, "cup", "cup", "asked", "engine", "", kind="object")
    trace.add(node, "cup", "tin", "impossible", "things", "no tin", kind="object")
    trace.add(0, "proof", "plan", "refused", "things", "a thing of this name", kind="object")
    assert (miss := nearest_miss(trace.entries)) is not None and miss.reason == "no tin"
    trace.add(0, "run", "plan", "failed", "urscript", "force 70 N > 60 N", kind="proof")
    assert (miss := nearest_miss(trace.entries)) is not None and miss.reason == "force 70 N > 60 N"


def test_a_failed_proof_has_what_was_measured() -> None:
    objections = (Finding("slip", False, "slipped", 0.03, 0.012, "m"), Finding("end_state", False, "it fell"))
    verdict = Verdict((Finding("force", True, "calm", 10.0, 60.0, "N"), *objections, Finding("speed", False, "", 2.0, None, "rad/s")))
    assert verdict.measured == {"slip_m": 0.03, "slip_limit_m": 0.012, "speed_rad_s": 2.0}


@pytest.mark.parametrize("numbers", [{"gap_m": "far"}, {3: 1.0}, {"sure": True}, "gap"])
def test_numbers_that_are_none_are_their_giver_s_mistake(numbers: object) -> None:
    for give in (lambda: Refused("tin", "too far", numbers=numbers), lambda: Unresolvable("too far", numbers=numbers)):  # type: ignore[arg-type]
        with pytest.raises(TypeError, match="numbers must"):
            give()


def test_a_trace_is_read_back(tmp_path: Path) -> None:
    trace = spent()
    trace.add(0, "tin", "", "refused", "things", "far", None, 2, kind="object", numbers={"gap_m": 0.5, "limit_m": float("inf")})
    path = tmp_path / "trace.json"
    path.write_text(json.dumps({"entries": trace.to_json()}, allow_nan=False))
    again = read_trace(path)
    assert again.entries == trace.entries
    assert again.entries[-1].numbers == {"gap_m": 0.5}
    assert how_it_ended(again.entries) == how_it_ended(trace.entries)


@pytest.mark.parametrize(
    ("change", "said"),
    [({"kind": None}, "kind"), ({"kind": "colour"}, "Invalid enum value 'colour'"), ({"numbers": {"expansions": "3"}}, "numbers")],
)
def test_a_trace_without_kinds_is_refused_in_one_paragraph(run: Run, tmp_path: Path, change: dict[str, object], said: str) -> None:
    """Those of versions before the kinds, and damaged ones."""
    rows = [{k: v for k, v in (row | change).items() if v is not None or k == "cost"} for row in spent().to_json()]
    (tmp_path / "trace.json").write_text(json.dumps({"entries": rows}))
    with pytest.raises(UserError, match=said):
        read_trace(tmp_path / "trace.json")
    done = run("explain", tmp_path)
    assert done.code == 2 and "Traceback" not in done.err
    assert f"'{tmp_path / 'trace.json'}' is no trace that this version of cramlite reads" in done.err
    assert "run 'cramlite resolve' again" in done.err and len(done.err.strip().splitlines()) == 1


def test_a_run_that_goes_on_refuses_an_older_trace(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "run"
    assert run("resolve", SCENARIO, "--no-report", "--out", out).code == 1
    data = json.loads((out / "trace.json").read_text())
    assert run("resolve", SCENARIO, "--no-report", "--out", out).code == 1  # its own trace is read
    for row in data["entries"]:
        del row["kind"], row["numbers"]
    (out / "trace.json").write_text(json.dumps(data))
    done = run("resolve", SCENARIO, "--no-report", "--out", out)
    assert done.code == 2 and "is no trace that this version of cramlite reads" in done.err
