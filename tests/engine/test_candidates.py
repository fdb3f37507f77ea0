"""Candidate task sequences with their attempts, on which ``resolve`` and the experiment are built."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Budget, Engine, Interpretation, Setting, Trace, find_scenario, read_scenario
from cramlite.engine.recording import record_episode
from cramlite.model import Episode
from cramlite.planning.refutation import InTask
from cramlite.planning.search.budget import PROOF
from cramlite.planning.task_sequences import plans_from_interpretation

ENGINE = Engine()


def test_what_was_refused_is_an_attempt_and_no_solution() -> None:
    scenario, trace, lines = read_scenario(find_scenario("tasks/grasping_fails")), Trace(), list[str]()
    found = list(ENGINE.candidates(scenario, budget=Budget(proofs=1), trace=trace, progress=lines.append))
    assert [(c.number, c.sequence) for c in found] == [(1, None)]
    assert not lines and not trace.entries  # nothing is tried before its attempts are asked for
    (attempt,) = found[0].attempts()
    assert attempt.code and not attempt.verdict.passed and attempt.number == 1
    assert lines[0].startswith("candidate 1:") and trace.entries
    assert list(ENGINE.resolve(scenario, budget=Budget(proofs=1))) == []


def test_candidates_are_the_readings_that_agree_with_themselves() -> None:
    scenario = read_scenario(find_scenario("fetch_from_hanger"))
    reading, trace = ENGINE.read(scenario), Trace()
    assert reading.interpretation is not None
    listed = [s.matches for s in reading.interpretation.sequences()]
    found = list(ENGINE.candidates(reading))
    assert [c.sequence.matches for c in found if c.sequence] == listed and len(found) == len(listed) == 4
    assert len(list(ENGINE.candidates(reading, budget=Budget(sequences=1), trace=trace))) == 1
    assert "sequences = 1" in [e.designator + e.text for e in trace.entries][-1]


def test_where_every_reading_contradicts_itself_the_trace_says_so() -> None:
    """Every reading contradicts itself: in one action the thing leaves the peg and is let go of, which no task does together."""
    scenario, trace = read_scenario(find_scenario("fetch_from_hanger")), Trace()
    reading = ENGINE.read(scenario)
    found, episode = reading.interpretation, reading.episode
    assert found is not None and episode is not None
    ends = [m for a in found.actions for m in a.matches if m.task in ("artm:ExtractHoleFromPeg", "artm:Ungrasping")]

    def plans(interpretation: Interpretation) -> int:
        return len(list(plans_from_interpretation("it", interpretation, episode, ENGINE.knowledge.tasks, trace)))

    assert plans(replace(found, actions=(replace(found.actions[2], matches=tuple(ends)),))) == 0
    assert [e.reason for e in trace.entries] == ["2 readings, none of them consistent; 0 actions that no task explains"]
    assert plans(found) == 4 and len(trace.entries) == 1


def test_planning_and_proof_are_timed_apart() -> None:
    """The program is handed over once planning is done; nothing was run in twins; a search that made no program has no such time."""
    trace = Trace()
    assert trace.first_program is None and set(trace.seconds.values()) == {0.0}
    scenario = read_scenario(find_scenario("tasks/grasping_fails"))
    found = list(ENGINE.candidates(scenario, budget=Budget(proofs=1), trace=trace))
    assert trace.seconds["planning"] < 0.01 and trace.first_program is None
    (attempt,) = found[0].attempts()
    assert trace.first_program is not None and 0.0 < trace.first_program <= attempt.seconds["planning"]
    assert attempt.seconds["proof"] > 0.01 and attempt.seconds["twins"] == 0.0
    assert list(attempt.seconds) == ["planning", "proof", "twins"]


@pytest.fixture(scope="module")
def touched(tmp_path_factory: pytest.TempPathFactory) -> Episode:
    """A person touched the basket before drawing back; the robot drops its payload from above it."""
    scenario = read_scenario(find_scenario("fetch_from_hanger"))
    return record_episode(scenario, ENGINE, seed=1007, out=tmp_path_factory.mktemp("touched") / "shown").episode


@pytest.fixture(scope="module")
def setting() -> Setting:
    return ENGINE.setting(read_scenario(find_scenario("fetch_from_hanger")), seed=1007, twins=0)


@pytest.mark.parametrize(("work", "proofs"), [(PROOF // 2, 0), (3 * PROOF // 2, 1)])
def test_a_budget_of_work_is_one_for_all_task_sequences(setting: Setting, work: int, proofs: int) -> None:
    """A proof counts as many expansions; what is used up ends the sequence under way, and no other is begun."""
    scenario, trace = read_scenario(find_scenario("fetch_from_hanger")), Trace()
    found = ENGINE.candidates(scenario, setting=setting, budget=Budget(work=work), trace=trace)
    assert [sum(1 for _ in candidate.attempts()) for candidate in found] == [proofs]
    assert [e.numbers for e in trace.entries if "work" in e.numbers] == [{"work": work}]


def test_a_reading_that_the_validators_of_every_program_objected_to_is_put_off(touched: Episode, setting: Setting) -> None:
    trace, listed = Trace(), [c.sequence for c in ENGINE.candidates(touched, setting=setting) if c.sequence]
    found = ENGINE.candidates(touched, setting=setting, trace=trace)
    first = next(found)
    last = len(listed[0].matches)
    first.effort.judged(frozenset({InTask(1), InTask(last)}))
    first.effort.judged(frozenset({InTask(last)}))  # so the first task was not to blame for both
    [reading] = first.doubted
    assert reading[1] == listed[0].matches[-1]
    again = [s for s in listed[1:] if reading in zip(s.actions, s.matches, strict=True)]
    after = [c.sequence for c in found if c.sequence]
    late = [s for s in after if s in again]
    assert 0 < len(again) < len(listed) - 1 and after[len(after) - len(late) :] == late != after
    assert sum(e.outcome == "nogood" and reading[1].task in e.reason for e in trace.entries) >= len(again)


def test_readings_that_one_program_did_without_objection_keep_their_rank(touched: Episode, setting: Setting) -> None:
    listed = [c.sequence for c in ENGINE.candidates(touched, setting=setting)]
    found = ENGINE.candidates(touched, setting=setting)
    first = next(found)
    first.effort.judged(frozenset({InTask(1)}))
    first.effort.judged(frozenset({InTask(2)}))
    assert first.doubted == [] and [first.sequence, *(c.sequence for c in found)] == listed


@pytest.mark.heavy
def test_a_person_who_touched_the_basket_is_understood_as_one_who_let_go(touched: Episode, setting: Setting) -> None:
    trace = Trace()
    solution = next(ENGINE.resolve(touched, setting=setting, seed=1007, budget=Budget(proofs=1), trace=trace))
    tasks = [a.task.split(":")[-1] for a in solution.candidate.plan.actions]
    assert tasks == ["Grasping", "ExtractHoleFromPeg", "Transporting", "Ungrasping"] and solution.number == 2
    assert any(e.kind == "proof" and e.outcome == "failed" and "Retracting" in e.reason for e in trace.entries)
