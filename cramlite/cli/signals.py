"""Process signals that end a command: Ctrl+C, and SIGTERM of ``timeout``, job queues and CI."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from ..base.errors import CramliteError
from ..base.pulse import Stopped

SIGNALS = (signal.SIGINT, signal.SIGTERM)
KILLED = 128
"""Number to which a signal's number is added to give the exit code of a command that the signal ended (POSIX shells)."""


class Interrupted(CramliteError):
    """Exception that ends a command after a signal such as Ctrl+C; its message says what was found before.

    Args:
        message: one paragraph.
        number: of the signal.
    """

    def __init__(self, message: str, number: int = signal.SIGINT) -> None:
        super().__init__(message)
        self.exit_code = KILLED + number


class Signals:
    """Record of received process signals; long work asks it whether to end."""

    def __init__(self) -> None:
        self.number = 0
        """The first signal that came; 0 for none."""

    def one(self) -> bool:
        """Check whether a process signal such as Ctrl+C came."""
        return self.number != 0

    def take(self, number: int, frame: FrameType | None) -> None:
        """Record a signal, and restore the default handlers, so that a second signal ends the process."""
        self.number = number
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


@contextmanager
def interruptible(left: str = "what was written so far is kept") -> Iterator[Signals]:
    """Catch signals in this block; only in the main thread, since Python delivers signals to no other.

    Args:
        left: what is there of the work that was ended.

    Raises:
        Interrupted: work in the block ended since a signal came.
    """
    taken = Signals()
    main = threading.current_thread() is threading.main_thread()
    before = {number: signal.signal(number, taken.take) for number in SIGNALS if main}
    try:
        yield taken
    except Stopped:
        raise Interrupted(f"interrupted; {left}.", taken.number) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
