"""Control steps of Python programs for ur_rtde, copied into programs that have some (``ur_rtde_arm``)."""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Callable, Sequence

from .runtime_arm import Arm, Failed, Tripped, log

# ---- control steps: attempts, branches at the same time, monitors ----
Steps = Callable[[Arm], None]


def fallback(arm: Arm, name: str, branches: Sequence[Steps]) -> None:
    """Run branches one after the other until one succeeds; fail with the failure of the last one."""
    for k, branch in enumerate(branches, 1):
        try:
            branch(arm)
            return
        except Failed as failed:
            arm.rest()
            if k == len(branches):
                raise
            log(f"cramlite failed: {name}, attempt {k}: {failed}")


def monitored(
    arm: Arm, name: str, steps: Steps, *, force: float | None = None, slip: float | None = None, time: float | None = None
) -> None:
    """Run steps while limits are checked: of the force [N], of the closing of the fingers since the first step [of 255]
    and of the time [s].

    When a limit is exceeded, the arm is stopped and the steps have failed.
    """
    this, began = object(), arm.time()
    closed = arm.gripper.get("POS") if slip is not None else 0

    def look() -> None:
        if force is not None and (measured := math.hypot(*arm.force())) > force:
            raise Tripped(this, f"{name}: force {measured:.3f} N > {force:g} N")
        if slip is not None and (more := arm.gripper.get("POS") - closed) > slip:
            raise Tripped(this, f"{name}: slip: the fingers closed further by {more} of 255 position counts, more than {slip:g}")
        if time is not None and (waited := arm.time() - began) > time:
            raise Tripped(this, f"{name}: not done after {waited:.3f} s > {time:g} s")

    inside = copy.copy(arm)
    inside.guards = [*arm.guards, look]
    try:
        steps(inside)
    except Tripped as tripped:
        arm.rest()
        if tripped.by is not this:
            raise
        raise Failed(str(tripped)) from None


class Side:
    """Parallel branch of a program that does not move the arm, running in a thread of its own."""

    def __init__(self, arm: Arm, steps: Steps) -> None:
        self.error: Exception | None = None
        self.stopped = False
        self.arm = copy.copy(arm)
        self.arm.guards = [self.end]
        self.thread = threading.Thread(target=self.run, args=(steps,), daemon=True)
        self.thread.start()

    def end(self) -> None:
        if self.stopped:
            raise Tripped(self, "stopped")

    def run(self, steps: Steps) -> None:
        try:
            steps(self.arm)
        except Exception as error:
            self.error = error

    def stop(self) -> None:
        """End this parallel branch of the program; the fingers stop where they are."""
        if self.thread.is_alive():
            self.stopped = True
            self.thread.join()
            self.arm.gripper.set("POS", self.arm.gripper.get("POS"))


def parallel(arm: Arm, name: str, main: Steps, sides: Sequence[Steps], *, until: str) -> None:
    """Run branches at the same time until "all" of them have succeeded, or the "first" one has; only the branch
    ``main`` moves the arm."""
    others = [Side(arm, s) for s in sides]

    def settled() -> bool:
        ended = [o for o in others if not o.thread.is_alive()]
        return any((o.error is None) == (until == "first") for o in ended)

    def look() -> None:
        if settled():
            raise Tripped(others, f"{name}: another branch has ended")

    inside = copy.copy(arm)
    inside.guards = [*arm.guards, look]
    failure: Exception | None = None
    try:
        main(inside)
        if until == "all":
            inside.wait(lambda: not any(o.thread.is_alive() for o in others), math.inf)
    except Failed as failed:
        failure = failed
        if until == "first":
            arm.wait(lambda: settled() or not any(o.thread.is_alive() for o in others), math.inf)
    except Tripped as tripped:
        arm.rest()
        if tripped.by is not others:
            raise
    finally:
        for other in others:
            other.stop()
    raise_failure(name, failure, [o.error for o in others if not isinstance(o.error, Tripped)], until)


def raise_failure(name: str, failure: Exception | None, errors: Sequence[Exception | None], until: str) -> None:
    """Raise the failure of parallel branches, unless enough of them have succeeded."""
    failures = [f for f in (failure, *errors) if f is not None]
    for worse in failures:
        if not isinstance(worse, Failed):
            raise worse
    if failures and (until == "all" or len(failures) == 1 + len(errors)):
        raise Failed(str(failures[0]))
