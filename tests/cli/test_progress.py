"""Progress of a resolution: one line of a terminal, or lines of a file."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

import pytest

from cramlite.cli.progress import Progress
from cramlite.planning.heartbeat import NowDone

PROGRESS = """
from cramlite.cli.progress import Progress
with Progress(quiet={}) as say:
    say("candidate 1")
    say("trying" + 200 * ".")
    {}
"""


CLEARED = "\x1b[?25h\r\x1b[1A\x1b[2K"  # the cursor is shown, and the line above it is empty


def on_terminal(quiet: bool, then: str = "pass") -> str:
    """What the progress writes where standard error is a terminal."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", PROGRESS.format(quiet, then)]
    subprocess.run(command, stderr=theirs, check=False, env={**os.environ, "TERM": "xterm", "COLUMNS": "80"})
    os.write(theirs, b"END")
    os.close(theirs)
    said = b""
    while not said.endswith(b"END"):
        said += os.read(ours, 10_000)
    os.close(ours)
    return said.decode().removesuffix("END")


def test_progress_stays_in_one_line_of_a_terminal_and_is_cleared() -> None:
    said = on_terminal(quiet=False)
    assert "candidate 1\r" in said and "trying..." in said and said.endswith(CLEARED)
    assert all(len(line) <= 80 for line in said.replace("\x1b[2K", "").replace("\x1b[?25l", "").split("\r")), "what is too long is cut"
    assert CLEARED in on_terminal(quiet=False, then="raise SystemExit(1)")
    assert on_terminal(quiet=True) == ""


def test_a_refusal_stays_on_a_terminal() -> None:
    said = on_terminal(quiet=False, then="say(\"program 1 refused: 'mug' fell\"); say('candidate 2')")
    assert "program 1 refused: 'mug' fell\r\n" in said and said.endswith(CLEARED)


def test_progress_elsewhere_is_lines_of_what_matters() -> None:
    piped = subprocess.run([sys.executable, "-c", PROGRESS.format(False, "pass")], capture_output=True, text=True, check=True).stderr
    assert piped == "[  0.0 s] candidate 1\n"


def test_what_is_done_now_is_said_ever_more_rarely_and_each_event_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress(quiet=False) as say:
        for text in ("program 1: 15 steps", NowDone("program 1 runs, 5 of about 15 s"), NowDone("program 1 runs, 10 of about 15 s")):
            say(text)
        say("1.Grasping: from above")
        say("program 1 refused: 'mug' fell")
        say(NowDone("searching: on(tray)"))
    said = [line.split("] ", 1)[1] for line in capsys.readouterr().err.splitlines()]
    assert said == ["program 1: 15 steps", "program 1 runs, 5 of about 15 s", "program 1 refused: 'mug' fell", "searching: on(tray)"]
