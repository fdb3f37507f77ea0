"""Tables: counts, intervals, what the filter got right, and what misses a threshold."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from cramlite.base.json_text import as_json
from cramlite.experiment.demonstrations.candidates_table import to_csv
from cramlite.experiment.demonstrations.report import (
    against_baseline,
    baseline,
    html,
    missed_thresholds,
    numbers,
    of_filter,
    share,
    text,
    to_json,
)
from cramlite.experiment.demonstrations.results import CandidateResult, DemonstrationResult, Execution, Program
from cramlite.experiment.demonstrations.spec import PublishedSpec, ThresholdSpec
from cramlite.experiment.demonstrations.tables import Share, area_under_curve, tables
from cramlite.plugin import UserError

OFF = "end_state: 'coffee' is 0.12 m off"


def executions(*succeeded: bool) -> tuple[Execution, ...]:
    return tuple(Execution(k, s, "" if s else OFF, 9.0 if s else 70.0, 20.0) for k, s in enumerate(succeeded, 1))


GOOD, BAD = executions(True, False), executions(False, False)


def candidate(number: int, *attempts: Program, reason: str = "") -> CandidateResult:
    accepted = next((a for a in attempts if a.accepted), None)
    executed = tuple(e.succeeded for e in accepted.executions) if accepted else ()
    planned = any(a.executions for a in attempts)
    return CandidateResult(
        number, ("Grasping(tea)",), 1.0, planned, accepted is not None, executed, reason, attempts, {"plan": 2.0}
    )


def demonstration(name: str, *results: CandidateResult, reason: str = "", failure: str = "") -> DemonstrationResult:
    return DemonstrationResult(name, name[:2], 1, 36, len(results), len(results), results, reason, {"record": 1.0}, failure)


RESULTS = (
    demonstration("O1-01", candidate(1, Program(True, "", GOOD, confidence=1.0)),
                  candidate(2, Program(True, "", BAD, confidence=8 / 9), reason="execution: 0.1 m")),
    demonstration("O1-02", candidate(1, Program(False, "slip 13 mm", GOOD), reason="simulation: slip 13 mm")),
    demonstration("O2-01", candidate(1, reason="plan: reach 0.9 m"), candidate(2, Program(True, "", GOOD, confidence=1.0))),
    demonstration("O2-02", reason="interpret: nothing", failure="'tea' is not in 'basket' at the end"),
)  # fmt: skip
PUBLISHED = PublishedSpec(
    source="a paper", gave_candidates=(10, 9), candidates=(4, 2), planned=(4, 2), simulated=(2, 1), executed=(1, 1)
)


@given(st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_intervals_are_wilsons(case: tuple[int, int]) -> None:
    hits, total = case
    expected = binomtest(hits, total).proportion_ci(method="wilson")
    assert Share(hits, total).interval == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_the_rows_count_candidates_and_demonstrations() -> None:
    found = tables(RESULTS, PUBLISHED)
    first, second, whole = found.rows
    assert [r.object for r in found.rows] == ["O1", "O2", "all"]
    assert (first.planned.hits, first.simulated.hits, first.executed.hits, first.planned.total) == (3, 2, 1, 3)
    assert (whole.gave.hits, whole.solved.hits, whole.first.hits, whole.solved.total) == (3, 2, 1, 4)
    assert second.gave.published == (9, 10) and whole.executed.published == (2, 6)
    assert first.planned.reached and not second.planned.reached
    assert dict(found.lost).keys() == {"O1-02", "O2-02"}
    assert found.seconds == {"plan": 10.0, "record": 4.0}


def test_what_the_filter_got_right() -> None:
    c, harder = tables(RESULTS).confusions
    assert (c.accepted_succeeded, c.accepted_failed, c.refused_succeeded, c.refused_failed) == (2, 1, 1, 0)
    assert (c.wrongly_accepted.hits, c.wrongly_accepted.total, c.wrongly_refused.hits, c.wrongly_refused.total) == (1, 3, 1, 1)
    assert (harder.scale, harder.accepted_failed, harder.refused_failed, harder.area_under_curve) == (2, 3, 1, None)
    assert c.area_under_curve is not None and c.area_under_curve[0] == pytest.approx(2 / 3)
    assert Share(0, 0).interval == (0.0, 1.0)


def test_twins_are_compared_with_the_nominal_run_where_they_disagree() -> None:
    doubted = [Program(False, "twins: 4 of 6", executions(k == 0, False), confidence=4 / 6) for k in range(7)]
    c, harder = tables([demonstration("O1-01", *(candidate(k, a, reason="simulation: 4 of 6") for k, a in enumerate(doubted)))]).confusions
    assert (c.doubted_succeeded, c.doubted_failed) == (1, 6) and (harder.doubted_succeeded, harder.doubted_failed) == (0, 7)
    assert c.mcnemar == pytest.approx(0.125) and harder.mcnemar == pytest.approx(2 / 2**7)  # both tails of a fair coin
    assert "6 rightly, 1 wrongly, McNemar p 0.12" in of_filter(c)
    assert tables(RESULTS).confusions[0].mcnemar is None  # the nominal run refused it, too


def test_what_misses_the_goal_where_it_is_believed_to_reach_it_is_refused() -> None:
    short = Program(True, "", GOOD, confidence=0.0, reached=False)
    c = tables([demonstration("O1-01", candidate(1, short))]).confusions[0]
    assert (c.wrongly_accepted.total, c.wrongly_refused.hits, c.doubted_succeeded) == (0, 1, 0)


def test_an_object_of_which_nothing_was_accepted_has_all_columns() -> None:
    refused = demonstration("O2-01", candidate(1, Program(False, "slip 13 mm", BAD), reason="simulation: slip 13 mm"))
    found = tables([RESULTS[0], refused, demonstration("O3-01", reason="interpret: nothing")])
    assert [(len(r.harder), r.harder[0].hits) for r in found.rows] == [(1, 0)] * 4
    assert "O2" in text(found, "Title")


def test_a_proof_that_knows_the_outcome_has_all_the_area_and_one_that_guesses_half() -> None:
    told = area_under_curve([(1.0, True), (0.9, True), (0.4, False), (0.1, False)])
    assert told is not None and told[0] == told[2] == 1.0 and 0.2 < told[1] < 0.9  # of four cases, it is not certain
    assert area_under_curve([(1 - score, kind) for score, kind in ((1.0, True), (0.9, True), (0.4, False), (0.1, False))]) == (
        0.0, 0.0, pytest.approx(1 - told[1]),
    )  # fmt: skip
    guessed = area_under_curve([(0.5, k % 2 == 0) for k in range(40)])
    assert guessed is not None and guessed[0] == 0.5 and guessed[1] < 0.4 and guessed[2] > 0.6
    assert area_under_curve([(1.0, True)] * 5) is None


def test_demonstrations_that_failed_are_counted() -> None:
    assert [(r.came_off.hits, r.came_off.total) for r in tables(RESULTS).rows] == [(2, 2), (1, 2), (3, 4)]


def test_reasons_that_differ_in_numbers_are_one() -> None:
    twice = (*RESULTS, demonstration("O3-01", candidate(1, reason="plan: reach 1.7 m")))
    assert ("plan: reach # m", 2) in tables(twice).reasons


def test_text_csv_and_json_say_the_same(tmp_path: Path) -> None:
    found = tables(RESULTS, PUBLISHED)
    said = text(found, "Title")
    assert (
        share(found.rows[0].executed) in said
        and "2 of 6 (33%)" in said
        and "proof against execution at 1 x errors: of the accepted programs 1 of 3" in said
    )
    lines = to_csv(RESULTS).splitlines()
    assert len(lines) == 7 and lines[-1].endswith("interpret: nothing")
    data = json.loads(as_json(to_json(found, RESULTS, {})))
    assert data["rows"][-1]["executed"]["hits"] == 2 and len(data["demonstrations"]) == 4


def test_the_page_stands_alone_and_escapes(tmp_path: Path) -> None:
    odd = (*RESULTS, demonstration("O9-01", reason="<script>alert(1)</script>"))
    page = html("Title", ["about"], tables(odd, PUBLISHED), odd, ["as before"], tmp_path)
    assert "<script>alert" not in page and 'src="http' not in page and "O1-02" in page
    assert page.count("no program") >= 3


def test_thresholds(tmp_path: Path) -> None:
    found = tables(RESULTS)
    assert missed_thresholds(found, ThresholdSpec(solved=0.5, planned=0.8, simulated=0.6, executed=0.4)) == []
    assert missed_thresholds(found, ThresholdSpec(solved=1.0, planned=0.8, simulated=0.0, executed=0.0)) == [
        "solved: 2 of 4 is less than 100%"
    ]


def test_a_baseline_is_compared_cell_by_cell(tmp_path: Path) -> None:
    path = tmp_path / "baseline.json"
    found = tables(RESULTS)
    assert "no baseline" in against_baseline(found, path, "main")[0]
    path.write_text(json.dumps({"main": baseline(found)}))
    assert against_baseline(found, path, "main") == ["as the baseline in every cell"]
    changed = against_baseline(tables(RESULTS[:-1]), path, "main")
    assert "O2, gave: 1 of 2 before, 1 of 1 now" in changed
    path.write_text("{")
    with pytest.raises(UserError, match="damaged"):
        against_baseline(found, path, "main")


def test_a_figure_has_the_rates_of_every_object_and_scale() -> None:
    found = {(n.what, n.part): (n.hits, n.of) for n in numbers(tables(RESULTS))}
    assert found["all", "came off"] == (3, 4) and found["O1", "plan"] == (3, 3) and found["O2", "simulation"] == (1, 2)
    assert (found["all", "execution"], found["all", "execution, 2 x"]) == ((2, 5), (0, 5))
    assert found["all", "solved"] == (2, 4) and {what for what, _ in found} == {"O1", "O2", "all"}
