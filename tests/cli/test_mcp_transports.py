"""``cramlite mcp`` over stdio and over HTTP on loopback: answers, cancelling, strangers' requests, and what cannot be served."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mcp", reason="the extra cramlite[mcp] is not installed")

import anyio
from helpers.mcp_client import ask
from mcp import Client, StdioServerParameters

from cramlite import UserError
from cramlite.cli.main import main
from cramlite.cli.serving.mcp import serve_mcp

COMMAND = [sys.executable, "-m", "cramlite", "mcp"]


def small(seconds: float = 60.0) -> Any:
    return anyio.fail_after(seconds)


async def cancelled_and_answered(client: Client) -> None:
    """A resolution is cancelled when its program, which would be proven after a minute, begins to run; the next call is answered soon."""
    with anyio.CancelScope() as scope:

        async def begun(number: float, total: float | None, message: str | None) -> None:
            if (message or "").startswith("program 1: "):
                scope.cancel()

        await client.call_tool("resolve", {"scenario": "tasks/pouring"}, progress_callback=begun)
    assert scope.cancelled_caught
    begin = time.monotonic()
    assert not (await client.call_tool("check", {"scenario": "grasp_one_thing"})).is_error
    assert time.monotonic() - begin < 30


async def ended_within_its_run(runs: Path) -> bool:
    """Whether the trace of the first run says that it was stopped before its program was proven. It is written when the run ends, and
    nobody waits for that."""
    while not (traces := list(runs.glob("*/trace.json"))):
        await anyio.sleep(0.05)
    (trace,) = traces
    kinds = [e["kind"] for e in json.loads(trace.read_text())["entries"]]
    return "stop" in kinds and "proof" not in kinds


@pytest.mark.heavy
def test_over_stdio(tmp_path: Path) -> None:
    async def use(client: Client) -> Any:
        with small(120):
            await cancelled_and_answered(client)
            assert await ended_within_its_run(tmp_path / "runs")
            solved = await client.call_tool("resolve", {"scenario": "grasp_one_thing"})
            run = {"run": solved.structured_content["run"]}
            return solved, await client.call_tool("run", run), await client.call_tool("run", {**run, "text": "movej"})

    environment = {**os.environ, "CRAMLITE_TWINS": "0"}
    parameters = StdioServerParameters(command=COMMAND[0], args=[*COMMAND[1:], "--folder", str(tmp_path)], env=environment)
    solved, ran, refused = ask(parameters, use)
    assert solved.structured_content["plan"] == "Grasping"
    assert all(f["passed"] for f in solved.structured_content["findings"])
    assert ran.structured_content["succeeded"] and refused.is_error


@pytest.fixture
def http(tmp_path: Path) -> Iterator[str]:
    started = subprocess.Popen([*COMMAND, "--http", "0", "--folder", tmp_path], stderr=subprocess.PIPE, text=True)
    try:
        assert started.stderr is not None
        said = started.stderr.readline()
        yield said.split()[-1]
    finally:
        started.terminate()
        started.communicate(timeout=30)


@pytest.mark.heavy
def test_over_http(http: str) -> None:
    async def use(client: Client) -> None:
        with small():
            await cancelled_and_answered(client)
            assert (await client.call_tool("run", {"run": "never"})).is_error

    ask(http, use)
    assert http.startswith("http://127.0.0.1:")
    for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):  # a page that a browser shows
        asked = urllib.request.Request(http, b"{}", {"Content-Type": "application/json", **headers})
        with pytest.raises(urllib.error.HTTPError, match=r"421|403"):
            urllib.request.urlopen(asked, timeout=10)
    asked = urllib.request.Request(http, b" " * 2_000_000, {"Content-Type": "application/json"})
    with pytest.raises((urllib.error.HTTPError, ConnectionError, urllib.error.URLError)):
        urllib.request.urlopen(asked, timeout=10)


def test_what_cannot_be_served_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["mcp", "--http", str(port), "--folder", str(tmp_path)]) == 2
    assert re.search(rf"Nothing can be served at 127.0.0.1:{port} \(.*in use\); give another --http PORT", capsys.readouterr().err)
    with pytest.raises(UserError, match="give another --http PORT"):
        serve_mcp(folder=tmp_path, port=70_000)
    with pytest.raises(UserError, match="There is no folder"):
        serve_mcp(folder=tmp_path / "nowhere")


@pytest.mark.parametrize("runs", ["file", "file/runs", None])
def test_runs_go_to_a_folder(runs: str | None, tmp_path: Path) -> None:
    taken = tmp_path / (runs or "runs").split("/")[0]
    taken.write_text("")
    with pytest.raises(UserError, match=f"The runs cannot go to .*: '{taken}' is no folder; give another one with --runs"):
        serve_mcp(folder=tmp_path, runs=tmp_path / runs if runs else None)


def test_nothing_of_it_is_loaded_before_it_is_asked_for() -> None:
    code = "import sys; from cramlite.cli.main import main\ntry: main(['mcp', '--help'])\nexcept SystemExit: pass\n"
    code += "print([m for m in ('mcp', 'anyio', 'uvicorn', 'starlette', 'pydantic') if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.rstrip().endswith("[]")
