"""Answers of ``cramlite serve`` and ``cramlite mcp`` to their clients, as values for JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ...engine.engine import Engine
    from ...engine.solution import Solution
    from ...scenario.scenario import Scenario


def tasks_answer(engine: Engine) -> list[dict[str, Any]]:
    """Return every task type with its roles and parameters."""
    from ..texts import tasks_json

    return tasks_json(engine.knowledge.tasks.values())


def check_answer(engine: Engine, scenario: Scenario, seed: int) -> dict[str, Any]:
    """Check that a scenario can be used; return its name, robot and things.

    Raises:
        UserError: it cannot, or its goal cannot be planned for.
    """
    from ...planning.task_sequences import examine_goal

    setting = engine.setting(scenario, seed=seed)
    if scenario.spec.goal is not None:
        examine_goal(scenario, setting.symbolic(engine.knowledge.taxonomy), engine.knowledge)
    return {
        "scenario": scenario.name,
        "robot": setting.robot.type,
        "things": [t.name for t in setting.world.things],
    }


def things_answer(engine: Engine, scenario: Scenario, seed: int) -> dict[str, Any]:
    """Return the believed things of a scenario.

    Of each: class, position [m] and quaternion (w first) in the world's frame, whether it can be moved, and what was changed or
    concluded when it was made; and the relations that hold at the start.

    Raises:
        UserError: the scenario cannot be used.
    """
    setting = engine.setting(scenario, seed=seed)
    things = [
        {"name": t.name, "class": t.type, "position": t.pose.position, "quaternion": t.pose.quaternion,
         "movable": t.movable, "notes": t.notes}
        for t in setting.world.things
    ]  # fmt: skip
    return {"scenario": scenario.name, "robot": setting.robot.type, "things": things, "relations": setting.relations}


def goals_answer(engine: Engine, scenario: Scenario, seed: int) -> dict[str, Any]:
    """Return the forms that goals can have, the scenario's own goal, and the first plan that achieves it.

    Raises:
        UserError: the scenario cannot be used, or no tasks achieve its goal.
    """
    from ...planning.operators import Grounder
    from ...planning.trace import Trace

    engine = engine.suited(scenario)
    setting, knowledge = engine.setting(scenario, seed=seed), engine.knowledge
    phrases = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates).fluents.phrases
    asked = scenario.spec.goal is not None
    plan = next((p for p, _ in engine.plans(scenario, setting, Trace())), None) if asked else None
    return {
        "forms": sorted(p.form for p in phrases), "things": [t.name for t in setting.world.things],
        "goal": scenario.spec.goal, "plan": None if plan is None else str(plan),
    }  # fmt: skip


def interpret_answer(engine: Engine, episode: Path) -> dict[str, Any]:
    """Return every task that each action of an episode may have been.

    Raises:
        UserError: it cannot be read, or has no events.
    """
    return engine.interpret(engine.read_episode(episode)).to_json()


def solution_answer(solution: Solution) -> dict[str, Any]:
    """Return a proven program as an answer: plan, text, chosen things, findings, and the tasks that
    achieve each goal."""
    from ...planning.goal_parts import goal_answers

    bound = solution.candidate.bindings
    return {
        "headline": solution.headline, "plan": str(solution.plan), "code": solution.code, "findings": solution.verdict.findings,
        "left_out": solution.verdict.left_out, "goal": goal_answers(solution.trace, solution.number),
        "objects": {o.name: bound.get(o.name) for o in solution.plan.objects},
    }  # fmt: skip
