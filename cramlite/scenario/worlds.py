"""Worlds of a scenario: the believed one, and the one in which accepted programs are executed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from ..base.errors import PluginError, UserError, nearest
from ..base.resources import find_scenario
from ..base.seeds import whole_seed
from ..model.geometry import Pose
from ..model.world.thing import Thing
from ..model.world.world import Camera, Physics, RobotMount, World
from ..plugin.protocols import Correcting
from .faults import faulty
from .imported_world import imported_world
from .robots import imported_robot, mount_of
from .scenario import read_scenario

if TYPE_CHECKING:
    from ..model.belief import Relation
    from ..model.world.imported_scene import ImportedScene
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import ModelMaker
    from .scenario import Scenario
    from .thing_spec import ThingSpec, VarySpec


def read_world(name: str, knowledge: Knowledge, seed: int) -> World:
    """Read a world from a JSON file; or, of a run directory or a scenario, the world in which programs are
    executed.

    Raises:
        UserError: neither can be read.
    """
    path = Path(name)
    inside = (path / "execution" / "world.json", path / "world.json")  # where the former is, the latter is what was believed
    path = next((file for file in inside if file.is_file()), path)
    if path.suffix != ".json" or path.is_dir():
        scenario = read_scenario(_scenario_or_run(name))
        spec = scenario.spec
        world, relations = build_world(scenario, spec.things, spec.vary, knowledge, seed)
        return real_world(scenario, world, relations, seed)
    from msgspec import DecodeError, json

    from ..model.world.world import World

    try:
        return json.decode(path.read_bytes(), type=World)
    except OSError as error:
        raise UserError(f"The world '{path}' cannot be read: {error.strerror}.") from error
    except DecodeError as error:
        raise UserError(
            f"'{path}' holds no world: {error}. Give the world.json of a run directory, or a scenario."
        ) from error


def _scenario_or_run(name: str) -> Path:
    try:
        return find_scenario(name)
    except UserError as error:
        if not Path(name).is_dir():
            raise
        raise UserError(
            f"'{name}' is a folder that holds no world.json; give a run directory, its world.json, or a scenario."
        ) from error


def build_world(
    scenario: Scenario,
    things: Iterable[ThingSpec],
    vary: Iterable[VarySpec],
    knowledge: Knowledge,
    seed: int,
    robots: tuple[RobotMount, ...] = (),
) -> tuple[World, tuple[Relation, ...]]:
    """Build the world of a scenario, and return it with the relations that the scenario states.

    What the scenario's scene file has comes first, if the things are the scenario's own.

    Args:
        seed: 0 gives the world as written; any other draws ``vary`` from it.
        robots: as they stand where poses are read, if not as the scenario has them; what they hold stays where it was read.

    Raises:
        UserError: an unknown model, parameter or thing.
    """
    seed = whole_seed(seed)
    changes = {v.thing: v for v in vary} if seed else {}
    specs = list(things)
    imported = imported_world(scenario, knowledge) if specs == list(scenario.spec.things) else None
    built = _things(scenario, specs, changes, imported.things if imported else (), knowledge, seed)
    world = _completed(scenario, built, imported, knowledge)
    read = replace(world, robots=robots or world.robots)
    found = corrected(read, knowledge, scenario.spec.world.noise if scenario.spec.world else 0.0)
    relations = tuple(("hangs_on", spec.name, spec.hangs_on.hanger) for spec in specs if spec.hangs_on)
    return replace(found, robots=world.robots), relations


def _things(
    scenario: Scenario, specs: Sequence[ThingSpec], changes: Mapping[str, VarySpec], imported: Iterable[Thing], knowledge: Knowledge,
    seed: int,
) -> tuple[Thing, ...]:  # fmt: skip
    """Build the things of a scenario, after those of its scene file, with the random variations in ``changes``."""
    rng = np.random.default_rng([seed, 77]) if changes else None  # only then: numpy.random takes a fifth of NumPy's import
    built = {t.name: t for t in imported}
    names = [*built, *(s.name for s in specs)]
    for name in changes:
        if name not in names:
            raise UserError(f"{scenario.where('vary')}: no thing '{name}'; {nearest(name, names)}.")
    shifts: dict[str, Pose] = {}
    for thing in tuple(built.values()):
        built[thing.name] = _varied(scenario, thing, changes.get(thing.name), shifts, rng)
    models = knowledge.models_with(map(scenario.resolve_path, scenario.spec.models))
    for spec in specs:
        place = scenario.where_thing(spec.name)
        if spec.name in built:
            raise UserError(f"{place}: two things are called '{spec.name}'; names must be unique.")
        thing = _build(scenario, spec, changes.get(spec.name), built, models, rng, place)
        if thing.joint is not None and thing.joint.parent in shifts:  # what is mounted moves with what carries it
            shifts[spec.name] = shifts[thing.joint.parent]
            thing = replace(thing, pose=shifts[spec.name] * thing.pose)
        if spec.name in changes and spec.at:
            shifts[spec.name] = thing.pose * spec.at.pose().inverse()
        for part in thing.as_parts():
            if part.name in built:
                raise UserError(f"{place}: two things are called '{part.name}', one of them a part of '{spec.name}'; rename one.")
            built[part.name] = part
    return tuple(built.values())


def corrected(world: World, knowledge: Knowledge, noise: float, deep: float | None = None, staying: bool = False) -> World:
    """Return a world of measured poses in which things at impossible poses are moved to free places, each
    with a note.

    Args:
        noise: how far readings may be off [m]; with 0 the world is as it was read.
        deep: that one may be inside another [m]; None for the simulator's own limit.
        staying: whether two loose things may stay in each other if physics leaves them there: something put them there.
    """
    simulator = knowledge.simulator
    if not noise or not isinstance(simulator, Correcting):
        return world
    apart, said = simulator.put_apart(world, knowledge.robots_of(world), noise, deep, staying=staying)
    return replace(apart, notes=(*apart.notes, *said))


def _completed(
    scenario: Scenario, things: tuple[Thing, ...], imported: ImportedScene | None, knowledge: Knowledge
) -> World:
    """Return a world of some things with the scenario's robot, camera and physics.

    Physics settings of a scene file and of a gripper's pads hold where the scenario states none.
    """
    mount, read = mount_of(scenario), imported_robot(scenario, knowledge)
    robot = read.robot if read else knowledge.robots.get(mount.type)
    mount = replace(mount, type=robot.type) if robot else mount
    written = scenario.spec.physics.model_dump(exclude_unset=True)
    pads = {"pad_friction": robot.gripper.friction} if robot and robot.gripper.friction is not None else {}
    physics = Physics(**{**(imported.physics if imported else {}), **pads, **written})
    camera = camera_of(scenario)
    cameras = () if camera is None else (camera,)
    notes = (*(read.notes if read else ()), *(_pads_doubted(pads, written) if read else ()), *(imported.notes if imported else ()))
    return World(things, (mount,), physics, cameras=cameras, notes=notes)


def _pads_doubted(found: Mapping[str, float], written: Mapping[str, object]) -> tuple[str, ...]:
    """Return a remark if only the gripper's file states the friction of its pads, and the scenario does not."""
    said = "the friction of the gripper's pads is {:g}, as its file has it; 'pad_friction' of 'physics' says another"
    return tuple(said.format(value) for key, value in found.items() if key not in written)


def _varied(scenario: Scenario, thing: Thing, change: VarySpec | None, shifts: dict[str, Pose], rng: Any) -> Thing:
    """Return an imported thing at a pose varied by the seed; things that are mounted on it move with it.

    Raises:
        UserError: the scenario varies its model or parameters, which a file's thing has not.
    """
    parent = thing.joint.parent if thing.joint else ""
    moved = replace(thing, pose=shifts[parent] * thing.pose) if parent in shifts else thing
    shifts |= {thing.name: shifts[parent]} if parent in shifts else {}
    if change is None:
        return moved
    if change.model or change.parameters:
        raise UserError(
            f"{scenario.where('vary')}: '{thing.name}' comes from a scene file and has no model or parameters to vary; "
            "'position' and 'yaw' can be."
        )
    moved = replace(moved, pose=_shifted(moved.pose, change, rng))
    shifts[thing.name] = moved.pose * thing.pose.inverse()
    return moved


def camera_of(scenario: Scenario) -> Camera | None:
    """Return the scenario's camera; None if it has none.

    Raises:
        UserError: its calibration cannot be used.
    """
    if scenario.spec.camera is None:
        return None
    spec = scenario.spec.camera.calibrated(scenario.path.parent)
    mount, pose = scenario.spec.robot.name if spec.mount == "flange" else None, spec.at.pose()
    if spec.calibration is not None and mount is None:  # it is of the robot's base
        pose = scenario.spec.robot.at.pose() * pose
    return Camera(pose, mount, intrinsics=spec.pinhole(), noise=float(spec.noise), checks=spec.checks)


def real_world(scenario: Scenario, world: World, relations: Iterable[Relation], seed: int) -> World:
    """Return the world in which accepted programs are executed: the believed one with ``unknown_error`` and
    ``faults`` added.

    Args:
        world, relations: as believed.
        seed: of the run.

    Raises:
        UserError: the scenario displaces a thing that the world does not have, or has a fault of one.
    """
    error, faults = scenario.spec.unknown_error, tuple(f.fault() for f in scenario.spec.faults)
    if error is None:
        return faulty(world, faults)
    names = [t.name for t in world.things]
    if error.thing not in names:
        raise UserError(
            f"{scenario.where('unknown_error', 'thing')}: no thing '{error.thing}'; {nearest(error.thing, names)}."
        )
    rng = np.random.default_rng([seed, 78])
    way = rng.normal(size=3)
    way *= error.position * rng.uniform() ** (1 / 3) / np.linalg.norm(way)
    moving = {error.thing, *(s for p, s, o in relations if p == "hangs_on" and o == error.thing)}
    off = Pose((float(way[0]), float(way[1]), float(way[2])))
    return faulty(world.moved({name: off * world.thing(name).pose for name in moving}), faults)


def _build(
    scenario: Scenario,
    spec: ThingSpec,
    change: VarySpec | None,
    built: Mapping[str, Thing],
    models: Mapping[str, ModelMaker],
    rng: Any,
    place: str,
) -> Thing:
    model = change.model[int(rng.integers(len(change.model)))] if change and change.model else spec.model
    if model not in models:
        raise UserError(f"{place}: no object model '{model}'; {nearest(model, models)}.")
    maker = models[model]
    try:
        parameters = {k: _frozen(v) for k, v in spec.parameters.items()}
        if change:
            parameters |= {k: _frozen(v[int(rng.integers(len(v)))]) for k, v in sorted(change.parameters.items())}
        parameters |= {k: str(scenario.resolve_path(str(parameters[k])).absolute()) for k in maker.files if k in parameters}
        thing = maker.make(name=spec.name, pose=spec.at.pose() if spec.at else Pose(), **parameters)
        if not isinstance(thing, Thing):
            raise PluginError(f"{place}: the object model '{model}' makes {thing!r:.80}; it should make a cramlite.model.Thing.")
        if spec.at and model != spec.model:
            written = models[spec.model].make(name=spec.name, pose=thing.pose, **parameters)
            thing = replace(thing, pose=Pose((0.0, 0.0, _underside(written) - _underside(thing))) * thing.pose)
        thing = replace(thing, type=spec.type or thing.type, max_grip_force=spec.max_grip_force)
        if spec.hangs_on:
            thing = replace(thing, pose=_hang(spec, thing, built, maker))
    except (UserError, TypeError, ValueError) as error:
        said = str(error).removeprefix(f"thing '{spec.name}': ")
        raise UserError(f"{_where_said(scenario, spec, said) or place}: thing '{spec.name}': {said}") from error
    return replace(thing, pose=_shifted(thing.pose, change, rng)) if change else thing


def _underside(thing: Thing) -> float:
    """Return the height of the lowest corner of the boxes around a thing's geoms [m]."""
    corners = ((thing.pose * g.pose).apply([*product(*((-h, h) for h in g.half_extents))]) for g in thing.geoms)
    return min(float(c[:, 2].min()) for c in corners)


def _where_said(scenario: Scenario, spec: ThingSpec, said: str) -> str:
    """Return "file:line" of the first parameter of a thing that an error message names; "" if the scenario states no such parameter."""
    found = {k: re.search(rf"'{re.escape(k)}'|^{re.escape(k)}\b", said) for k in spec.parameters}
    named = sorted((m.start(), k) for k, m in found.items() if m is not None)
    things = [t.get("name") for t in scenario.data.get("things", ())]
    if not named or spec.name not in things:
        return ""
    return scenario.where("things", things.index(spec.name), "with", named[0][1])


def _hang(spec: ThingSpec, thing: Thing, built: Mapping[str, Thing], maker: ModelMaker) -> Pose:
    hang = spec.hangs_on
    assert hang is not None
    if hang.hanger not in built:
        raise ValueError(f"hangs on '{hang.hanger}', which is no thing that the file lists before it; {nearest(hang.hanger, built)}.")
    if maker.hung is None:
        raise ValueError(f"model '{spec.model}' cannot hang; only models with a hole can.")
    return maker.hung(thing, built[hang.hanger], hang.depth, hang.yaw)


def _shifted(pose: Pose, change: VarySpec, rng: Any) -> Pose:
    x, y = rng.uniform(-change.position, change.position, 2)
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, float(rng.uniform(-change.yaw, change.yaw))))
    moved = tuple(a + float(d) for a, d in zip(pose.position, (x, y, 0.0), strict=True))
    return Pose(moved, (turn * Pose((0, 0, 0), pose.quaternion)).quaternion)  # type: ignore[arg-type]


def _frozen(value: Any) -> Any:
    """Return a parameter of an object model as the scenario states it, with lists as tuples; the model itself
    converts units."""
    return tuple(_frozen(v) for v in value) if isinstance(value, list | tuple) else value
