"""Replanning at run time, for ``cramlite execute --replan``: run, look, resolve the rest.

A program that stops by itself says why. The scenario's camera then looks at the world as the run left it, and what it sees is
all that is believed of things that can be moved. What is left of the plan is resolved from where the robot stands, and runs.
The simulator's poses go from one run to the next, since the world goes on; nobody who decides is shown them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.errors import NoSolution, UserError
from ...base.json_text import as_json
from ...base.value import Value
from ...model.program.program_json import typed_code
from ...model.program.steps import MoveJoints, SetGripper, walk
from ...model.run.rollout import world_after_run
from ...planning.failure import brief_failure_text, failure_text
from ...planning.task_sequences import LISTED
from ...planning.trace import Trace
from ...scenario.robots import robot_of
from ..setting import Setting

if TYPE_CHECKING:
    from ...model.geometry import Floats
    from ...model.plan import Plan
    from ...model.program.program import Code, Program
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...plugin.protocols import Candidate
    from ...scenario.scenario import Scenario
    from ..engine import Engine

BACK = "0.Back"
"""Designator of the motion that leads the arm back to the program's start."""
NEAR = 0.02  # how far the way back may be from the way there, in any joint [rad]
SLOW = 0.5  # and how fast [rad/s]
Say = Callable[[str], None]


class Attempt(Value):
    """Program to be run, with its plan and its world.

    Args:
        plan: what it carries out.
        program, code: the program and its text.
        world: as it really is when it starts, the robot's posture included.
        candidate: that was proven; None where nobody knows what the program's tasks were grounded to.
    """

    plan: Plan
    program: Program
    code: Code
    world: World
    candidate: Candidate | None = None


class Round(Value):
    """Round of an execution with replanning: one run of a program, and how it ended."""

    attempt: Attempt
    rollout: Rollout

    @property
    def step(self) -> str:
        """Designator of the step in which the program ended."""
        lines = [int(v) for v in self.rollout.lines if v > 0]
        before = [k for k in self.attempt.code.origins if lines and k <= lines[-1]]
        return self.attempt.code.origins[max(before)] if before else ""

    @property
    def said(self) -> str:
        """End of the run as a sentence for people."""
        if self.rollout.outcome == "finished":
            return f"finished after {self.rollout.times[-1]:.1f} s"
        where = f" in {self.step}" if self.step else " before the first step"
        return f"{self.rollout.outcome}{where}: {self.rollout.reason}"


def rounds(first: Attempt, scenario: Scenario, engine: Engine, *, seed: int, most: int, say: Say, verbose: bool = False) -> Iterator[Round]:
    """Run a program; when it stops with a reason, let the camera look, resolve the rest of the plan and run
    that; when it comes to its end, let the camera look, resolve the next stage of the scenario's ``then`` and
    run that: at most ``most`` programs.

    Args:
        verbose: whether a refusal has every cause, or three lines.

    Yields:
        Each round when it has ended; the last one finished, or nothing more is tried.

    Raises:
        NoSolution: it cannot go on, and why.
    """
    attempt, stage = first, 0
    for number in range(1, most + 1):
        done = _run(attempt, engine, seed)
        say(f"round {number}: {done.said}")
        yield done
        if done.rollout.outcome == "finished" and stage < len(scenario.spec.then) and number < most:
            attempt, stage = _stage(done, scenario, engine, seed, (stage, number + 1), say, verbose), stage + 1
            continue
        if done.rollout.outcome == "finished" and stage == len(scenario.spec.then):
            return
        if done.rollout.outcome not in ("halted", "finished"):
            raise NoSolution(
                f"Round {number} ended by {done.said}. Only a program that stopped by itself is planned anew."
            )
        if number == most:
            raise NoSolution(f"Given up after {most} rounds. The last one: {done.said}")
        attempt = _next(done, scenario, engine, seed, number + 1, say, verbose)


def _run(attempt: Attempt, engine: Engine, seed: int) -> Round:
    return Round(attempt, engine.knowledge.run(attempt.code.text, attempt.world, seed))


def _next(done: Round, scenario: Scenario, engine: Engine, seed: int, number: int, say: Say, verbose: bool) -> Attempt:
    """Let the camera look after a stopped round, resolve the rest of the plan, and return its program.

    Raises:
        NoSolution: something is in the hand, or what is left cannot be done with what is seen.
    """
    plan, now = remaining_plan(done), _after(_back(done, engine, seed, number, say))
    setting = engine.setting(scenario, seed=seed, now=now, rest=plan)
    assert setting.look is not None and setting.real is not None
    seen = ", ".join(f"{n} {e.source}" for n, e in setting.look.estimates.items()) or "nothing that it knows"
    say(f"round {number}: the camera sees {seen}; left to do: {plan}")
    trace = Trace()
    from ...planning.search.budget import budget_of
    from ..candidates import attempts
    from ..search_in_setting import search_in

    search = search_in(setting, engine.knowledge, budget_of(scenario), trace)
    found = attempts(search, plan, setting, engine.knowledge, engine.executors)
    candidate = next((c for c, verdict in found if verdict.passed), None)
    if candidate is None or candidate.code is None:
        why = (failure_text if verbose else brief_failure_text)(trace, engine.registry.faults)
        raise NoSolution(f"Round {number}: the remaining tasks cannot be done.\n{why}")
    return Attempt(plan, candidate.program, candidate.code, setting.real)


def _stage(
    done: Round, scenario: Scenario, engine: Engine, seed: int, which: tuple[int, int], say: Say, verbose: bool
) -> Attempt:  # fmt: skip
    """Let the camera look after a program has come to its end, resolve a stage of the scenario's ``then``, and return its program.

    Args:
        which: number of the stage, from 0, and of the round that it is run in.

    Raises:
        NoSolution: neither the stage nor its ``else`` can be done with the things that are seen.
    """
    from .open_stages import stage_program

    (stage, number), now = which, _after(done)
    failure = failure_text if verbose else brief_failure_text
    found, why = stage_program(scenario, stage, engine, seed, lambda s: engine.setting(s, seed=seed, now=now), failure)
    if found is None or found.setting.real is None or found.candidate.code is None:
        raise NoSolution(f"Round {number}: {why}")
    say(f"round {number}: {why}")
    return Attempt(found.plan, found.candidate.program, found.candidate.code, found.setting.real, found.candidate)


def _back(done: Round, engine: Engine, seed: int, number: int, say: Say) -> Round:
    """Lead the arm back the way it came, by its own encoders, to the program's start, since nobody knows the
    things around it before the camera has looked.

    Raises:
        NoSolution: it did not get there.
    """
    program, world = done.attempt.program, _after(done)
    path = way_back(done.rollout.joints)
    if not path:
        return done
    robot = engine.knowledge.robots_of(world)[program.robot_type]
    back = back_program(program, path, world.robots[0].joints)
    code = engine.knowledge.backends[robot.backend].emit(back, robot)
    there = _run(Attempt(done.attempt.plan, back, code, world), engine, seed)
    if there.rollout.outcome != "finished":
        raise NoSolution(f"Round {number}: the arm does not get back along the path on which it came: {there.said}")
    say(f"round {number}: the arm went back the way it came")
    return there


def back_program(program: Program, path: tuple[tuple[float, ...], ...], start: tuple[float, ...]) -> Program:
    """Return a program that moves the arm of a given program from start joint positions along a path [rad]."""
    step = MoveJoints(path, SLOW, 1.0, origin=BACK, comment="the way it came")
    return replace(program, steps=(step,), sections=(), snapshots=(), late=(), start=start)


def way_back(joints: Floats) -> tuple[tuple[float, ...], ...]:
    """Return a path back through recorded joint positions (n, axes) [rad], with the fewest points that follow
    them within ``NEAR``.

    It is () for a robot that has not moved.
    """
    import numpy as np

    def straight(a: int, b: int) -> bool:
        gone, way = joints[a : b + 1] - joints[a], joints[b] - joints[a]
        along = np.clip(gone @ way / max(float(way @ way), 1e-12), 0.0, 1.0)[:, None]
        return bool(np.abs(gone - along * way).max() <= NEAR)

    path, at = [], len(joints) - 1
    while at > 0 and np.abs(joints[: at + 1] - joints[at]).max() > NEAR:
        low, high = 0, at - 1  # the first sample from which it went straight to here
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if straight(middle, at) else (middle + 1, high)
        at = low
        path.append(tuple(map(float, joints[at])))
    return tuple(path)


def remaining_plan(done: Round) -> Plan:
    """Return the rest of a plan: from the last task that began with an empty hand, and that the run had reached.

    Raises:
        NoSolution: the program stopped with something in the hand.
    """
    plan, program = done.attempt.plan, done.attempt.program
    if not done.step:
        return plan
    names = [a.name for a in plan.actions]
    held, start = False, 0
    firsts = {s.first: s.task for s in program.sections}
    for k, step in enumerate(program.steps):
        if firsts.get(k) in names and not held:
            start = names.index(firsts[k])
        for inner in walk((step,)):
            if inner.origin == done.step:
                break
            if isinstance(inner, SetGripper):
                held = inner.expect == "object"
        else:
            continue
        break
    if held:
        raise NoSolution(
            f"The program ended in {done.step} with something in the hand ({done.rollout.reason}). A payload cannot be "
            "looked at, and is not planned for: take it out, or put it back where it was, and run 'cramlite resolve' again."
        )
    return replace(plan, actions=plan.actions[start:])


def _after(done: Round) -> World:
    return world_after_run(done.rollout, done.attempt.world)


def planned(text: str, program: Program, plan: str, scenario: Scenario, engine: Engine, seed: int) -> tuple[Plan, Code]:
    """Return the plan and the code of a program that ``cramlite resolve`` wrote, from its text, typed program
    and plan.json.

    Args:
        plan: the content of plan.json.

    Raises:
        UserError: the text is not that of the program, or the plan is none of the scenario.
    """
    knowledge = engine.knowledge
    robot = robot_of(scenario, knowledge)
    code = next((c for c in _codes(program, robot, engine) if c.text == text), None)
    if code is None:
        raise UserError(
            "The text is not the one of the program.json beside it, so nobody knows which task a line belongs to: give the "
            "program of a run directory as 'cramlite resolve' wrote it."
        )
    known = _furniture(scenario, engine, seed) if scenario.spec.poses == "camera" else engine.setting(scenario, seed=seed)
    found = (p for p, _ in islice(engine.plans(scenario, known, Trace()), LISTED))
    own = next((p for p in found if as_json(p) == plan), None)
    if own is None:
        raise UserError(
            f"The plan.json beside the program is no plan of '{scenario.path}': give the scenario that it was made from."
        )
    return own, code


def _codes(program: Program, robot: object, engine: Engine) -> Iterable[Code]:
    yield typed_code(program)
    for backend in engine.knowledge.backends.values():
        try:
            yield backend.emit(program, robot)  # type: ignore[arg-type]
        except UserError:
            continue


def _furniture(scenario: Scenario, engine: Engine, seed: int) -> Setting:
    from ...scenario.worlds import build_world

    spec, knowledge = scenario.spec, engine.knowledge
    world, _ = build_world(scenario, spec.things, spec.vary, knowledge, seed)
    robot = robot_of(scenario, knowledge)
    fixed = replace(world, things=tuple(t for t in world.things if t.furniture))
    return Setting(scenario.name, fixed, (), robot, knowledge.backends[robot.backend], seed, force_limit=spec.force_limit)
