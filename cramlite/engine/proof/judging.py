"""Judging of any program text, also one not written by cramlite: it is run in a world, and validators compare the run
with a plan or a goal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from ...base.errors import UserError
from ...base.value import Value
from ...interpretation.fluents import symbolic_world
from ...model.belief import Belief, initial_belief
from ...model.designators import Action
from ...model.episode import Episode
from ...model.plan import Plan
from ...model.program.program import Code, Program
from ...model.program.program_json import is_program_text, laid_out, read_program
from ...model.program.steps import walk
from ...model.run.judging_limits import JudgingLimits
from ...model.run.rollout import Rollout
from ...model.run.verdict import Finding, Verdict
from ...model.world.world import World
from ...planning.goal_literals import literals_of_goals, literals_of_plan
from ...plugin.catalogue import Knowledge, pick
from ...plugin.protocols import Candidate, GoalValidator
from .intent import Intent
from .line_origins import Origins, origins_by_labels, origins_of
from .proof import allowances, findings_of

LISTED = 6
"""Largest number of lines that a remark lists."""


class Purpose(Value):
    """Purpose of a program text: the plan or the goal that validators judge it by.

    Args:
        intent: of a run directory: the plan with everything that it was grounded to; None where the text is of no run.
        plan, actions: of a list of tasks whose roles are filled by name; empty where there is none.
        goal: what should hold in words, beside what the plan wants.
        limits: how far the run may disturb what no task is about; an intent has its own.
    """

    intent: Intent | None = None
    plan: Plan | None = None
    actions: tuple[Action, ...] = ()
    goal: tuple[str, ...] = ()
    limits: JudgingLimits = JudgingLimits()


class JudgedRun(Value):
    """Outcome of judging: the run of a program text, and its findings.

    Args:
        remarks: what was not judged, or could not be told for sure; for people.
    """

    rollout: Rollout
    episode: Episode
    verdict: Verdict
    remarks: tuple[str, ...]


def judge_text(text: str, world: World, purpose: Purpose, knowledge: Knowledge, seed: int) -> JudgedRun:
    """Run a program text and judge the run.

    Args:
        world: it runs in; its first robot is the one that acts.
        seed: of the sensors' noise.

    Raises:
        UserError: the text cannot run at all, a goal is none, or no line leads to a task of the plan.
    """
    text, anew = _laid_out(text)
    candidate, remarks = candidate_of_text(text, world, purpose, knowledge)
    rollout = knowledge.run(text, world, seed)
    return _judged(text, replace(candidate, rollout=rollout), (*anew, *remarks), purpose, knowledge)


def judge_rollout(text: str, rollout: Rollout, purpose: Purpose, knowledge: Knowledge) -> JudgedRun:
    """Judge the recorded run of a program text.

    Args:
        rollout: of that very text, one step a line; its world is the one that it ran in.

    Raises:
        UserError: a goal is none, or no line leads to a task of the plan.
    """
    candidate, remarks = candidate_of_text(text, rollout.world, purpose, knowledge)
    return _judged(text, replace(candidate, rollout=rollout), remarks, purpose, knowledge)


def _judged(text: str, candidate: Candidate, remarks: tuple[str, ...], purpose: Purpose, knowledge: Knowledge) -> JudgedRun:
    """Findings of the validators on a candidate's run."""
    rollout = candidate.ran
    episode = knowledge.episodes.detect(rollout, candidate.program.name)
    episode = replace(episode, extras={**episode.extras, "park": np.array(candidate.robot.home)})
    ran = replace(candidate, episode=episode)
    if not candidate.actions:
        return JudgedRun(rollout, episode, Verdict((*_ended(rollout), *_by_goal(ran, knowledge))), remarks)
    typed, more = _typed(text, ran, purpose, knowledge)
    found = [*typed, *findings_of(ran, knowledge, rollout=True)]
    return JudgedRun(rollout, episode, Verdict(tuple(found), knowledge.left_out), (*remarks, *more))


def _laid_out(text: str) -> tuple[str, tuple[str, ...]]:
    """Rewrite a program text so that each step has a line of its own; return it, with a remark if that changed it."""
    if not is_program_text(text) or (anew := laid_out(text)) == text:
        return text, ()
    old, new = (read_program(t) for t in (text, anew))
    lines: dict[int, list[int]] = {}
    for before, after in zip(walk(old.program.steps), walk(new.program.steps), strict=True):
        lines.setdefault(old.lines[id(before)], []).append(new.lines[id(after)])
    told = [f"line {k}: {min(v)} to {max(v)}" for k, v in lines.items() if len(v) > 1]
    more = ", ..." if len(told) > LISTED else ""
    said = "steps share a line of the text, so it ran written anew, one step a line; lines that are named are of that text"
    return anew, (f"{said} ({', '.join(told[:LISTED])}{more})",)


def candidate_of_text(text: str, world: World, purpose: Purpose, knowledge: Knowledge) -> tuple[Candidate, tuple[str, ...]]:
    """Return a program text as a candidate for the plan or goal that it is judged by.

    With it come remarks on lines whose task is a guess.
    """
    intent = purpose.intent
    scene = symbolic_world(world, knowledge.taxonomy)
    plan = intent.kept.plan if intent else purpose.plan or Plan("goal", (), ())
    actions = intent.kept.actions if intent else purpose.actions
    program = intent.program if intent else _bare(world, knowledge)
    origins = origins_of(text, intent.kept.code) if intent else origins_by_labels(text, [a.name for a in actions])
    if actions and not origins.of:
        raise UserError(
            "No line of the text leads to a task of the plan, so the times of tasks are unknown; name each task in a comment before "
            f"its code, such as '# {actions[0].name}', or judge the program by its goal: --goal instead of --plan."
        )
    mount = world.robots[0]
    believed = intent.kept.world if intent else world
    belief = intent.kept.belief if intent else _belief(world, knowledge)
    goal = (*literals_of_plan(plan, actions, scene, knowledge), *literals_of_goals(purpose.goal, scene, knowledge))
    bindings, parts = (intent.kept.bindings, intent.kept.parts) if intent else ({}, ())
    return Candidate(
        plan, replace(program, robot=mount.name), Code("", text, dict(origins.of), ""), bindings,
        belief, actions, pick("robot", knowledge.robots_of(world), mount.type), believed, knowledge.rules, knowledge.taxonomy, goal=goal,
        parts=parts, limits=intent.kept.limits if intent else purpose.limits,
        allowances=allowances((*actions, *parts), bindings, knowledge),
        handovers=intent.kept.handovers if intent else None,
        proven=intent.kept.code if intent else None,
    ), _remarks(origins, intent is None and bool(actions))  # fmt: skip


def _bare(world: World, knowledge: Knowledge) -> Program:
    """Return an empty program with the robot's own settings, for a text without a typed program."""
    mount = world.robots[0]
    robot = pick("robot", knowledge.robots_of(world), mount.type)
    return Program("text", mount.name, robot.type, robot.gripper.tcp, robot.start(mount)[0], (), (), force_limit=robot.force_limit)


def _belief(world: World, knowledge: Knowledge) -> Belief:
    mount = world.robots[0]
    return initial_belief(world, mount.name, *pick("robot", knowledge.robots_of(world), mount.type).start(mount))


def _remarks(origins: Origins, by_labels: bool) -> tuple[str, ...]:
    found = []
    if origins.guessed:
        lines = ", ".join(map(str, origins.guessed[:LISTED])) + (", ..." if len(origins.guessed) > LISTED else "")
        found.append(f"nothing says which task line {lines} belongs to; each is judged with the task of the line before it")
    if by_labels:
        found.append("no run directory says where the plan's things should end; its tasks are judged by their rules and contacts")
    return tuple(found)


def _typed(text: str, ran: Candidate, purpose: Purpose, knowledge: Knowledge) -> tuple[list[Finding], tuple[str, ...]]:
    """Findings of the validators that look at a typed program; for a text without a typed program, a note instead."""
    if is_program_text(text):
        return findings_of(replace(ran, program=read_program(text).program), knowledge, rollout=False), ()
    if purpose.intent is not None and text == purpose.intent.kept.code.text:
        return findings_of(ran, knowledge, rollout=False), ()
    names = ", ".join(v.name for v in knowledge.validators if v.cost != "rollout")
    return [], (f"not judged: {names}; they look at a typed program, and this text is none",)


def _by_goal(candidate: Candidate, knowledge: Knowledge) -> list[Finding]:
    """Findings of validators that judge a program text by its goal alone."""
    names = [v.name for v in knowledge.validators if isinstance(v, GoalValidator) and v.by_goal]
    return findings_of(candidate, knowledge, rollout=True, only=names)


def _ended(rollout: Rollout) -> Sequence[Finding]:
    said = f"the text ended by {rollout.outcome}: {rollout.reason}"
    return () if rollout.outcome == "finished" else (Finding("execution", False, said, stopped=True),)
