"""Execution of program texts in a process of its own, which is given a text, a world and a seed, and nothing else.

It does what ``cramlite execute`` does, for one text after another, so that a process need not be started for each (1 s of CPU
time, measured; the execution itself takes 1 to 3 s). It is started as a module, so that the caller's own script is not
imported again, as ``multiprocessing`` would.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, BinaryIO

from msgspec import Struct

from ...base.errors import UserError
from ...base.pulse import Stopped, pulse
from ...plugin.selection import INSTALLED, PluginChoice

if TYPE_CHECKING:
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...plugin.catalogue import Knowledge


ENDS_RUN: int | None = getattr(signal, "SIGUSR1", None)
"""Signal that tells the executing process to end its present run; None on systems without such a signal."""


class ExecutorDied(Exception):
    """Error: the process that executes program texts died during an execution (killed, out of memory, or a crash)."""


class Executor(Struct):
    """Process that executes program texts; it is started at the first request, and anew after it has died.

    Args:
        plugins: of its engine.
    """

    plugins: PluginChoice = INSTALLED
    _process: subprocess.Popen[bytes] | None = None
    _spent: float = 0.0

    @property
    def pid(self) -> int | None:
        """Process id of the executing process; None while there is none."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the executing process if it does not run yet, without waiting until it has loaded its plugins."""
        if self._process is None:
            path = os.pathsep.join(p for p in sys.path if p)
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                env={**os.environ, "PYTHONPATH": path},
            )  # fmt: skip
            self._say(self.plugins)

    def run(self, text: str, world: World, seed: int) -> tuple[Rollout, float]:
        """Run a program text in a world; return the rollout, and the CPU time that it took [s].

        The first run's time includes the start of the process.

        Raises:
            ExecutorDied: the process did; the next call starts another one.
            UserError: the text is no program for the world's robot.
        """
        self.start()
        self._say((text, world, seed))
        answer = self._hear()
        if isinstance(answer, UserError):
            raise UserError(f"The execution of a program was broken off: {answer}") from answer
        if isinstance(answer, Exception):
            raise answer
        rollout, now = answer
        seconds, self._spent = now - self._spent, now
        return rollout, seconds

    def interrupt(self) -> None:
        """Interrupt the run in the executing process, which then answers with an error, and keep the process.

        On systems without such a signal the run goes on to its end.
        """
        if self._process is not None and ENDS_RUN is not None:
            self._process.send_signal(ENDS_RUN)

    def close(self) -> None:
        """End the executing process after its present request; the next run starts a new process."""
        if self._process is not None:
            self._process.communicate()
        self._process, self._spent = None, 0.0

    def kill(self) -> None:
        """Kill the executing process at once; a run that is under way raises ExecutorDied in the thread that waits for
        it."""
        if self._process is not None:
            self._process.kill()

    def end(self) -> None:
        """Kill the executing process and wait for its end; any thread may call this, also while another thread waits
        for an answer."""
        process, self._process, self._spent = self._process, None, 0.0
        if process is not None:
            with suppress(OSError), process:
                process.kill()

    def _say(self, what: object) -> None:
        process = self._process
        if process is None or process.stdin is None:
            return
        with suppress(OSError, ValueError):  # it died, or was ended: seen when it does not answer
            pickle.dump(what, process.stdin)
            process.stdin.flush()

    def _hear(self) -> Any:
        process = self._process
        if process is None or process.stdout is None:
            raise ExecutorDied("the process that executes programs was ended")
        try:
            return pickle.load(process.stdout)
        except (EOFError, pickle.UnpicklingError, ValueError) as error:
            process.kill()
            process.wait()
            self._process, self._spent = None, 0.0
            raise ExecutorDied("the process that executes programs ended") from error


class _Interrupted:
    """Handler of the signal ``ENDS_RUN``, which tells whether the signal has come and the present run must end."""

    def __init__(self) -> None:
        self.came = False
        if ENDS_RUN is not None:
            signal.signal(ENDS_RUN, self._heard)

    def _heard(self, *_: object) -> None:
        self.came = True


def _serve(asked: BinaryIO, answers: BinaryIO) -> None:
    """Run program texts that the caller sends to this process, until the caller sends no further one, or has
    ended."""
    parent, interrupted = os.getppid(), _Interrupted()
    try:
        knowledge = _loaded(pickle.load(asked))
        while True:
            text, world, seed = pickle.load(asked)
            interrupted.came = False
            answer: object
            try:
                with pulse(lambda: interrupted.came or os.getppid() != parent):
                    answer = _execute(knowledge, text, world, seed)
            except Stopped:
                if not interrupted.came:  # whoever asked is gone
                    return
                answer = UserError("the run was stopped, since its result is not needed any more")
            pickle.dump(answer, answers)
            answers.flush()
    except (EOFError, OSError):  # whoever asked is gone
        return


def _loaded(plugins: PluginChoice) -> Knowledge | Exception:
    """Load the plugins and the simulator's libraries; return what the plugins declare, or the error."""
    from ...model.world.world import World
    from ...plugin.catalogue import Knowledge

    try:
        knowledge = Knowledge(plugins.registry())
        knowledge.simulator.check(World(()), knowledge.robots)
    except Exception as error:
        return error
    return knowledge


def _execute(knowledge: Knowledge | Exception, text: str, world: World, seed: int) -> object:
    """Run a program text; return the rollout and the CPU time of this process so far [s], or the error."""
    try:
        if isinstance(knowledge, Exception):
            raise knowledge
        rollout = knowledge.run(text, world, seed)
    except UserError as error:
        return error
    except Exception as error:  # one that cannot be sent would leave the caller waiting
        return RuntimeError(f"{type(error).__name__}: {error}")
    return rollout, time.process_time()


def _main() -> None:
    """Serve requests until there are no more: Ctrl-C is left to the caller, and prints of plugins stay out of
    the answers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with os.fdopen(os.dup(0), "rb") as asked, os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        _serve(asked, answers)


if __name__ == "__main__":
    _main()
