"""Settings from scenarios: the world that is believed, and where each pose comes from."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError, nearest
from ..model.twins.error_model import ErrorModel
from ..model.twins.proof_doubts import ProofDoubts
from ..plugin.catalogue import pick
from ..plugin.protocols import Adviser
from ..scenario.asked_text import asked_text
from ..scenario.faults import foreseen
from ..scenario.robots import robot_of
from ..scenario.worlds import build_world, real_world
from .number_doubts import doubted_sizes
from .setting import Setting, with_load

if TYPE_CHECKING:
    from ..model.plan import Plan
    from ..model.robot import Robot
    from ..model.world.world import World
    from ..perception.view_queries import Queries
    from ..plugin.catalogue import Knowledge
    from ..scenario.scenario import Scenario
    from .late_poses import Tolerance

TWINS_VARIABLE = "CRAMLITE_TWINS"
"""Environment variable: how many twins a program is tried in, where neither caller nor scenario says it; for test suites."""
Likeliest = Callable[[Setting], "Plan | None"]
"""Function that returns the plan that is likeliest to be carried out in a setting."""


def setting_of(
    scenario: Scenario, knowledge: Knowledge, likeliest: Likeliest,
    *, seed: int = 0, backend: str | None = None, now: World | None = None, twins: int | None = None,
) -> Setting:  # fmt: skip
    """Build the setting of a scenario: world, robot, backend and initial belief; ``Engine.setting`` calls
    this.

    Args:
        likeliest: says what a camera looks for.
        now: the world as it really is by now.
        twins: how many, whatever the scenario says.

    Raises:
        UserError: an unknown robot, model, backend or thing; a query that a camera cannot answer.
    """
    robot = robot_of(scenario, knowledge)
    name = backend or scenario.spec.backend or robot.backend
    place = scenario.where("backend") if scenario.spec.backend == name else ""
    writer = pick("backend", knowledge.backends, name, place)
    world, relations = build_world(scenario, scenario.spec.things, scenario.spec.vary, knowledge, seed, now.robots if now else ())
    _check_world(scenario, replace(world, robots=()) if now else world, knowledge)  # the arm has left its first posture by now
    _check_objects(scenario, knowledge)
    _check_sought(scenario, world)
    if now is not None:
        world = replace(world, robots=now.robots)
    real = real_world(scenario, world, relations, seed) if scenario.spec.unknown_error or scenario.spec.faults else None
    world = foreseen(real.faults, world) if real is not None else world
    _check_advisory(scenario, knowledge)
    _check_kept(scenario, world)
    force, limits = scenario.spec.force_limit, scenario.spec.limits.judging()
    doubts = _doubts(scenario, world, robot, twins)
    setting = Setting(scenario.name, world, relations, robot, writer, seed, real, force_limit=force, limits=limits, doubts=doubts)
    setting = with_load(replace(setting, title=scenario.spec.title, asked=asked_text(scenario.spec)), knowledge)
    told = _told(scenario, knowledge)
    if scenario.spec.poses == "camera":
        setting = _seen(scenario, setting, knowledge, told, likeliest, now)
        if now is not None:
            return setting  # what was late has been looked at since
    return replace(setting, late=_late(scenario, setting.world))


def _seen(
    scenario: Scenario, written: Setting, knowledge: Knowledge, told: Queries, likeliest: Likeliest, now: World | None
) -> Setting:
    """Return the setting with those movable things only that the scenario's camera has seen, at the poses it found.

    The camera looks for the ``told`` queries, else for the objects of the likeliest plan. For a goal, whose
    plan needs the pictures, it looks at all furniture, and then in and behind closed things.

    Raises:
        NoSolution: what is looked for may be where the camera cannot be brought to look, and is nowhere else.
    """
    from ..perception.active_perception import look, mapped
    from ..perception.view_queries import queries_everywhere, queries_of

    world, real = replace(written.world, poses="camera"), replace(now or written.real or written.world, poses="camera")
    furniture = mapped(scenario, world)
    plan = None if told or scenario.spec.goal else likeliest(replace(written, world=furniture, relations=(), real=None))
    wanted = queries_of(plan, furniture, knowledge.taxonomy, knowledge.tasks) if plan else told
    if scenario.spec.goal and not told:
        wanted = queries_everywhere(furniture, knowledge.taxonomy)
    seen = look(scenario, wanted, world, real, written.robot, knowledge, written.seed)
    setting = replace(written, world=seen.world, relations=seen.relations, real=seen.real, look=seen)
    if told or now is not None:
        meant = not seen.missed
    else:
        from .exploration import explored, is_meant  # with the proofs, which a check of a scenario does without

        setting = explored(setting, scenario, plan, knowledge)
        meant = not seen.missed or is_meant(setting, scenario, plan, knowledge)
    if not meant:
        raise NoSolution(seen.missed[0])
    return setting


def _told(scenario: Scenario, knowledge: Knowledge) -> Queries:
    """Return the queries of a scenario's camera; they are checked also if poses are known and no camera is
    used.

    Raises:
        UserError: a query that is wrong, or asks for what no expert says; with file and line.
    """
    from ..perception.query import parse_query

    told = scenario.spec.camera.queries if scenario.spec.camera is not None else ()
    places = (scenario.where("camera", "queries", k) for k in range(len(told)))
    return tuple((parse_query(t, knowledge.taxonomy, knowledge.experts, p),) for t, p in zip(told, places, strict=True))


def _check_world(scenario: Scenario, world: World, knowledge: Knowledge) -> None:
    """Check, before the search begins, that the classes of all things are known and that the simulator can
    load the world."""
    for thing in world.things:
        knowledge.taxonomy.known(thing.type, f"{scenario.where_thing(thing.name)}: thing '{thing.name}'")
    try:
        knowledge.simulator.check(world, knowledge.robots_of(world))
    except UserError as error:
        named = [t for t in world.things if f"'{t.name}'" in str(error)]
        size = next(doubted_sizes(scenario, named), "")
        raise UserError(f"{size or f'{_to_move(scenario, world, str(error))}: {error}'}.") from error


def _to_move(scenario: Scenario, world: World, said: str) -> str:
    """Return "file:line" of the thing or robot in an error message that is the easiest to place elsewhere.

    Loose things are preferred to the robot, and the robot to furniture.
    """
    named = [t for t in world.things if f"'{t.name}'" in said]
    loose = [t for t in named if not t.furniture]
    if not loose and any(f"'{m.name}'" in said for m in world.robots):
        return scenario.where("robot", "at")
    first = next(iter(loose or named), None)
    return scenario.where_thing(first.name) if first else scenario.where("things")


def _check_objects(scenario: Scenario, knowledge: Knowledge) -> None:
    """Check that the classes which describe objects are known, since anything would fit an unknown one.

    Raises:
        UserError: one is not; with file and line.
    """
    for name, wanted in scenario.spec.objects.items():
        for key in ("types", "features", "affords"):
            for k, said in enumerate(getattr(wanted, key)):
                knowledge.taxonomy.known(said, f"{scenario.where('objects', name, key, k)}: '{key}' of object '{name}'")


def _check_advisory(scenario: Scenario, knowledge: Knowledge) -> None:
    """Check that the scenario's advisory validators exist, and that each of them declares ``may_advise``.

    Raises:
        UserError: one is not, or does not; with file and line.
    """
    names = [v.name for v in knowledge.validators]
    may = [v.name for v in knowledge.validators if isinstance(v, Adviser) and v.may_advise]
    for k, name in enumerate(scenario.spec.limits.advisory or ()):
        place = scenario.where("limits", "advisory", k)
        if name not in names:
            raise UserError(f"{place}: no validator '{name}'; {nearest(name, names)}.")
        if name not in may:
            others = f"only {', '.join(may)} may" if may else "none that is installed may"
            said = "may not advise only, since a program that it refuses is none"
            raise UserError(f"{place}: validator '{name}' {said}; {others}. Take it out.")


def _check_sought(scenario: Scenario, world: World) -> None:
    """Check that the things which a scenario's camera is to find are furniture of the scenario's own.

    Raises:
        UserError: one is not; with file and line.
    """
    own = {spec.name for spec in scenario.spec.things}
    fixed = [t.name for t in world.things if t.furniture and t.name in own]
    for k, name in enumerate(scenario.spec.camera.finds if scenario.spec.camera else ()):
        if name not in fixed:
            place = scenario.where("camera", "finds", k)
            raise UserError(f"{place}: no thing '{name}' of the scenario's that is fixed; {nearest(name, fixed)}.")


def _check_kept(scenario: Scenario, world: World) -> None:
    """Check that the things that must keep their place are in the world.

    Raises:
        UserError: one is not; with file and line.
    """
    names = [t.name for t in world.things]
    for name in scenario.spec.limits.keep or {}:
        if name not in names:
            raise UserError(f"{scenario.where('limits', 'keep', name)}: no thing '{name}'; {nearest(name, names)}.")


def _late(scenario: Scenario, world: World) -> dict[str, Tolerance]:
    """Things of a scenario whose poses the program asks for when it runs, with their tolerances.

    Raises:
        UserError: a thing that the world does not have, or that cannot be moved.
    """
    movable = [t.name for t in world.things if t.movable]
    for k, late in enumerate(scenario.spec.late):
        if late.thing not in movable:
            place = scenario.where("late", k, "thing")
            raise UserError(f"{place}: no thing '{late.thing}' that can be moved; {nearest(late.thing, movable)}.")
    return {late.thing: (late.position, late.yaw) for late in scenario.spec.late}


def _doubts(scenario: Scenario, world: World, robot: Robot, twins: int | None) -> ProofDoubts:
    """Return the doubts of a scenario: the number of twins and the errors in which its programs must succeed.

    Raises:
        UserError: errors of a thing that the world does not have, with file and line; a number of twins that is none.
    """
    spec, names = scenario.spec.proof, [t.name for t in world.things]
    for k, error in enumerate(spec.errors.things):
        if error.thing not in names and scenario.spec.poses == "known":
            place = scenario.where("proof", "errors", "things", k, "thing")
            raise UserError(f"{place}: no thing '{error.thing}'; {nearest(error.thing, names)}.")
    asked = spec.twins if twins is None else twins
    count = _usual_twins() if asked is None else asked
    return ProofDoubts(count, spec.at_least, spec.errors.errors(ErrorModel(), robot.sensor_errors))


def _usual_twins() -> int:
    """Number of twins if neither caller nor scenario gives one: that of the environment variable
    ``TWINS_VARIABLE``, else 8.

    Raises:
        UserError: the variable holds no whole number.
    """
    said = os.environ.get(TWINS_VARIABLE, "")
    if said and not said.isdecimal():
        raise UserError(f"{TWINS_VARIABLE} is '{said}'; it is a whole number of twins, 0 for none.")
    return int(said) if said else ProofDoubts().twins
