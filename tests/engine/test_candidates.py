"""Candidate task sequences with their attempts: what ``resolve`` and the experiment are built on."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite import Budget, Engine, Interpretation, Trace, find_scenario, read_scenario
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
    """One action by which the thing leaves the peg and is let go, where no task does both."""
    scenario, trace = read_scenario(find_scenario("fetch_from_hanger")), Trace()
    reading = ENGINE.read(scenario)
    found, episode = reading.interpretation, reading.episode
    assert found is not None and episode is not None
    ends = [m for a in found.actions for m in a.matches if m.task in ("artm:ExtractHoleFromPeg", "artm:Ungrasping")]

    def plans(interpretation: Interpretation) -> int:
        return len(list(plans_from_interpretation("it", interpretation, episode, ENGINE.knowledge.tasks, trace)))

    assert plans(replace(found, actions=(replace(found.actions[2], matches=tuple(ends)),))) == 0
    assert [e.reason for e in trace.entries] == ["2 readings, none agrees with itself; 0 actions unexplained"]
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
