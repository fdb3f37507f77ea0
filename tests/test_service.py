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

from cramlite import Engine
from cramlite.service import LONGEST_LINE, Service

COMMAND = [sys.executable, "-m", "cramlite.cli", "serve"]


def _answers(*lines: str) -> list[dict[str, Any]]:
    out = io.StringIO()
    assert Service(Engine(), io.StringIO("".join(line + "\n" for line in lines)), out).run() == 0
    return [json.loads(line) for line in out.getvalue().splitlines()]


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
        ('{"id": {}, "method": "tasks"}', -32600, "'id' a number or text"),
        ('{"id": 1, "method": "tasks", "params": []}', -32600, "'params' is an object"),
        ('"' + "x" * (LONGEST_LINE + 10) + '"', -32600, "at most"),
    ],
    ids=lambda v: str(v)[:20],
)
def test_garbage_is_answered_and_does_no_harm(line: str, code: int, says: str) -> None:
    first, *rest = _answers(line, _request(7, "check", scenario="grasp_one_thing"))
    assert first["id"] is None
    assert first["error"]["code"] == code
    assert says in first["error"]["message"]
    assert [r["id"] for r in rest] == [7] and rest[0]["result"]["robot"] == "ur5e"


@pytest.mark.parametrize(
    ("request_", "code", "says"),
    [
        (_request(1, "rezolve"), -32601, "did you mean 'resolve'?"),
        (_request(1, "resolve"), -32602, "'scenario' is missing"),
        (_request(1, "resolve", scenario="grasp_one_thing", seed="x"), -32602, "'seed' is a whole number"),
        (_request(1, "next", of=3), -32602, "the id of a 'resolve' before"),
        (_request(1, "check", scenario="grasp_one_thin"), 2, "did you mean 'grasp_one_thing'?"),
        (_request(1, "interpret", episode="/nowhere"), 2, "There is no episode"),
        (_request(1, "resolve", scenario="tasks/grasping_fails"), 1, "No solution"),
    ],
)
def test_requests_that_cannot_be_answered(request_: str, code: int, says: str) -> None:
    answer = _answers(request_)[-1]
    assert answer["id"] == 1
    assert answer["error"]["code"] == code
    assert says in answer["error"]["message"]


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
    assert second["result"]["code"] != first["result"]["code"]
    process.stdin.close()
    assert process.wait(30) == 0


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


def test_what_was_asked_is_answered_when_the_input_ends() -> None:
    (answer,) = _answers(_request(1, "check", scenario="grasp_one_thing"))
    assert answer["result"]["scenario"] == "grasp_one_thing"
