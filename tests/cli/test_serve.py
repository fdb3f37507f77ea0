"""``cramlite serve``: requests in JSON lines; garbage is answered, a client that hangs up ends the work."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine
from cramlite.cli.serving.serve import LONGEST_LINE, PARAMS, Service

COMMAND = [sys.executable, "-m", "cramlite", "serve"]


def _answers(*lines: str) -> list[dict[str, Any]]:
    out = io.StringIO()
    assert Service(Engine(), io.StringIO("".join(line + "\n" for line in lines)), out).run() == 0
    return [json.loads(line, parse_constant=_no_number) for line in out.getvalue().splitlines()]


def _no_number(text: str) -> None:
    raise AssertionError(f"{text} is no JSON")


def _request(id_: int, method: str, **params: Any) -> str:
    return json.dumps({"id": id_, "method": method, "params": params})


@pytest.mark.parametrize(
    ("line", "code", "says"),
    [
        ("garbage", -32700, "no JSON"),
        ("\x00\xff", -32700, "no JSON"),
        ("[" * 100_000, -32700, "no JSON"),
        ("[]", -32600, "a request is an object"),
        ('{"id": 1}', -32600, "a request is an object"),
        ('{"id": {}, "method": "tasks"}', -32600, "'id' is a number or text"),
        ('{"id": 1, "method": "tasks", "params": []}', -32600, "'params' is an object"),
        ('{"id": true, "method": "tasks"}', -32600, "'id' is a number or text"),
        ('{"id": 1e400, "method": "tasks"}', -32700, "no finite number"),
        ('{"id": NaN, "method": "tasks"}', -32700, "no finite number"),
        ('{"id": 1, "method": "cancel"}', -32602, "there are: none"),
        ('{"id": 1, "method": "cancel", "params": {"id": [1]}}', -32602, "whose search goes on, not [1]"),
        ('{"id": 1, "method": "cancel", "params": {"id": 77}}', -32602, "whose search goes on, not 77"),
        ('{"id": 1, "method": "next", "params": {"of": {}}}', -32602, "whose search can go on, not {}"),
        ('{"id": 1, "method": "check", "params": {"sead": 1}}', -32602, "no param 'sead'; did you mean 'seed'?"),
        ('"' + "x" * (LONGEST_LINE + 10) + '"', -32600, "at most"),
    ],
    ids=lambda v: str(v)[:20],
)
def test_garbage_is_answered_and_does_no_harm(line: str, code: int, says: str) -> None:
    first, *rest = _answers(line, _request(7, "check", scenario="grasp_one_thing"))
    assert first["id"] == (1 if line.startswith(('{"id": 1,', '{"id": 1}')) else None)
    assert first["error"]["code"] == code
    assert says in first["error"]["message"]
    assert [r["id"] for r in rest] == [7] and rest[0]["result"]["robot"] == "ur5e"


@pytest.mark.parametrize(
    ("request_", "code", "says"),
    [
        (_request(1, "rezolve"), -32601, "did you mean 'resolve'?"),
        (_request(1, "resolve"), -32602, "'scenario' is missing"),
        (_request(1, "resolve", scenario="grasp_one_thing", seed="x"), -32602, "'seed' is a whole number"),
        (_request(1, "next", of=3), -32602, "the id of a 'resolve' whose"),
        (_request(1, "check", scenario="grasp_one_thin"), 2, "did you mean 'grasp_one_thing'?"),
        (_request(1, "check", scenario="grasp_one_thing", seed=-1), 2, "The seed is -1"),
        (_request(1, "interpret", episode="/nowhere"), 2, "There is no episode"),
        (_request(1, "resolve", scenario="tasks/parking_arms_fails"), 1, "No solution"),
    ],
)
def test_requests_that_cannot_be_answered(request_: str, code: int, says: str) -> None:
    answer = _answers(request_)[-1]
    assert answer["id"] == 1
    assert answer["error"]["code"] == code
    assert says in answer["error"]["message"]


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


ODD = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)
NAMES = [*PARAMS, *sum(PARAMS.values(), ()), "method", "params", ""]
REQUESTS = st.lists(
    st.fixed_dictionaries(
        {}, optional={"id": ODD, "method": st.sampled_from(NAMES) | ODD, "params": st.dictionaries(st.sampled_from(NAMES), ODD) | ODD}
    )
    | ODD,
    min_size=1,
    max_size=4,
)


@examples(40)
@given(requests=REQUESTS)
def test_any_json_is_answered_once_and_does_no_harm(requests: list[Any], engine: Engine) -> None:
    out, last = io.StringIO(), _request(7, "check", scenario="grasp_one_thing")
    lines = [json.dumps(r) for r in requests] + [json.dumps({"id": "last", "method": "nothing"})]
    assert Service(engine, io.StringIO("\n".join([*lines, last])), out).run() == 0
    answers = [json.loads(line, parse_constant=_no_number) for line in out.getvalue().splitlines()]
    assert len(answers) == len(requests) + 2
    assert all(("result" in a) != ("error" in a) for a in answers)
    assert not [a for a in answers if "error" in a and a["error"]["code"] in (-32603, 3)]
    assert any(a["id"] == 7 and "result" in a for a in answers)


@pytest.fixture
def process() -> Iterator[subprocess.Popen[str]]:
    started = subprocess.Popen(
        COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    yield started
    started.kill()
    started.wait()
    for stream in (started.stdin, started.stdout, started.stderr):
        with contextlib.suppress(BrokenPipeError):
            stream.close()  # type: ignore[union-attr]


def test_a_program_and_the_next_one(process: subprocess.Popen[str]) -> None:
    lines = [_request(1, "resolve", scenario="grasp_one_thing"), _request(2, "next", of=1)]
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write("\n".join(lines) + "\n")
    process.stdin.flush()
    answers = []
    while len(answers) < 2:
        said = json.loads(process.stdout.readline())
        if "progress" not in said:
            answers.append(said)
    first, second = answers
    assert first["result"]["plan"] == "Grasping"
    assert first["result"]["objects"] == {"something": "coffee"}
    assert all(f["passed"] for f in first["result"]["findings"])
    assert first["result"]["left_out"] == []
    assert second["result"]["code"] != first["result"]["code"]
    process.stdin.close()
    assert process.wait(30) == 0


@pytest.mark.heavy
def test_a_run_tells_each_notice_and_has_a_time_line(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None and process.stdout is not None
    scene = {
        "scenario": "moved", "goal": ["block on shelf"], "robot": {"type": "ur5e"}, "proof": {"twins": 0},
        "faults": [{"moved": "block", "by": [0, 0.06, 0], "near": "block", "within": 0.18}],
        "things": [
            {"name": "floor", "model": "table", "at": {"position": [0.2, 0, -0.005]}, "with": {"size": [1.6, 1.6, 0.02]}},
            {"name": "block", "model": "block", "at": {"position": [0.5, 0.2, 0.051]}, "with": {"size": [0.05, 0.05, 0.1]}},
            {"name": "shelf", "model": "table", "at": {"position": [0.45, -0.35, 0.15]}, "with": {"size": [0.25, 0.25, 0.02]}},
        ],
    }  # fmt: skip
    process.stdin.write(_request(1, "resolve", scenario=scene) + "\n" + _request(2, "run", of=1) + "\n" + _request(3, "run", of=9) + "\n")
    process.stdin.flush()
    heard = []
    while not heard or heard[-1]["id"] != 3:
        heard.append(json.loads(process.stdout.readline()))
    (notice,) = (a["notice"] for a in heard if "notice" in a)
    assert (notice["kind"], notice["thing"], notice["unit"]) == ("ObjectMoved", "block", "m") and notice["measured"] > notice["limit"]
    assert "goes on" in notice["decision"] and notice["to_do"]
    result = next(a["result"] for a in heard if a["id"] == 2 and "result" in a)
    assert result["succeeded"] and [m["what"] for m in result["time_line"]] == ["fault", "notice", "decision", "resumption", "end"]
    assert heard[-1]["error"]["code"] == -32602 and "'of' is the id of a 'resolve'" in heard[-1]["error"]["message"]


def test_cancel(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(_request(1, "resolve", scenario="fetch_from_hanger") + "\n")
    process.stdin.flush()
    assert "progress" in json.loads(process.stdout.readline())
    process.stdin.write(_request(2, "cancel", id=1) + "\n")
    process.stdin.flush()
    said = [json.loads(process.stdout.readline()) for _ in range(1)]
    while not any(s.get("id") == 1 and "progress" not in s for s in said):
        said.append(json.loads(process.stdout.readline()))
    assert {"id": 2, "result": {"cancelled": 1}} in said
    assert said[-1]["error"] == {"code": 1, "message": "cancelled"}


@pytest.mark.heavy
def test_cancel_within_a_run_and_the_next_request(process: subprocess.Popen[str]) -> None:
    """The program would run for 30 s of simulated time, and be proven then."""
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(_request(1, "resolve", scenario="tasks/pouring") + "\n")
    process.stdin.flush()
    said = (json.loads(line) for line in process.stdout)
    assert any(s["progress"].startswith("program 1: ") for s in said)
    process.stdin.write(_request(2, "cancel", id=1) + "\n" + _request(3, "interpret", episode="nothing") + "\n")
    process.stdin.flush()
    answers = [next(s for s in said if "progress" not in s) for _ in range(3)]
    assert [a["id"] for a in answers] == [2, 1, 3]
    assert answers[1]["error"] == {"code": 1, "message": "cancelled"}
    assert answers[2]["error"]["code"] == 2, "it was worked off: there is no such episode"


@pytest.mark.heavy
def test_a_request_for_the_next_program_is_cancelled_by_its_own_id(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None and process.stdout is not None
    said = (json.loads(line) for line in process.stdout)
    process.stdin.write(_request(1, "resolve", scenario="grasp_one_thing") + "\n")
    process.stdin.flush()
    assert any("result" in s for s in said)
    process.stdin.write(_request(2, "next", of=1) + "\n" + _request(3, "cancel", id=2) + "\n" + _request(4, "next", of=1) + "\n")
    process.stdin.flush()
    answers = {s["id"]: s for s in (next(s for s in said if "progress" not in s) for _ in range(3))}
    assert answers[2]["error"] == {"code": 1, "message": "cancelled"}
    assert "can go on, not 1" in answers[4]["error"]["message"]


@pytest.mark.heavy
def test_a_client_that_hangs_up(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None and process.stdout is not None and process.stderr is not None
    process.stdin.write(_request(1, "resolve", scenario="fetch_from_hanger") + "\n")
    process.stdin.flush()
    process.stdout.readline()
    process.stdout.close()
    process.stdin.close()
    assert process.wait(120) == 0
    assert "Traceback" not in (said := process.stderr.read())
    assert "Exception" not in said


@pytest.mark.heavy
@pytest.mark.parametrize("asked", [_request(1, "resolve", scenario="fetch_from_hanger"), _request(1, "tasks")])
def test_a_client_that_closes_only_its_end_of_the_answers(process: subprocess.Popen[str], asked: str) -> None:
    """Whether a search is going on, or nothing is to be done."""
    assert process.stdin is not None and process.stdout is not None and process.stderr is not None
    process.stdin.write(asked + "\n")
    process.stdin.flush()
    process.stdout.readline()
    assert process.poll() is None
    process.stdout.close()
    assert process.wait(120) == 0
    assert not process.stderr.read()


def test_an_id_is_in_use_until_it_is_answered() -> None:
    first, second = _answers(_request(1, "check", scenario="grasp_one_thing"), _request(1, "tasks"))
    assert "is not answered yet" in (first.get("error") or second["error"])["message"]


def test_what_was_asked_is_answered_when_the_input_ends() -> None:
    (answer,) = _answers(_request(1, "check", scenario="grasp_one_thing"))
    assert answer["result"]["scenario"] == "grasp_one_thing"


ROOM = {
    "scenario": "room",
    "goal": ["tin held"],
    "robot": {"type": "ur5e"},
    "things": [
        {"name": "tray", "model": "table", "at": {"position": [0.45, -0.35, 0.15]}, "with": {"size": [0.3, 0.3, 0.02]}},
        {"name": "tin", "model": "block", "at": {"position": [0.5, 0.2, 0.031]}},
    ],
}


def test_a_scenario_and_a_goal_may_be_data() -> None:
    (checked,) = _answers(_request(1, "check", scenario=ROOM, goal=[{"goal": "on", "things": ["tin", "tray"]}]))
    assert checked["result"] == {"scenario": "room", "robot": "ur5e", "things": ["tray", "tin"]}
    (wrong,) = _answers(_request(1, "check", scenario=ROOM, goal=[{"things": ["tin"]}]))
    assert wrong["error"]["code"] == 2 and "a goal as data is" in wrong["error"]["message"]
    (key,) = _answers(_request(1, "check", scenario={**ROOM, "robt": 1}))
    assert key["error"]["code"] == 2 and "unknown key 'robt'; did you mean 'robot'?" in key["error"]["message"]


def test_a_scenario_that_only_says_where_starts_from_the_goal_that_is_asked() -> None:
    where = {key: value for key, value in ROOM.items() if key not in ("goal", "tasks", "designator")}
    (checked,) = _answers(_request(1, "check", scenario=where, goal=["tin on tray"]))
    assert checked["result"] == {"scenario": "room", "robot": "ur5e", "things": ["tray", "tin"]}
    (wrong,) = _answers(_request(1, "check", scenario=where))
    assert "this one has none" in wrong["error"]["message"]


def test_where_nothing_is_found_each_part_of_a_goal_has_its_answer() -> None:
    *_, said = _answers(_request(1, "resolve", scenario=ROOM, goal=["tin in tray", "tray off tin"]))
    assert said["error"]["code"] == 1
    tin, tray = said["error"]["data"]["goal"]
    assert (tin["answer"], tray["answer"]) == ("missed", "holds") and "no task's rule makes" in tin["reason"]


@pytest.mark.parametrize("goal", ["cup in drawer", "nothing_there on shelf"])
def test_check_refuses_a_goal_as_resolve_does(goal: str) -> None:
    scenario = {"scenario": "place_on_shelf", "goal": [goal]}
    checked, *_ = _answers(_request(1, "check", **scenario))
    *_, resolved = _answers(_request(1, "resolve", **scenario))
    assert checked["error"]["code"] == 2 and checked == resolved, checked
    assert goal.split()[0] in checked["error"]["message"]


def test_check_takes_a_goal_about_what_is_there() -> None:
    answer, *_ = _answers(_request(1, "check", scenario="hang_up_a_product"))
    assert answer["result"]["things"]
