"""Plausibility check of a scenario before any search: values that are possible, but probably mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..perception.camera_check import camera_warning
from ..plugin.protocols import Doubting
from .number_doubts import number_doubts

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge
    from ..scenario.scenario import Scenario
    from .setting import Setting


def doubts(scenario: Scenario, setting: Setting, knowledge: Knowledge) -> list[str]:
    """Return warnings about a scenario, each with file and line.

    They are about numbers that look like other units, masses that the arm cannot lift, things inside each other, things that stand on
    nothing, and what the camera could not look into; ``doubts_of_files`` are about the rest.
    """
    found = list(number_doubts(scenario, setting.real or setting.world, setting.robot))
    shut = setting.look.shut if setting.look else {}
    found += [f"{scenario.where('camera')}: nobody looked into '{name}': {why}" for name, why in shut.items()]
    missing = setting.look.unlocated if setting.look else {}
    found += [f"{scenario.where_thing(name)}: '{name}' is taken to be where the map has it, since {why}" for name, why in missing.items()]
    world = setting.real if setting.look and setting.real else setting.world  # as it was written, not as it was seen
    found += _camera(scenario, setting, knowledge)
    doubting = knowledge.simulator
    told = doubting.doubts(world, knowledge.robots_of(world)) if isinstance(doubting, Doubting) else ()
    return [*found, *(f"{scenario.where_thing(name)}: {said}" for name, said in told)]


def doubts_of_files(scenario: Scenario, setting: Setting) -> list[str]:
    """Return what the importers of the robot's and the things' files noted as doubtful, with the line in
    the scenario."""
    source, read = scenario.where("world" if scenario.spec.world else "robot"), _read(scenario, setting)
    things = (f"thing '{t.name}': {note}" for t in setting.world.things if t.name in read for note in t.notes)
    return [*(f"{source}: {note}" for note in setting.world.notes), *things]


def changes_of_things(scenario: Scenario, setting: Setting) -> list[str]:
    """Return the notes on a scenario's own things (not those of a scene file), such as on a repaired mesh or a
    corrected pose."""
    read = _read(scenario, setting)
    return [f"thing '{t.name}': {note}" for t in setting.world.things if t.name not in read for note in t.notes]


def _read(scenario: Scenario, setting: Setting) -> frozenset[str]:
    """Names of the things that come from a scene file."""
    if scenario.spec.world is None:
        return frozenset()
    there = setting.real if setting.look and setting.real else setting.world
    return frozenset(t.name for t in there.things) - {spec.name for spec in scenario.spec.things}


def _camera(scenario: Scenario, setting: Setting, knowledge: Knowledge) -> Iterator[str]:
    """Yield a warning if the first picture shows that the camera is not at the pose where it is believed."""
    first = setting.look.pictures[0] if setting.look and setting.look.pictures else None
    if first is not None and (off := camera_warning(first.view, first.fixtures, knowledge, first.robot)):
        yield f"{scenario.where('camera')}: {off}"
