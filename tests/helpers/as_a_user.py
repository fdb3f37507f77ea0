"""Shipped scenarios as a user runs and changes them: the command line, in this process.

That a process of its own says the same is what test_cli.py, test_bad_input.py, test_plan.py and .ci/run see to.
"""

from __future__ import annotations

import io
import signal
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from subprocess import CompletedProcess

from cramlite.cli.main import main


def cramlite(*arguments: object) -> CompletedProcess[str]:
    """Run a command in this process, and return its exit code, standard output and standard error."""
    words, out, err = [str(a) for a in arguments], io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main(words)
        except SystemExit as stop:
            code = int(stop.code or 0)
    return CompletedProcess(words, code, out.getvalue(), err.getvalue())


def changed(scenario: Path, folder: Path, *changes: tuple[str, str]) -> Path:
    """Write a variant of a shipped scenario with some text replaced; each replacement must change the text."""
    text = scenario.read_text().replace("demonstration: ", f"demonstration: {scenario.parent}/", 1)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "variant.yaml"
    path.write_text(text)
    return path


def hears_ctrl_c() -> None:
    """Make Ctrl-C end the next command of this process, also in a test run in the background of a shell, which ignores Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
