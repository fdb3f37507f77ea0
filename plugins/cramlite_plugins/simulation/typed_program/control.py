"""Control steps of typed programs: attempts, repetition, parallel branches, monitors.

A branch is a generator. Stopping one closes it and brings the arm to rest; the fingers of a stopped branch stay where they
are. Meaning: ``cramlite.model.Control``, and backends/urscript/flow.py for the same in URScript.
"""

from __future__ import annotations

from cramlite.model import AnyStep, Fallback, Monitor, Parallel, Repeat, uses_arm

from .steps import Cycles, Running, StepFailed, brake, force

FAILED = "cramlite failed: "
"""Beginning of the message about a failed attempt, after which the program continues."""
STOP = 2.0  # deceleration of what is stopped from outside [rad/s2 or m/s2]


def fallback(run: Running, step: Fallback) -> Cycles:
    """Execute branches in turn until one succeeds; if the last one fails, its failure is that of the step."""
    for k, branch in enumerate(step.branches, 1):
        try:
            yield from run.perform(branch)
            return
        except StepFailed as failed:
            if k == len(step.branches):
                raise
            run.log(f"{FAILED}{_label(step)}, attempt {k}: {failed}")


def repeat(run: Running, step: Repeat) -> Cycles:
    """Execute steps a number of times."""
    for _ in range(step.count):
        yield from run.perform(step.steps)


def parallel(run: Running, step: Parallel) -> Cycles:
    """Execute branches at the same time; each advances once a cycle, in their order."""
    going = [(branch, run.perform(branch)) for branch in step.branches]
    failures: list[StepFailed] = []
    while going:
        for branch, cycles in list(going):
            ended, failed = _advanced(cycles)
            if ended:
                going.remove((branch, cycles))
            if failed is not None:
                failures.append(failed)
            if ended and (failed is None) == (step.until == "first"):
                yield from _stop(run, going)
                going = []
                break
        if going:
            yield
    if failures and (step.until == "all" or len(failures) == len(step.branches)):
        raise failures[0]


def monitor(run: Running, step: Monitor) -> Cycles:
    """Execute steps while a monitor watches limits of force, slip and time; a limit that is exceeded stops
    the steps and fails the monitor."""
    cycles, waited, began = run.perform(step.steps), 0.0, run.arm.gripper.opening
    while True:
        ended, failed = _advanced(cycles)
        if failed is not None:
            raise failed
        if ended:
            return
        yield
        waited += run.arm.period
        seen = _seen(run, step, waited, began)
        if seen:
            yield from _stop(run, [(step.steps, cycles)])
            raise StepFailed(f"{_label(step)}: {seen}")


def _seen(run: Running, step: Monitor, waited: float, began: float) -> str:
    """Name the limit of a monitor that is exceeded, with the measured value; "" if none is."""
    measured, closed = force(run.arm), began - run.arm.gripper.opening
    if step.force is not None and measured > step.force:
        return f"force {measured:.3f} N > {step.force:g} N"
    if step.slip is not None and closed > step.slip:
        return f"the fingers closed further by {1000 * closed:.1f} mm > {1000 * step.slip:g} mm: slip"
    if step.time is not None and waited > step.time:
        return f"not done after {waited:.3f} s > {step.time:g} s"
    return ""


def _advanced(cycles: Cycles) -> tuple[bool, StepFailed | None]:
    """Run one cycle of a branch; return whether it has ended, and its failure."""
    try:
        next(cycles)
    except StopIteration:
        return True, None
    except StepFailed as failed:
        return True, failed
    return False, None


def _stop(run: Running, going: list[tuple[tuple[AnyStep, ...], Cycles]]) -> Cycles:
    """End parallel branches of a program, and bring the arm and the gripper that they moved to rest."""
    for branch, cycles in going:
        cycles.close()
        if uses_arm(branch):
            yield from brake(run.arm, STOP)
            run.arm.end_force_mode()
        else:
            run.arm.gripper.stop()


def _label(step: AnyStep) -> str:
    return step.origin or type(step).__name__
