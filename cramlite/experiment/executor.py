"""Executing texts in another process: it is given a text, a world file and a seed, and nothing else.

``python -m cramlite.experiment.executor`` does what ``cramlite execute`` does, for one text after another, so that a
process need not be started for each (1 s of CPU time, measured; the execution itself takes 3 s).
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO

from msgspec import Struct, json

from ..base.errors import CramliteError, UserError
from ..model.rollout import Rollout, load_rollout, save_rollout
from ..model.world import World
from ..plugin.catalogue import Knowledge
from ..plugin.selection import INSTALLED, PluginChoice
from ..scenario.worlds import read_world


class ExecutorDied(Exception):
    """The process ended in the midst of an execution: killed, out of memory, or a crash."""


class Executor(Struct):
    """The other process; started when it is first asked, and again when it died.

    Args:
        plugins: of its engine.
    """

    plugins: PluginChoice = INSTALLED
    _process: subprocess.Popen[str] | None = None

    def run(self, text: str, suffix: str, world: World, seed: int) -> tuple[Rollout, float]:
        """What happened when a text ran in a world, and the CPU seconds it took.

        Raises:
            ExecutorDied: the process did; the next call starts another one.
            UserError: the text is no program for the world's robot.
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            program, place, out = folder / f"program{suffix}", folder / "world.json", folder / "rollout.npz"
            program.write_text(text, encoding="utf-8")
            place.write_bytes(json.encode(world))
            answer = self._ask({"program": str(program), "world": str(place), "seed": seed, "out": str(out)})
            if answer["said"]:
                raise UserError(f"The execution of a program broke: {answer['said']}")
            return load_rollout(out, world), float(answer["seconds"])

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def _ask(self, job: dict[str, object]) -> dict[str, str]:
        process = self._process = self._process or self._start()
        assert process.stdin is not None and process.stdout is not None
        try:
            print(json.encode(job).decode(), file=process.stdin, flush=True)
            line = process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            code = process.wait()
            self._process = None
            raise ExecutorDied(f"the process that executes programs ended with {code}")
        answer: dict[str, str] = json.decode(line)
        return answer

    def _start(self) -> subprocess.Popen[str]:
        words = [
            *(w for p in self.plugins.files for w in ("--plugin", str(p))),
            *(w for b in self.plugins.blocked for w in ("--block", b)),
            *(w for p in self.plugins.preferred for w in ("--prefer", p)),
        ]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
        return subprocess.Popen(
            [sys.executable, "-m", __name__, *words], env=environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip


def serve(jobs: Iterable[str], answers: IO[str], knowledge: Knowledge) -> None:
    """Do one job after another: a line of JSON each, answered by a line of JSON."""
    begin = 0.0  # the first answer includes the start
    for line in jobs:
        job, said = json.decode(line), ""
        try:
            world = read_world(job["world"], knowledge, job["seed"])
            text = Path(job["program"]).read_text(encoding="utf-8")
            mount = world.robots[0].name
            rollout = knowledge.simulator.execute(text, world, knowledge.robots, mount=mount, seed=job["seed"])
            save_rollout(rollout, Path(job["out"]))
        except CramliteError as error:
            said = str(error)
        now = time.process_time()
        print(json.encode({"said": said, "seconds": now - begin}).decode(), file=answers, flush=True)
        begin = now


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve standard input until it is closed; Ctrl-C is the business of who asks."""
    import argparse
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parser = argparse.ArgumentParser(prog="cramlite.experiment.executor", description=main.__doc__)
    parser.add_argument("--plugin", type=Path, action="append", default=[])
    parser.add_argument("--block", action="append", default=[])
    parser.add_argument("--prefer", action="append", default=[])
    chosen = parser.parse_args(arguments)
    plugins = PluginChoice(tuple(chosen.plugin), tuple(chosen.block), tuple(chosen.prefer))
    answers, sys.stdout = sys.stdout, sys.stderr  # what plugins print is no answer
    serve(sys.stdin, answers, Knowledge(plugins.registry()))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
