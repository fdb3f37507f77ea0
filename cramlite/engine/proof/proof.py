"""Proof of a grounded plan: its text is written, run on the controller model, and judged."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace

from ...base.errors import DEFECTS, UserError
from ...base.pulse import checkpoint, working
from ...model.belief import Belief
from ...model.designator_name import enclosing_names, task_of
from ...model.designators import Action, Place, Stand
from ...model.entity_name import thing_of
from ...model.geometry import Vector3
from ...model.plan import Plan
from ...model.program.program import Code, Program, Snapshot
from ...model.program.program_json import typed_code
from ...model.robot import Gripper
from ...model.run.rollout import Rollout
from ...model.run.verdict import COSTS, Finding, Verdict
from ...model.world.world import World
from ...planning.goal_literals import literals_of_plan
from ...planning.refutation import InTask, Later, as_they_are
from ...planning.search.choice_point import Conflict
from ...planning.search.state import State
from ...plugin.allowance import Allowance
from ...plugin.catalogue import Knowledge
from ...plugin.protocols import Adviser, Backend, Candidate, Remarking, StandIn, Validator
from ...plugin.validation import WrongAnswer
from ..late_poses import worlds_at_tolerance
from ..setting import Setting


def assemble(plan: Plan, end: State, setting: Setting, knowledge: Knowledge) -> Candidate:
    """Assemble the typed program from a plan's search state in which every designator is grounded."""
    belief, robot = setting.belief(), setting.robot
    used = sorted({thing_of(v) for v in end.bindings.values() if isinstance(v, str)})
    snapshots = tuple(
        Snapshot(thing, belief.pose(thing), belief.poses[thing].source) for thing in used if thing in belief.poses
    )
    gripper = robot.gripper
    mass, center = load_on_the_flange(belief, gripper)
    program = Program(
        name=re.sub(r"\W", "_", setting.name),
        robot=belief.robot,
        robot_type=robot.type,
        tcp=gripper.tcp,
        start=belief.joints,
        steps=end.steps,
        sections=end.sections,
        snapshots=snapshots,
        force_limit=robot.force_limit if setting.force_limit is None else setting.force_limit,
        force_limit_of="robot" if setting.force_limit is None else "scenario",
        mass=mass,
        center=center,
    )
    scene = setting.symbolic(knowledge.taxonomy)
    return Candidate(
        plan, program, None, end.bindings, end.belief, end.actions, robot, setting.world, knowledge.rules,
        knowledge.taxonomy, goal=literals_of_plan(plan, end.actions, scene, knowledge),
        parts=end.parts, limits=setting.limits,
        allowances=allowances((*end.actions, *end.parts), end.bindings, knowledge), handovers=end.handovers,
    )  # fmt: skip


def load_on_the_flange(belief: Belief, gripper: Gripper) -> tuple[float, Vector3]:
    """Return the load of the flange at the start: the mass [kg], and its centre in the flange's frame [m]. Rails and hinges carry what the
    hand has by its handle."""
    mass, moment = gripper.mass, gripper.mass * np.array([0.0, 0.0, gripper.tcp.position[2] / 2])
    hangs = belief.held is not None and belief.world.thing(belief.held.thing).joint is None
    for name, pose in belief.in_hand().items() if hangs else ():
        own = belief.world.thing(name).mass or 0.0
        mass, moment = mass + own, moment + own * np.array((gripper.tcp * pose).position)
    x, y, z = (moment / mass).tolist() if mass else (0.0, 0.0, gripper.tcp.position[2] / 2)
    return mass, (x, y, z)


def allowances(actions: Iterable[Action], bindings: Mapping[str, Any], knowledge: Knowledge) -> dict[str, Allowance]:
    """Return the things that each action may touch and move, by the action's name."""
    return {a.name: knowledge.tasks[a.task].allowance(a, bindings) for a in actions}


def prove(candidate: Candidate, knowledge: Knowledge, backend: Backend, seed: int) -> tuple[Candidate, Verdict]:
    """Judge a candidate in the world as it is believed to be, cheap checks first; its text runs only if those pass.

    Returns:
        The candidate with code and rollout as far as they came to be, and the verdict.
    """
    candidate, findings = _prove(candidate, knowledge, backend, seed)
    return candidate, Verdict(tuple(findings), knowledge.left_out)


def _prove(
    candidate: Candidate, knowledge: Knowledge, backend: Backend, seed: int
) -> tuple[Candidate, list[Finding]]:
    findings = findings_of(candidate, knowledge, rollout=False)
    if any(not f.passed for f in findings):
        return candidate, findings
    try:
        candidate = replace(candidate, code=_code(backend.emit(candidate.program, candidate.robot)))
    except UserError as refused:
        return candidate, [*findings, Finding("code", False, f"backend '{backend.name}': {refused}")]
    except DEFECTS as error:
        owner = knowledge.registry.owner("backends", backend.name)
        fault = knowledge.registry.fault(owner, "backends", candidate.program.name, error)
        return candidate, [*findings, Finding("code", False, f"backend '{backend.name}' failed: {fault.error}")]
    remark, text = _remark(backend), text_that_runs(candidate, backend)
    findings += [Finding("execution", True, remark)] if remark else []
    if text is None:
        return candidate, findings
    ran, said = run_and_judge(candidate, text, candidate.world, knowledge, seed)
    findings += said
    if candidate.program.late and all(f.passed for f in findings):
        findings += _at_the_edges(candidate, text, knowledge, seed)
    return ran, findings


def _code(answer: object) -> Code:
    """Check that a backend returned ``Code`` (a program text with the origins of its lines), and return it.

    Raises:
        WrongAnswer: it is not; names what it is.
    """
    if not isinstance(answer, Code):
        raise WrongAnswer(f"emit gives Code, not {repr(answer)[:80]}")
    return answer


def run_and_judge(
    candidate: Candidate, text: Code, world: World, knowledge: Knowledge, seed: int
) -> tuple[Candidate, list[Finding]]:
    """Run a candidate's program text once in a world, and judge the run.

    Returns:
        The candidate with the rollout and its episode, and the findings of the validators of rollouts.
    """
    rollout = knowledge.run(text.text, world, seed, mount=candidate.program.robot)
    return judge_run(candidate, text, rollout, knowledge)


def judge_run(candidate: Candidate, text: Code, rollout: Rollout, knowledge: Knowledge) -> tuple[Candidate, list[Finding]]:
    """Judge a run of a candidate's program that was simulated elsewhere; return the candidate with this
    run, and the findings."""
    episode = knowledge.episodes.detect(rollout, candidate.program.name)
    parked = np.array(candidate.robot.home)
    episode = replace(episode, extras={**episode.extras, "park": parked})
    ran = replace(candidate, rollout=rollout, episode=episode)
    return ran, findings_of(replace(ran, code=text), knowledge, rollout=True)  # lines of a rollout are those of what ran


def _at_the_edges(candidate: Candidate, text: Code, knowledge: Knowledge, seed: int) -> list[Finding]:
    """Check that the text works with each late thing (one whose pose is asked for at run time) at the edge of
    its declared tolerance."""
    findings = []
    for said, moved in worlds_at_tolerance(candidate.world, candidate.program):
        with working(f"the program runs with {said}"):
            _, there = run_and_judge(replace(candidate, world=moved), text, moved, knowledge, seed)
        wrong = [f for f in there if not f.passed]
        reason = f"with {said}: " + (f"{wrong[0].validator}: {wrong[0].reason}" if wrong else "it came to the same end")
        findings.append(Finding("late_pose", not wrong, reason, origin=wrong[0].origin if wrong else ""))
        if wrong:
            break
    return findings


def text_that_runs(candidate: Candidate, backend: Backend) -> Code | None:
    """Return the text of a candidate that the simulator runs: the backend's text or, in its place, the typed program; None if neither
    runs."""
    if backend.executable or candidate.code is None:
        return candidate.code
    return typed_code(candidate.program) if _stands_in(backend) else None


def _stands_in(backend: Backend) -> bool:
    """Check whether the typed program runs in place of the backend's text."""
    return isinstance(backend, StandIn) and backend.typed_stands_in


def _remark(backend: Backend) -> str:
    """Return remarks for the report: whether the backend's text ran here, and what the backend itself
    remarks."""
    own = backend.remark if isinstance(backend, Remarking) else ""
    if backend.executable:
        return own
    said = own or f"text of backend '{backend.name}' cannot be run here"
    if _stands_in(backend):
        return f"{said}; its typed program ran on the controller model instead"
    return f"{said}; its typed program was checked, its text did not run"


def findings_of(
    candidate: Candidate, knowledge: Knowledge, *, rollout: bool, only: Collection[str] | None = None
) -> list[Finding]:
    """Return the findings of the validators, cheap ones first; once a validator objects, no costlier ones are
    asked.

    Args:
        rollout: ask those that look at what happened, or those that look at the program.
        only: names of validators; None asks all.
    """
    findings: list[Finding] = []
    for cost in COSTS:
        for validator in knowledge.validators:
            wanted = only is None or validator.name in only
            checkpoint()
            if wanted and validator.cost == cost and (cost == "rollout") == rollout:
                findings += _ask(validator, candidate, knowledge)
        if any(not f.passed for f in findings):
            break
    return findings


def _ask(validator: Validator, candidate: Candidate, knowledge: Knowledge) -> Iterable[Finding]:
    """Return the findings of a validator; if the validator itself fails, its fault is an objection."""
    name = validator.name
    try:
        findings = _findings(validator.check(candidate))
        advises = name in candidate.limits.advisory and isinstance(validator, Adviser) and validator.may_advise
        return [f.as_advice() for f in findings] if advises else findings
    except DEFECTS as error:
        fault = knowledge.registry.fault(knowledge.registry.owner("validators", name), "validators", name, error)
        return [Finding(name, False, f"the validator itself failed: {fault.error}")]


def _findings(answer: object) -> list[Finding]:
    """Return a validator's answer, checked to be findings.

    Raises:
        WrongAnswer: it is not; names what it is.
    """
    if not isinstance(answer, Iterable):
        raise WrongAnswer(f"check gives Findings, in a list or one after another with 'yield', not {repr(answer)[:80]}")
    findings = list(answer)
    for finding in findings:
        if not isinstance(finding, Finding):
            raise WrongAnswer(f"check gives Findings, not {repr(finding)[:80]}; write Finding(name, passed, reason)")
        if not isinstance(finding.passed, bool | np.bool_):
            raise WrongAnswer(f"'passed' of a Finding is True or False, not {repr(finding.passed)[:80]}")
    return findings


def conflict_of(verdict: Verdict, state: State) -> Conflict:
    """Return the choices of a search that may have made a proof fail.

    They are objects, places and decompositions up to the task, or the part or step of one, that failed.

    Another path between the same places would fail in the same way, so motions are left out; and so are places, where an
    objection stands that no other place changes. One that is about things depends on what was done with them first, and on how high
    or how far the hand went in between only later.
    """
    names = [name for name, _ in state.choices]
    tasks = [a.name for a in state.actions]
    anywhere = [f for f in verdict.objections if not f.places]
    failed = [task_of(f.origin) for f in anywhere or verdict.objections]
    if any(f in tasks and f not in names for f in failed):
        return frozenset()  # what the robot did before the plan began, such as looking: nothing that was chosen changes it
    known = [tasks.index(f) for f in failed if f in tasks]
    planned = [t for t in tasks if t in names]
    number = min((planned.index(tasks[k]) for k in known), default=len(planned) - 1) + 1
    beside = frozenset({InTask(number)}).union(*(as_they_are(f.blocking) for f in verdict.objections))
    last = {part: k for k, name in enumerate(names, 1) for part in enclosing_names(name)}
    ends = [next((last[n] for n in enclosing_names(f.origin) if n in last), len(names)) for f in anywhere or verdict.objections]
    names = names[: min(ends, default=len(names))]
    places = {name for name, value in state.bindings.items() if isinstance(value, Place | Stand)} if anywhere else set()
    blamed = frozenset(names) - state.motions - places
    later = _led_past(verdict, state) & blamed
    return (blamed - later) | {Later(name) for name in later} | beside


def _led_past(verdict: Verdict, state: State) -> frozenset[str]:
    """Return the places that the arm only passed on its way to another place; empty if no objection names things.

    Places of tasks are left out in which an objection names things that stand in the way.
    """
    if not any(f.things for f in verdict.objections):
        return frozenset()
    met = {task_of(f.origin) for f in verdict.objections if f.blocking}
    places = {name for name, value in state.bindings.items() if isinstance(value, Place)} - state.used
    return frozenset(name for name in places if task_of(name) not in met)
